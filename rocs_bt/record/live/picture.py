"""Picture: state of the live page, and the changes of this state since the last update."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

import msgspec

from ...event import (
    ActuatorCommanded,
    AgentStopped,
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
    RequirementViolated,
    RobotPushed,
    RuleChanged,
    SensorFailed,
    SensorRead,
    SignalsWritten,
    Stuck,
    SubtreeSwapped,
    TicketChanged,
)
from ...raised import reported
from ..header import RunHeader, TreeNode, nodes_after

_STEP = 0.01  # [m] minimum distance between points of a trail
_MOST_POINTS = 4000  # maximum length of a trail; longer ones are thinned
_MOST_LINES = 200  # maximum number of kept knowledge changes, and of faults


class Body(msgspec.Struct, omit_defaults=True):
    """Body: present pose (x, y, yaw) [m, m, rad], height and tilt [m, rad], and trail of points (x, y, route)."""

    pose: tuple[float, float, float] | None = None
    spatial: tuple[float, float] | None = None
    trail: list[tuple[float, float, str]] = []


class Rule(msgspec.Struct, frozen=True):
    """Rule: state, counters and last signal values.

    Attributes:
        latched: Whether the rule is latched.
        active: Whether its action is active.
        fired: Number of activations.
        refirings: Number of re-firings of the present or last activation.
        reading: Last signal values of the guard, as text.
        t: Time of the last change [s].
    """

    latched: bool
    active: bool
    fired: int
    refirings: int
    reading: str
    t: float


class Agent(msgspec.Struct, omit_defaults=True):
    """Agent: tree and statuses, signals, rules, ranges and tickets by name, knowledge changes, faults and outcome.

    `swapped` is the path of a subtree that was replaced; the page must drop the statuses of this subtree.
    """

    tree: tuple[TreeNode, ...] | None = None
    swapped: str = ""
    nodes: dict[str, tuple[str, str, float]] = {}
    signals: dict[str, list[float | str]] = {}
    rules: dict[str, Rule] = {}
    ranges: dict[str, list[float | None]] = {}
    tickets: dict[int, tuple[str, str, str, str]] = {}
    knowledge: list[tuple[float, str, str, str, Any]] = []
    faults: list[tuple[float, str]] = []
    route: str = ""
    outcome: tuple[str, str, float | None] | None = None


class State(msgspec.Struct, omit_defaults=True):
    """Complete state of the page, or only the changed parts of it."""

    t: float = 0.0
    run: RunHeader | None = None
    bodies: dict[str, Body] = {}
    agents: dict[str, Agent] = {}

    def body(self, name: str) -> Body:
        """State of a body, created if missing."""
        return self.bodies.setdefault(name, Body())

    def agent(self, name: str) -> Agent:
        """State of an agent, created if missing."""
        return self.agents.setdefault(name, Agent())


class Picture:
    """State of a run, updated by events and encoded as JSON: as a whole, or as changes since the last update.

    Not thread-safe.
    """

    def __init__(self) -> None:
        self._whole, self._new = State(), State()
        self._beams: dict[tuple[str, str], int] = {}
        self._takes: dict[type[Event], Callable[[Any], None]] = {
            ActuatorCommanded: self._commanded,
            AgentStopped: self._stopped,
            BodyMoved: self._moved,
            OutcomeDecided: self._judged,
            KnowledgeChanged: self._learned,
            NodeTicked: self._ticked,
            RuleChanged: self._ruled,
            SensorRead: self._read,
            SignalsWritten: self._written,
            SubtreeSwapped: self._swapped,
            TicketChanged: self._ticket,
            SensorFailed: lambda e: self._fault(e, f"sensor {e.sensor} failed: {e.detail}"),
            ContentRaised: lambda e: self._fault(e, reported(e)),
            BlockFailed: lambda e: self._fault(e, f"{e.what} {e.kind}: {e.detail}"),
            CommandExpired: lambda e: self._fault(e, f"no command for {e.actuator}: stopped by its watchdog"),
            MotionHeld: lambda e: self._fault(e, f"{e.actuator} held in neutral: {e.reason}"),
            MotionReleased: lambda e: self._fault(e, f"{e.actuator} released" + (f" by {e.by}" if e.by else "")),
            ContactBegan: lambda e: self._fault(e, f"{e.kind}: {e.other}"),
            RobotPushed: lambda e: self._fault(e, e.text),
            OtherPublisherFound: lambda e: self._fault(e, e.text),
            PeerFault: lambda e: self._fault(e, f"peer {e.peer}: {e.detail}"),
            Stuck: lambda e: self._fault(e, e.reason),
            RequirementViolated: lambda e: self._fault(e, f"{e.requirement} was violated at {e.about:.2f} s"),
        }

    @property
    def kinds(self) -> tuple[type[Event], ...]:
        """Kinds of events that change the state."""
        return tuple(self._takes)

    def begin(self, run: RunHeader) -> None:
        """Reset the state for a new run."""
        self._whole, self._new = State(run=run, t=run.start), State()
        self._beams = {(b.name, sensor): len(beams) for b in run.bodies for sensor, beams in b.beams.items()}
        self._beams |= {(b.name, sensor): fan.rays for b in run.bodies for sensor, fan in b.fans.items()}
        for agent in run.agents:
            self._whole.agent(agent.name).tree = agent.nodes

    def take(self, events: Iterable[Event]) -> None:
        """Apply events in order."""
        for event in events:
            self._whole.t = self._new.t = max(self._whole.t, event.t)
            take = self._takes.get(type(event))
            if take is not None:
                take(event)

    def whole(self) -> bytes:
        """Complete state, for a new page."""
        return msgspec.json.encode(self._whole)

    def delta(self) -> bytes:
        """Changes since the last call."""
        data = msgspec.json.encode(self._new)
        self._new = State(t=self._whole.t)
        return data

    def _both(self, name: str) -> tuple[Agent, Agent]:
        return self._whole.agent(name), self._new.agent(name)

    def _moved(self, event: BodyMoved) -> None:
        pose = _rounded(event.x, 4), _rounded(event.y, 4), _rounded(event.yaw, 4)
        whole, new = self._whole.body(event.body), self._new.body(event.body)
        whole.pose = new.pose = pose
        if event.height is not None:
            whole.spatial = new.spatial = _rounded(event.height, 3), _rounded(event.tilt, 4)
        last = whole.trail[-1] if whole.trail else (math.inf, math.inf, "")
        if not math.dist(last[:2], pose[:2]) < _STEP:
            agent = self._whole.agents.get(event.body)
            point = pose[0], pose[1], "" if agent is None else agent.route
            if len(whole.trail) >= _MOST_POINTS:
                whole.trail[:] = whole.trail[::2]
            whole.trail.append(point)
            new.trail.append(point)

    def _ticked(self, event: NodeTicked) -> None:
        known = self._whole.agent(event.agent).nodes.get(event.node)
        since = known[2] if known is not None and known[0] == event.status else event.t
        for agent in self._both(event.agent):
            agent.nodes[event.node] = event.status, event.feedback, since

    def _swapped(self, event: SubtreeSwapped) -> None:
        tree = nodes_after(event)
        for agent in self._both(event.agent):
            agent.tree = tree
            for path in [p for p in agent.nodes if p == event.node or p.startswith(event.node + "/")]:
                del agent.nodes[path]
        self._new.agent(event.agent).swapped = event.node

    def _written(self, event: SignalsWritten) -> None:
        for name, values in event.values.items():
            shown = [_signal(value) for value in values]
            for agent in self._both(event.agent):
                agent.signals[name] = shown

    def _ruled(self, event: RuleChanged) -> None:
        before = self._whole.agent(event.agent).rules.get(event.rule)
        latched, active, fired = (before.latched, before.active, before.fired) if before else (False, False, 0)
        if event.phase == "fired":
            active, fired = True, fired + 1
        elif event.phase == "ended":
            active = False
        latched = event.phase != "released" and (latched or event.phase in ("latched", "waits"))
        reading = event.reading or (before.reading if before else "")
        for agent in self._both(event.agent):
            agent.rules[event.rule] = Rule(latched, active, fired, event.refirings, reading, event.t)

    def _read(self, event: SensorRead) -> None:
        values = event.values
        if self._beams.get((event.agent, event.sensor)) == len(values):
            shown = [_range(value) for value in values]
            for agent in self._both(event.agent):
                agent.ranges[event.sensor] = shown

    def _ticket(self, event: TicketChanged) -> None:
        whole, new = self._both(event.agent)
        new.tickets[event.ticket] = event.action, event.state, event.by, event.reason
        if event.state in ("QUEUED", "RUNNING"):
            whole.tickets[event.ticket] = new.tickets[event.ticket]
        else:
            whole.tickets.pop(event.ticket, None)

    def _learned(self, event: KnowledgeChanged) -> None:
        for agent in self._both(event.agent):
            agent.knowledge.append((event.t, event.what, event.subject, event.name, _fact(event.value)))
            del agent.knowledge[:-_MOST_LINES]

    def _fault(self, event: Event, text: str) -> None:
        if event.agent:
            for agent in self._both(event.agent):
                agent.faults.append((event.t, text))
                del agent.faults[:-_MOST_LINES]

    def _commanded(self, event: ActuatorCommanded) -> None:
        for agent in self._both(event.agent):
            agent.route = event.route

    def _stopped(self, event: AgentStopped) -> None:
        for agent in self._both(event.agent):
            agent.route = "idle"

    def _judged(self, event: OutcomeDecided) -> None:
        for agent in self._both(event.agent):
            agent.outcome = event.outcome, event.reason, event.time_to_goal


SHOWN: tuple[type[Event], ...] = Picture().kinds
"""Kinds of events that the page shows; others are not sent to its process."""


def _rounded(value: float, digits: int) -> float:
    """Number rounded for display; 0 if it is not finite."""
    return round(value, digits) if math.isfinite(value) else 0.0


def _signal(value: float) -> float | str:
    """Value of a signal for JSON; non-finite numbers become texts."""
    if math.isfinite(value):
        return float(f"{value:.5g}")
    return "–" if math.isnan(value) else "∞" if value > 0 else "−∞"


def _range(value: float) -> float | None:
    """Range rounded to centimetres; None for no echo, -1 for an invalid value, as in the report."""
    if math.isnan(value):
        return -1.0
    return round(value, 2) if math.isfinite(value) else None


def _fact(value: Any) -> Any:
    if isinstance(value, float):
        return _signal(value)
    return [_fact(v) for v in value] if isinstance(value, (list, tuple)) else value
