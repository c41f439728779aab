"""History: time series and events of a run for figures and the report, collected from a recording."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..event import (
    ActuatorCommanded,
    AgentStopped,
    AtomicStarted,
    BlockFailed,
    BodyMoved,
    CommandExpired,
    ContactBegan,
    ContentRaised,
    Event,
    KnowledgeChanged,
    MotionHeld,
    MotionReleased,
    NodeTicked,
    OtherPublisherFound,
    OutcomeDecided,
    PeerFault,
    Replanned,
    RobotPushed,
    RuleChanged,
    SensorFailed,
    SensorRead,
    Stuck,
    SubtreeSwapped,
    SwapRefused,
    TicketChanged,
    unpack,
)
from .header import AgentInfo, TreeNode, nodes_after
from .recording import Recording
from .summary import Finding

Series = NDArray[np.float64]


@dataclass
class BodyHistory:
    """Trajectory of one body.

    Attributes:
        t: Times [s], shape (n,).
        pose: x, y, yaw [m, m, rad], world frame, shape (n, 3).
        wheels: Wheel linear speeds [m/s], shape (n, w); (n, 0) if not recorded.
        height: Heights of the base [m], shape (n,); (0,) if not recorded.
        tilt: Angles from the vertical [rad], shape (n,); (0,) if not recorded.
    """

    t: Series
    pose: Series
    wheels: Series
    height: Series = field(default_factory=lambda: np.zeros(0))
    tilt: Series = field(default_factory=lambda: np.zeros(0))

    @property
    def spatial(self) -> bool:
        """Whether height and tilt are recorded."""
        return len(self.height) > 0

    def speed(self, axis: str) -> Series | None:
        """Speeds along an axis of the body [m/s, rad/s], shape (n,), from the poses; None if they are too few.

        Args:
            axis: `vx`, `vy` (horizontal), `vz` (vertical) or `wz` (about the vertical).
        """
        if len(self.t) < 2 or (axis == "vz" and not self.spatial):
            return None
        x, y, yaw = self.pose.T
        ahead = yaw if axis == "vx" else yaw + 0.5 * np.pi
        if axis in ("vz", "wz"):
            speed: Series = np.gradient(self.height if axis == "vz" else np.unwrap(yaw), self.t)
        else:
            speed = np.gradient(x, self.t) * np.cos(ahead) + np.gradient(y, self.t) * np.sin(ahead)
        return speed

    def at(self, t: Series | float) -> Series:
        """Positions [m] at times, shape (m, 2), linearly interpolated; NaN if the body has no samples."""
        times = np.atleast_1d(t)
        if not len(self.t):
            return np.full((len(times), 2), np.nan)
        return np.stack([np.interp(times, self.t, self.pose[:, i]) for i in (0, 1)], axis=1)


@dataclass
class Command:
    """Commands of one actuator.

    Attributes:
        t: Times [s], shape (n,).
        values: Commanded values, SI units, shape (n, w).
        routes: Route of each command.
    """

    t: Series
    values: Series
    routes: tuple[str, ...]


@dataclass
class Span:
    """Time interval of a route, an active rule or a running ticket."""

    name: str
    begin: float  # [s]
    end: float  # [s]


@dataclass
class Activation(Span):
    """Time interval of one activation of a rule, with its first event and the number of re-firings while latched."""

    event: RuleChanged
    refirings: int = 0


@dataclass
class Worst:
    """Time [s] of the minimum margin of a requirement, with the requirement's name, verdict and margin with unit."""

    name: str
    verdict: str
    t: float
    margin: str


FaultEvent = (
    SensorFailed
    | ContentRaised
    | BlockFailed
    | CommandExpired
    | MotionHeld
    | MotionReleased
    | OtherPublisherFound
    | PeerFault
    | RobotPushed
    | Stuck
    | ContactBegan
)
"""Events that a report lists as faults of a run, the end of a hold, and pushes."""


@dataclass
class AgentHistory:
    """Events of one agent by kind, in order, and series derived from them."""

    commands: dict[str, Command] = field(default_factory=dict)
    rules: list[RuleChanged] = field(default_factory=list)
    tree: list[NodeTicked] = field(default_factory=list)
    tickets: list[TicketChanged] = field(default_factory=list)
    atomic: list[AtomicStarted] = field(default_factory=list)
    replans: list[Replanned] = field(default_factory=list)
    swaps: list[SubtreeSwapped] = field(default_factory=list)
    refused: list[SwapRefused] = field(default_factory=list)
    faults: list[FaultEvent] = field(default_factory=list)
    knowledge: list[KnowledgeChanged] = field(default_factory=list)
    readings: dict[str, list[SensorRead]] = field(default_factory=dict)
    routes: list[Span] = field(default_factory=list)
    judged: OutcomeDecided | None = None
    stopped: float | None = None  # [s]
    worst: list[Worst] = field(default_factory=list)

    @property
    def switches(self) -> list[float]:
        """Times of the switches between the deliberative and the reactive route [s] (paper, Figure 5b)."""
        acting = [s for s in self.routes if s.name in ("deliberative", "reactive")]
        return [b.begin for a, b in pairwise(acting) if a.name != b.name]

    @property
    def requested_swaps(self) -> list[SubtreeSwapped | SwapRefused]:
        """Swaps of subtrees, made and refused."""
        found: list[SubtreeSwapped | SwapRefused] = [*self.swaps, *self.refused]
        return sorted(found, key=lambda event: event.t)

    def statuses(self) -> dict[str, NodeTicked]:
        """Last status event of each node of the tree."""
        return {event.node: event for event in self.tree}

    def nodes(self, info: AgentInfo) -> tuple[TreeNode, ...]:
        """Nodes of the mission's tree at the end, after all swaps of subtrees."""
        return nodes_after(self.swaps[-1]) if self.swaps else info.nodes

    def reflexes(self, end: float) -> list[Activation]:
        """Activations of all rules, each from its firing until its end, at most until `end` [s]."""
        found: list[Activation] = []
        active: dict[str, Activation] = {}
        for event in self.rules:
            if event.phase == "fired":
                active[event.rule] = Activation(event.rule, event.t, end, event)
                found.append(active[event.rule])
            elif event.phase == "fired again" and event.rule in active:
                active[event.rule].refirings = event.refirings
            elif event.phase == "ended" and event.rule in active:
                active.pop(event.rule).end = event.t
        return found

    def runs(self, end: float) -> list[Span]:
        """Intervals in which the actions of tickets ran, named `action #ticket`, at most until `end` [s]."""
        spans: dict[int, Span] = {}
        for event in self.tickets:
            if event.state == "RUNNING":
                spans[event.ticket] = Span(f"{event.action} #{event.ticket}", event.t, end)
            elif event.state != "QUEUED" and event.ticket in spans:
                spans[event.ticket].end = event.t
        return list(spans.values())


class History:
    """Time series of one recording.

    Attributes:
        label: Short name of the run.
        header: Header of the recording.
        bodies: Trajectories by body, in the header's order.
        agents: Histories by agent, in the header's order.
        pushes: Pushes of all robots, with and without an agent.
        end: Time of the last event [s].
    """

    def __init__(self, recording: Recording) -> None:
        self.header = recording.header
        self.label = recording.header.label
        self.agents = {a.name: AgentHistory() for a in self.header.agents}
        self.pushes: list[RobotPushed] = []
        self.end = self.header.start
        self._moves: dict[str, list[BodyMoved]] = {b.name: [] for b in self.header.bodies}
        self._commands: dict[tuple[str, str], list[ActuatorCommanded]] = {}
        for event in recording.events():
            self.end = max(self.end, event.t)
            self._take(event)
        self.bodies = {name: _body(moves) for name, moves in self._moves.items()}
        for (agent, actuator), events in self._commands.items():
            self.agents[agent].commands[actuator] = _command(events)
        for history in self.agents.values():
            first = next(iter(history.commands.values()), None)
            history.routes = [] if first is None else _routes(first, self.end, history.stopped)
        for name, result in ({} if recording.summary is None else recording.summary.agents).items():
            if name in self.agents:
                self.agents[name].worst = _worst(result.requirements)

    def _take(self, event: Event) -> None:
        if isinstance(event, BodyMoved):
            self._moves.setdefault(event.body, []).append(event)
            return
        if isinstance(event, RobotPushed):
            self.pushes.append(event)
        agent = self.agents.get(event.agent)
        if agent is None:
            return
        if isinstance(event, ActuatorCommanded):
            self._commands.setdefault((event.agent, event.actuator), []).append(event)
        elif isinstance(event, SensorRead):
            agent.readings.setdefault(event.sensor, []).append(event)
        elif isinstance(event, KnowledgeChanged):
            agent.knowledge.append(event)
        elif isinstance(event, RuleChanged):
            agent.rules.append(event)
        elif isinstance(event, NodeTicked):
            agent.tree.append(event)
        elif isinstance(event, TicketChanged):
            agent.tickets.append(event)
        elif isinstance(event, AtomicStarted):
            agent.atomic.append(event)
        elif isinstance(event, OutcomeDecided):
            agent.judged = event
        elif isinstance(event, AgentStopped):
            agent.stopped = event.t
        elif isinstance(event, Replanned):
            agent.replans.append(event)
        elif isinstance(event, SubtreeSwapped):
            agent.swaps.append(event)
        elif isinstance(event, SwapRefused):
            agent.refused.append(event)
        elif isinstance(event, FaultEvent):
            agent.faults.append(event)


def _worst(findings: Iterable[Finding]) -> list[Worst]:
    """Minimum margins of the requirements with a known margin."""
    return [
        Worst(f.name, f.verdict, f.worst, f"{f.margin:.3g} {f.unit}".strip())
        for f in findings
        if f.margin is not None and f.worst is not None
    ]


def _matrix(packed: list[bytes]) -> Series:
    """Unpack values into the rows of a matrix; shorter rows are padded with NaN."""
    rows = [unpack(data) for data in packed]
    width = max((len(r) for r in rows), default=0)
    return np.array([[*r, *[np.nan] * (width - len(r))] for r in rows], float).reshape(len(rows), width)


def _body(moves: list[BodyMoved]) -> BodyHistory:
    pose = np.array([[m.x, m.y, m.yaw] for m in moves], float).reshape(len(moves), 3)
    t, wheels = np.array([m.t for m in moves], float), _matrix([m.wheels for m in moves])
    if not any(m.height is not None for m in moves):
        return BodyHistory(t, pose, wheels)
    height = np.array([math.nan if m.height is None else m.height for m in moves], float)
    return BodyHistory(t, pose, wheels, height, np.array([m.tilt for m in moves], float))


def _command(events: list[ActuatorCommanded]) -> Command:
    t = np.array([e.t for e in events], float)
    return Command(t, _matrix([e.data for e in events]), tuple(e.route for e in events))


def _routes(command: Command, end: float, stopped: float | None) -> list[Span]:
    """Intervals of each route that commanded the robot; after the agent was stopped, the route is `idle`."""
    spans: list[Span] = []
    for t, route in zip(command.t.tolist(), command.routes, strict=True):
        route = "idle" if stopped is not None and t >= stopped else route
        if spans and spans[-1].name == route:
            continue
        if spans:
            spans[-1].end = t
        spans.append(Span(route, t, end))
    return spans
