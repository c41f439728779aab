"""EpisodeRunner: plays episodes one by one and caches loaded content; and the function that worker processes run."""

from __future__ import annotations

import math
import multiprocessing
import signal
import threading
import time
from collections import OrderedDict
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.errors import InputError, unknown
from ..catalog import AgentSpec, CachingCatalog, PlannerSpec, RequirementSpec, ScenarioSpec
from ..declare import replaced
from ..devices.mujoco import MujocoWorld
from ..event import BodyMoved, Event, unpack
from ..running import Run, RunOptions
from ..simulation import SimulatedWorld
from .company import Company
from .episode import Episode, FamilyScene, ScenarioScene, SceneRef
from .family import AGENT, load_family, scene_of
from .metric import METRICS, ZERO_ON_FAILURE, EpisodeData, measure_all
from .record import EpisodeRecord
from .store import Cost

SCENES = 4
"""Maximum number of cached scenes; few suffice, because a sweep proceeds scene by scene."""


@dataclass(frozen=True)
class PreparedScene:
    """Scene with its scenario loaded, ready to be played.

    Attributes:
        catalog: Source of the scene's content.
        scenario: Scenario of the scene, before a planner is assigned to an agent.
        agent: Name of the agent to which the planner under test is assigned.
        reference_length: Length of a shortest path from start to goal [m]; 0 if unknown.
        difficulty: Difficulty measures by name.
        privileged: Ground-truth information that only oracle planners get.
    """

    catalog: CachingCatalog
    scenario: ScenarioSpec
    agent: str
    reference_length: float
    difficulty: Mapping[str, float] = field(default_factory=dict)
    privileged: Mapping[str, Any] = field(default_factory=dict)

    def with_planner(self, planner: PlannerSpec) -> ScenarioSpec:
        """The scenario with a planner assigned to the agent under test; oracles also get `privileged`.

        Raises:
            InputError: The planner's robot does not fit the scenario.
        """
        scenario = planner.drives(self.scenario, self.agent, self.privileged)
        if planner.robot:
            self.catalog.check_robots(scenario)
        return scenario


class EpisodeRunner:
    """Plays episodes, and caches catalogs, compiled worlds and rules between them; this does not change results.

    Args:
        project: Project that contains the content; None for shipped content.
        code: Whether Python content may run.
    """

    def __init__(self, project: Path | None = None, *, code: bool = True) -> None:
        self.catalog = CachingCatalog(project, code=code)
        self._prepared: OrderedDict[SceneRef, PreparedScene] = OrderedDict()

    def prepare(self, scene: SceneRef) -> PreparedScene:
        """Load or generate a scene.

        Raises:
            InputError: The scenario, family or agent does not exist, or its content is invalid.
        """
        if scene not in self._prepared:
            self._prepared[scene] = self._prepare(scene)
            if len(self._prepared) > SCENES:
                self._prepared.popitem(last=False)
        self._prepared.move_to_end(scene)
        return self._prepared[scene]

    def play(self, episode: Episode) -> EpisodeRecord:
        """Play one episode in lockstep, without a recording and without the checks of a sweep.

        Raises:
            InputError: Content is invalid.
            RocsError: The engine failed.
        """
        prepared, planner = self.prepare(episode.scene), episode.planner
        scenario, agent = prepared.with_planner(planner), prepared.agent
        latency = agent_of(scenario, agent).latency
        if episode.require:
            extra = RequirementSpec(name=episode.require, require=episode.require, agent=agent)
            scenario = replaced(scenario, requirements=(*scenario.requirements, extra))
        sink = MetricSink(agent)
        options = RunOptions(seed=episode.seed, report=False, prepare=sink.prepare, sinks=[sink])
        summary = Run(scenario, prepared.catalog, options).conduct().summary
        result = summary.agents[agent]
        measured = EpisodeData(
            outcome=result.outcome,
            time_limit=scenario.duration,
            reference_length=prepared.reference_length,
            agent=result,
            path=sink.path(),
            clearances=sink.clearances,
            energy=sink.energy,
            duration=summary.sim_time,
            jerk=sink.jerk(),
            company=sink.company,
        )
        return EpisodeRecord(
            key=episode.key,
            planner=planner.name,
            family=episode.scene.group,
            scene=episode.scene.name,
            seed=episode.seed,
            outcome=result.outcome,
            reason=result.reason,
            metrics=measure_all(measured),
            sim_time=summary.sim_time,
            time_limit=scenario.duration,
            difficulty=prepared.difficulty,
            track=sink.track(),
            content=summary.content_hash,
            trajectory_hash=summary.trajectory_hash or "",
            reproducible=latency is not None,
        )

    def _prepare(self, ref: SceneRef) -> PreparedScene:
        if isinstance(ref, ScenarioScene):
            return self._prepare_scenario(ref)
        if isinstance(ref, FamilyScene):
            scene = scene_of(load_family(self.catalog, ref.family, dict(ref.parameters)), ref.index)
        else:
            scene = ref.scene
        catalog = scene.added_to(self.catalog)
        scenario = catalog.load_scenario(scene.name)
        length = scene.reference_length or _shortest(scenario, agent_of(scenario, AGENT))
        return PreparedScene(catalog, scenario, AGENT, length, scene.difficulty, scene.privileged)

    def _prepare_scenario(self, ref: ScenarioScene) -> PreparedScene:
        scenario = self.catalog.load_scenario(ref.scenario)
        agent = agent_of(scenario, ref.agent)
        return PreparedScene(self.catalog, scenario, agent.name, _shortest(scenario, agent))


def agent_of(scenario: ScenarioSpec, name: str) -> AgentSpec:
    """Agent of a scenario by name; the first agent if the name is empty."""
    agents = {agent.name: agent for agent in scenario.agents}
    wanted = name or scenario.agents[0].name
    if wanted not in agents:
        raise InputError(unknown("agent", wanted, agents, f"The scenario '{scenario.name}'"))
    return agents[wanted]


def _shortest(scenario: ScenarioSpec, agent: AgentSpec) -> float:
    """Shortest path length from start to goal [m]: as declared, else of the straight line; 0 without a goal."""
    if (known := agent.success.shortest_path) is not None:
        return known
    goals = [place.pose for place in scenario.places if place.name == agent.success.goal]
    return agent.pose.distance(goals[0]) if goals else 0.0


STEP = 0.05
"""Path length between two measurements of clearance, and between two positions for the metrics [m]."""

TRACK = 0.1
"""Path length between two positions that a record contains for figures [m]."""


class MetricSink:
    """Event sink that measures one agent during a lockstep run.

    Attributes:
        clearances: Distance from the hull to the nearest object except the floor, every STEP of path length [m].
        energy: Kinetic energy added by accelerating, per mass [J/kg]; None if wheel speeds are not recorded.
        company: Things that move around the robot; None before `prepare`.
    """

    def __init__(self, agent: str) -> None:
        self.agent = agent
        self.clearances: list[float] = []
        self.energy: float | None = None
        self.company: Company | None = None
        self._world: MujocoWorld | None = None
        self._times: list[float] = []
        self._flies = False
        self._height = 0.0
        self._points: list[tuple[float, float]] = []
        self._driven = 0.0
        self._next = 0.0
        self._kinetic: float | None = None

    def prepare(self, simulated: SimulatedWorld) -> None:
        """Store the simulated world; pass it as the `prepare` argument of `run`."""
        self._world, self.company = simulated.world, Company(self.agent, simulated)
        self._flies = simulated.robots[self.agent].locomotion.kind == "flying"

    def emit(self, event: Event) -> None:
        """Measure at each `BodyMoved` event of the agent."""
        if not isinstance(event, BodyMoved) or event.agent != self.agent:
            return
        height = event.height or 0.0
        if self._points:
            moved = math.dist(self._points[-1], (event.x, event.y))
            self._driven += math.hypot(moved, height - self._height) if self._flies else moved
        self._points.append((event.x, event.y))
        self._times.append(event.t)
        self._height = height
        if self.company is not None:
            self.company.measure()
        if self._world is not None and self._driven >= self._next:
            self.clearances.append(self._world.clearance(self.agent)[0])
            self._next = self._driven + STEP
        if event.wheels:
            self._add_energy(unpack(event.wheels))

    def jerk(self) -> float | None:
        """Root mean square of the horizontal jerk [m/s3]; None for a run of fewer than four control periods."""
        if len(self._times) < 4:
            return None
        periods = np.diff(self._times)
        speeds = np.diff(self._points, axis=0) / periods[:, None]
        changes = np.diff(speeds, n=2, axis=0) / (periods[1:-1, None] * periods[2:, None])
        return float(np.sqrt((changes**2).sum(axis=1).mean()))

    def path(self, step: float = STEP) -> npt.NDArray[np.float64]:
        """Positions at equal steps of path length [m], shape (n, 2), interpolated between the measured ones."""
        points = np.array(self._points, dtype=float).reshape(-1, 2)
        if len(points) < 2:
            return points
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        at = np.arange(0.0, along[-1], step)
        return np.column_stack([np.interp(at, along, points[:, axis]) for axis in (0, 1)])

    def track(self) -> bytes:
        """Positions at steps of TRACK of path length, and the last one, float32 of shape (n, 2) as bytes [m]."""
        return np.vstack([self.path(TRACK), *self._points[-1:]]).astype(np.float32).tobytes()

    def _add_energy(self, wheels: list[float]) -> None:
        """Add the increase of kinetic energy per mass: half the mean square of the wheel linear speeds."""
        kinetic = sum(v * v for v in wheels) / (2.0 * len(wheels))
        self.energy = (self.energy or 0.0) + max(kinetic - (kinetic if self._kinetic is None else self._kinetic), 0.0)
        self._kinetic = kinetic


_ONE_AT_A_TIME = threading.Lock()  # one episode per process, even if the executor uses several threads


def run_episode(episode: Episode) -> tuple[EpisodeRecord, Cost]:
    """Play an episode in a worker process. An exception becomes a record with the outcome `error`.

    If the episode exceeds its wall limit, the worker process ends, even if C code holds the interpreter lock. The
    caller then records the failure.

    Raises:
        InputError: Content is invalid, so every other episode would fail too.
    """
    with _ONE_AT_A_TIME, _limited(episode.wall_limit):
        wall, cpu = time.perf_counter(), time.process_time()
        runner = _process_runner(episode.project, episode.code)
        limit = runner.prepare(episode.scene).scenario.duration
        try:
            record = runner.play(episode)
        except InputError:
            raise
        except Exception as error:  # noqa: BLE001 - process boundary: one failed episode must not end a sweep
            record = failure_record(episode, "error", f"{type(error).__name__}: {error}", limit, reproducible=True)
        return record, Cost(time.perf_counter() - wall, time.process_time() - cpu)


def failure_record(
    episode: Episode, outcome: str, reason: str, time_limit: float, *, reproducible: bool
) -> EpisodeRecord:
    """Record of an episode that was not played to its end; it counts as a failure and contains no other measurements.

    Args:
        episode: The episode.
        outcome: `error` or `limit`.
        reason: Reason of the failure.
        time_limit: Time limit of the episode [s]; 0 if unknown.
        reproducible: Whether a repetition would fail too.
    """
    time = time_limit if time_limit > 0.0 else None
    return EpisodeRecord(
        key=episode.key,
        planner=episode.planner.name,
        family=episode.scene.group,
        scene=episode.scene.name,
        seed=episode.seed,
        outcome=outcome,
        reason=reason,
        metrics={**dict.fromkeys(METRICS), **dict.fromkeys(ZERO_ON_FAILURE, 0.0), "time": time},
        time_limit=time_limit,
        reproducible=reproducible,
    )


@lru_cache(maxsize=1)
def _process_runner(project: Path | None, code: bool) -> EpisodeRunner:
    """Episode runner of this process, created on first use."""
    return EpisodeRunner(project, code=code)


@contextmanager
def _limited(seconds: float) -> Iterator[None]:
    """End this worker process if the `with` block exceeds a time limit [s]; no effect in the main process."""
    if multiprocessing.parent_process() is None:
        yield
        return
    # The default action for this signal ends the process at once and in silence, whatever holds the interpreter.
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
