"""Summary of a run: the content of summary.json as frozen values (docs/architecture.md)."""

from __future__ import annotations

import json
from collections.abc import Mapping

import msgspec
from msgspec import UNSET, UnsetType


class TrackingError(msgspec.Struct, frozen=True, kw_only=True):
    """Cross-track error of the follower: root mean square and maximum [m]; None if it never followed a path."""

    cross_rms: float | None = None
    cross_max: float | None = None


class SolveTime(msgspec.Struct, frozen=True, kw_only=True):
    """Solve time of the follower on the wall clock: median and 99th percentile [s]; None if nothing was measured."""

    median: float | None = None
    p99: float | None = None


class Localisation(msgspec.Struct, frozen=True, kw_only=True):
    """Error of an agent's pose estimate against the simulator's ground-truth pose.

    Attributes:
        position_rms: Position error, root mean square [m].
        position_max: Maximum position error [m].
        heading_rms: Heading error, root mean square [rad].
        heading_max: Maximum heading error [rad].
        nees: Mean of the normalised estimation error squared over its 3 dimensions; 1 for a consistent estimate.
    """

    position_rms: float
    position_max: float
    heading_rms: float
    heading_max: float
    nees: float


class Following(msgspec.Struct, frozen=True, kw_only=True):
    """Ground-truth distance of a follower from its leader (paper, 6.5); None if not measured.

    Attributes:
        leader: Name of the robot that is followed.
        periods: Number of evaluated control periods.
        mean_distance: Mean distance [m].
        distance_error: Mean absolute error of the distance [m].
        in_band: Share of the periods within the follow band.
        too_far: Share of the periods beyond the follow band.
        least_distance: Minimum distance [m].
        least_driving: Minimum distance while the follower moved [m].
        safe: Whether `least_driving` is at least the safety distance.
    """

    leader: str
    periods: int
    mean_distance: float | None
    distance_error: float | None
    in_band: float | None
    too_far: float | None
    least_distance: float | None
    least_driving: float | None
    safe: bool


class Finding(msgspec.Struct, frozen=True, kw_only=True):
    """Result of one requirement.

    Attributes:
        name: Name of the requirement.
        require: Text of the requirement.
        verdict: `satisfied`, `violated`, or `unknown` if no violation was seen but some samples had no value.
        margin: Minimum margin (robustness), negative if violated; None if unknown or unbounded.
        unit: Unit of the margin; empty for mixed units, where each comparison is normalised by its signals' span.
        worst: Time of the minimum margin [s]; None if the margin is unknown.
        violated: Time of the first violation [s]; None if there was none.
        samples: Number of samples at which the requirement was evaluated.
        unknown: Number of these samples without a value, because a signal was invalid.
        reading: Values at the first violation, else at the minimum margin, such as `speed = 1.2 m/s`; may be empty.
    """

    name: str
    require: str
    verdict: str
    margin: float | None
    unit: str
    worst: float | None
    violated: float | None
    samples: int
    unknown: int
    reading: str = ""


class AgentResult(msgspec.Struct, frozen=True, kw_only=True):
    """Result of one agent, SI units; None for values that were not measured.

    Attributes:
        robot: Name of the robot.
        mission: Name of the mission.
        rules: Names of the rule files.
        inactive_rules: Required signals that the robot lacks, by rule that is therefore inactive.
        outcome: Outcome (docs/architecture.md).
        reason: Reason of the outcome.
        time_to_goal: Time at which the goal was reached [s].
        failed_block: First block or actuator that failed.
        failed_owner: `engine` or `content`, for `failed_block`.
        faults: One sentence for each fault, with its time.
        exceptions: Number of exceptions of content by its kind and name.
        goals_reached: Number of goals entered.
        path_length: Length of the path [m]; in space for a robot that flies.
        min_clearance: Minimum distance from the hull to a geom [m].
        collisions: Number of collisions.
        struck: Number of contacts that the motion of the robot did not cause.
        contacts: Number of contacts by kind and geom.
        fell: Whether the robot fell, whatever the outcome.
        reflex_activations: Number of activations of rules.
        reflex_refirings: Number of re-firings of latched rules after the end of their actions.
        route_switches: Number of changes between the deliberative and the reactive route.
        time_reactive: Time commanded by reflexes [s].
        time_deliberative: Time commanded by the plan [s].
        replans: Number of actions that were submitted again after a reflex.
        commands_limited: Number of commands that the safety gate scaled, by action.
        actions: Number of actions by name and result.
        tracking_error: Cross-track error of the follower.
        solve_time: Solve time of the follower.
        localisation: Error of the pose estimate; None for an agent that does not localise.
        following: Distance from a leader; None for an agent that does not follow.
        sharing: Counts of shared knowledge; None for an agent that does not share.
        requirements: Results of the scenario's requirements.
    """

    robot: str
    mission: str
    rules: tuple[str, ...]
    outcome: str
    inactive_rules: Mapping[str, tuple[str, ...]] = {}
    reason: str = ""
    time_to_goal: float | None = None
    failed_block: str | None = None
    failed_owner: str | None = None
    faults: tuple[str, ...] = ()
    exceptions: Mapping[str, int] = {}
    goals_reached: int | None = None
    path_length: float = 0.0
    min_clearance: float | None = None
    collisions: int | None = None
    struck: int | None = None
    contacts: Mapping[str, Mapping[str, int]] | None = None
    fell: bool | None = None
    reflex_activations: int = 0
    reflex_refirings: int = 0
    route_switches: int = 0
    time_reactive: float = 0.0
    time_deliberative: float = 0.0
    replans: int = 0
    commands_limited: Mapping[str, int] = {}
    actions: Mapping[str, Mapping[str, int]] = {}
    tracking_error: TrackingError = TrackingError()
    solve_time: SolveTime = SolveTime()
    localisation: Localisation | None = None
    following: Following | None = None
    sharing: Mapping[str, int | float] | None = None
    requirements: tuple[Finding, ...] = ()


class Remembered(msgspec.Struct, frozen=True, kw_only=True):
    """Knowledge of earlier runs loaded by an agent: numbers of nodes and edges, and reasons of refused items."""

    nodes: int
    edges: int
    refused: tuple[str, ...] = ()


class KnowledgeFile(msgspec.Struct, frozen=True, kw_only=True):
    """Knowledge kept between runs: its file, and the knowledge loaded by each agent."""

    file: str
    remembered: Mapping[str, Remembered]


class Summary(msgspec.Struct, frozen=True, kw_only=True):
    """Summary of a run, with the keys of summary.json.

    Attributes:
        scenario: Name of the scenario.
        seed: Seed of the episode.
        mode: `lockstep` or `threaded`.
        simulated: Whether the world was simulated.
        versions: Versions by package.
        content_hash: sha256 of all content used.
        sim_time: Duration of the run [s].
        wall_time: Wall-clock duration of the run [s]; None if unknown.
        real_time_factor: `sim_time` divided by `wall_time`.
        trajectory_hash: sha256 of the float64 generalised positions at all control periods; None if unknown.
        agents: Results by agent, in the scenario's order.
        knowledge: Knowledge kept from run to run; without a file of knowledge UNSET, and no key in summary.json.
    """

    scenario: str
    seed: int
    mode: str
    simulated: bool = True
    versions: Mapping[str, str] = {}
    content_hash: str = ""
    sim_time: float
    wall_time: float | None = None
    real_time_factor: float | None = None
    trajectory_hash: str | None = None
    agents: Mapping[str, AgentResult]
    knowledge: KnowledgeFile | UnsetType = UNSET

    def to_json(self) -> str:
        """The text of summary.json."""
        return json.dumps(msgspec.to_builtins(self), indent=2) + "\n"
