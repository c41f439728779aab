"""Metrics of each agent in summary.json, computed from events only: a run and its recording give equal metrics."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..errors import BlockError
from ..event import (
    ActuatorCommanded,
    BlockFailed,
    BodyMoved,
    CommandExpired,
    CommandLimited,
    ContactBegan,
    ContentRaised,
    Event,
    FollowerStepped,
    GoalEntered,
    MinClearanceLowered,
    MotionHeld,
    OutcomeDecided,
    PeerFault,
    Replanned,
    RuleChanged,
    SensorFailed,
    SignalsWritten,
    Stuck,
    TicketChanged,
    unpack,
)
from ..record import AgentInfo, AgentResult, Finding, SolveTime, TrackingError
from .follow_metrics import FollowMetrics
from .localisation import LocalisationError

_HELD = 0.2  # [s] maximum time that a command counts as driving; then the watchdog stops the wheels
_ENDED = ("SUCCEEDED", "FAILED", "CANCELLED")


@dataclass
class _Tally:
    """Running counts and sums of one agent."""

    path_length: float = 0.0  # [m] in the plane
    path_in_space: float = 0.0  # [m]
    at: tuple[float, float] | None = None
    height: float | None = None
    min_clearance: float | None = None
    touches: Counter[str] = field(default_factory=Counter)
    contacts: dict[str, Counter[str]] = field(default_factory=dict)
    activations: int = 0
    refirings: int = 0
    switches: int = 0
    replans: int = 0
    route: str = ""  # route of the last command; empty if idle
    driven_by: str = ""  # last route that was not idle
    since: float = 0.0
    times: dict[str, float] = field(default_factory=lambda: {"reactive": 0.0, "deliberative": 0.0})
    limited: Counter[str] = field(default_factory=Counter)  # by action
    actions: dict[str, Counter[str]] = field(default_factory=dict)
    cross: list[float] = field(default_factory=list)
    solve: list[float] = field(default_factory=list)
    goals: set[str] = field(default_factory=set)
    faults: list[str] = field(default_factory=list)
    exceptions: Counter[str] = field(default_factory=Counter)
    following: FollowMetrics | None = None
    localisation: LocalisationError = field(default_factory=LocalisationError)
    collision: str = ""  # first collision
    failure: str = ""  # first block failure
    failed_block: str | None = None
    failed_owner: str | None = None
    judged: OutcomeDecided | None = None


class Metrics:
    """Event sink that computes the metrics of all agents.

    Args:
        agents: Names of the agents.
        simulated: Whether the world was simulated; if not, metrics that need ground truth are None.
        start: Time of the start of the run [s].
    """

    def __init__(self, agents: Iterable[str], *, simulated: bool = True, start: float = 0.0) -> None:
        self._simulated = simulated
        self._start = start
        self._tallies = {name: _Tally() for name in agents}
        self._positions: dict[str, tuple[float, float]] = {}
        self._takes: dict[type[Event], Callable[[_Tally, Any], None]] = {
            BodyMoved: self._moved,
            MinClearanceLowered: _min_clearance_lowered,
            ContactBegan: _contact_began,
            RuleChanged: _rule,
            ActuatorCommanded: _commanded,
            Replanned: _replanned,
            TicketChanged: _ticket,
            FollowerStepped: _follower_stepped,
            GoalEntered: _entered,
            SensorFailed: _fault,
            SignalsWritten: _wrote,
            BlockFailed: _block_failed,
            ContentRaised: _raised,
            CommandExpired: _fault,
            CommandLimited: _limited,
            PeerFault: _fault,
            MotionHeld: _fault,
            Stuck: _fault,
            OutcomeDecided: _outcome_decided,
        }

    def emit(self, event: Event) -> None:
        """Process one event."""
        self.take((event,))

    def take(self, events: Sequence[Event]) -> None:
        """Process several events."""
        takes, tallies = self._takes, self._tallies
        for event in events:
            if (take := takes.get(type(event))) is None:  # most kinds of events are not counted
                continue
            if type(event) is BodyMoved:  # isinstance of an abstract base class is slow
                self._positions[event.body] = event.x, event.y
            if (tally := tallies.get(event.agent)) is not None:
                take(tally, event)

    def of(
        self,
        agent: AgentInfo,
        end: float,
        sharing: Mapping[str, float] | None = None,
        requirements: Sequence[Finding] = (),
    ) -> AgentResult:
        """Result of one agent.

        Args:
            agent: Description of the agent.
            end: Time of the end of the run [s].
            sharing: Statistics of the knowledge that the agent shares; None if it shares none.
            requirements: Results of the agent's requirements.
        """
        tally = self._tallies[agent.name]
        judged, true = tally.judged or _cut_off(tally, end), self._simulated
        contacts = {kind: dict(sorted(counts.items())) for kind, counts in sorted(tally.contacts.items())}
        return AgentResult(
            robot=agent.robot,
            mission=agent.mission,
            rules=agent.rules,
            inactive_rules=agent.inactive,
            outcome=judged.outcome,
            reason=judged.reason,
            time_to_goal=judged.time_to_goal,
            failed_block=tally.failed_block,
            failed_owner=tally.failed_owner,
            faults=tuple(tally.faults),
            exceptions=dict(sorted(tally.exceptions.items())),
            goals_reached=len(tally.goals) if true else None,
            path_length=tally.path_in_space if "vz" in agent.axes else tally.path_length,
            min_clearance=tally.min_clearance,
            collisions=tally.touches["collision"] if true else None,
            struck=tally.touches["struck"] if true else None,
            contacts=contacts if true else None,
            fell=judged.fell if true else None,
            reflex_activations=tally.activations,
            reflex_refirings=tally.refirings,
            route_switches=tally.switches,
            time_reactive=tally.times["reactive"],
            time_deliberative=tally.times["deliberative"],
            replans=tally.replans,
            commands_limited=dict(sorted(tally.limited.items())),
            actions={name: dict(sorted(counts.items())) for name, counts in sorted(tally.actions.items())},
            tracking_error=TrackingError(
                cross_rms=math.sqrt(sum(c * c for c in tally.cross) / len(tally.cross)) if tally.cross else None,
                cross_max=max(map(abs, tally.cross), default=None),
            ),
            solve_time=SolveTime(median=quantile(tally.solve, 0.5), p99=quantile(tally.solve, 0.99)),
            localisation=tally.localisation.result() if true else None,
            following=None
            if tally.following is None
            else tally.following.result(self._arrival(tally.following.leader)),
            sharing=sharing,
            requirements=tuple(requirements),
        )

    def _moved(self, tally: _Tally, event: BodyMoved) -> None:
        if tally.at is not None:
            moved = math.hypot(event.x - tally.at[0], event.y - tally.at[1])
            climbed = 0.0 if event.height is None or tally.height is None else event.height - tally.height
            tally.path_length += moved
            tally.path_in_space += math.hypot(moved, climbed)
        tally.at, tally.height = (event.x, event.y), event.height
        tally.localisation.moved(event)
        if tally.following is not None and (leader := self._positions.get(tally.following.leader)) is not None:
            wheel_speed = max(map(abs, unpack(event.wheels)), default=0.0)
            tally.following.note(event.t, self._positions[event.body], leader, wheel_speed)

    def _arrival(self, agent: str) -> float | None:
        """Time at which an agent reached its goal [s]; None if the agent did not, or does not exist."""
        tally = self._tallies.get(agent)
        reached = None if tally is None or tally.judged is None else tally.judged.time_to_goal
        return None if reached is None else self._start + reached


def _cut_off(tally: _Tally, end: float) -> OutcomeDecided:
    """Outcome of an agent if the recording ends without one: a recorded failure or collision, else `interrupted`."""
    if tally.failure:
        return OutcomeDecided(t=end, outcome="error", reason=tally.failure)
    if tally.collision:
        return OutcomeDecided(t=end, outcome="collision", reason=tally.collision)
    return OutcomeDecided(t=end, outcome="interrupted", reason=f"the recording ends at {end:.2f} s without an outcome")


def quantile(values: Iterable[float], share: float) -> float | None:
    """Quantile of values, without interpolation; None if there are no values.

    Args:
        values: The values.
        share: Probability of the quantile, 0 to 1.
    """
    ordered = sorted(values)
    return ordered[min(int(share * len(ordered)), len(ordered) - 1)] if ordered else None


def _min_clearance_lowered(tally: _Tally, event: MinClearanceLowered) -> None:
    tally.min_clearance = event.distance


def _contact_began(tally: _Tally, event: ContactBegan) -> None:
    tally.touches[event.kind] += 1
    if event.kind == "collision" and not tally.collision:
        tally.collision = f"it ran into {event.other} at {event.t:.2f} s"
    tally.contacts.setdefault(event.kind, Counter())[event.other] += 1


def _rule(tally: _Tally, event: RuleChanged) -> None:
    tally.activations += event.phase == "fired"
    tally.refirings += event.phase == "fired again"


def _commanded(tally: _Tally, event: ActuatorCommanded) -> None:
    if tally.route:
        tally.times[tally.route] += min(event.t - tally.since, _HELD)
    tally.route, tally.since = "", event.t
    if event.route in ("reactive", "deliberative"):
        tally.switches += tally.driven_by not in ("", event.route)
        tally.route = tally.driven_by = event.route


def _replanned(tally: _Tally, event: Replanned) -> None:
    tally.replans += 1


def _ticket(tally: _Tally, event: TicketChanged) -> None:
    if tally.following is None and event.parameters.keys() >= {"leader", "distance", "safety"}:
        tally.following = FollowMetrics(event.parameters)
    if event.state in _ENDED:
        tally.actions.setdefault(event.action, Counter())[event.state] += 1


def _follower_stepped(tally: _Tally, event: FollowerStepped) -> None:
    tally.cross.append(event.cross_track)
    if event.solve_time > 0.0:
        tally.solve.append(event.solve_time)


def _entered(tally: _Tally, event: GoalEntered) -> None:
    tally.goals.add(event.goal)


def _wrote(tally: _Tally, event: SignalsWritten) -> None:
    tally.localisation.estimated(event)


def _raised(tally: _Tally, event: ContentRaised) -> None:
    tally.exceptions[f"{event.kind} {event.content}"] += 1
    _fault(tally, event)


def _block_failed(tally: _Tally, event: BlockFailed) -> None:
    if tally.failed_block is None:
        tally.failed_block, tally.failed_owner = event.block, event.owner
        tally.failure = str(BlockError(f"{event.agent}/{event.block}", event.kind, event.detail, event.owner))
    _fault(tally, event)


def _limited(tally: _Tally, event: CommandLimited) -> None:
    tally.limited[event.action] += 1


def _fault(tally: _Tally, event: Event) -> None:
    tally.faults.append(f"{event.t:.2f} s: {event.sentence}")


def _outcome_decided(tally: _Tally, event: OutcomeDecided) -> None:
    tally.judged = event
