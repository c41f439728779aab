"""Events that blocks emit: typed, immutable, with a time stamp.

Every block gets an `EventSink`, such as the recorder, or a list in a test. Events contain plain data and no objects of
the engine, so they can be written, read back and compared.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from msgspec import field

from .errors import RecordingError
from .sink import Event as Event
from .sink import EventSink as EventSink
from .sink import Fanout as Fanout
from .sink import ListSink as ListSink
from .sink import NullSink as NullSink
from .sink import Value as Value
from .sink import pack as pack
from .sink import unpack as unpack


class SensorRead(Event, frozen=True, kw_only=True):
    """A sensor was read. `stamp` is the device's sampling time [s]; `data` the packed values in SI units."""

    sensor: str
    stamp: float
    data: bytes

    @property
    def values(self) -> list[float]:
        """Values of the reading, SI units."""
        return unpack(self.data)


class SensorFailed(Event, frozen=True, kw_only=True):
    """A sensor could not be read; its signals become stale."""

    sensor: str
    detail: str


class SignalsWritten(Event, frozen=True, kw_only=True, omit_defaults=True):
    """A monitor or an analyser wrote signals to Knowledge: names, sizes, and the concatenated packed values.

    `stamp` is the time to which the values refer [s]; None if it equals `t`.
    """

    monitor: str
    signals: tuple[str, ...]
    sizes: tuple[int, ...]
    data: bytes
    stamp: float | None = None

    @property
    def values(self) -> dict[str, list[float]]:
        """Values of each signal, SI units, by name of the signal.

        Raises:
            RecordingError: The sizes, of a damaged recording, do not fit the values.
        """
        flat, found, at = unpack(self.data), {}, 0
        if len(self.sizes) != len(self.signals) or sum(self.sizes) != len(flat) or min(self.sizes, default=0) < 0:
            raise RecordingError(
                f"the recording is damaged: '{self.monitor}' wrote {len(flat)} values at t = {self.t:g} s."
            )
        for name, size in zip(self.signals, self.sizes, strict=True):
            found[name] = flat[at : at + size]
            at += size
        return found


class Change(Event, frozen=True, kw_only=True):
    """An analyser detected a change of the world; the event is also passed to Plan (paper, 4.2).

    Attributes:
        source: Name of the analyser.
        kind: Kind of the change, such as `obstacle` or `arrived`.
        subject: Node of the knowledge graph that changed; may be empty.
        values: Values that describe the change, in SI units.
    """

    source: str
    kind: str
    subject: str = ""
    values: Mapping[str, Value] = {}


class KnowledgeChanged(Event, frozen=True, kw_only=True):
    """The knowledge graph changed.

    Attributes:
        what: Kind of the change: `node added`, `node removed`, `attribute`, `edge added`, `edge changed`, `edge
            removed`.
        subject: Node, or source of the edge.
        name: Attribute, relation of the edge, or kind of the node.
        value: New value; for an edge, its target.
        revision: Revision of Knowledge after the change.
        attributes: Attributes of an added or changed edge.
    """

    what: str
    subject: str
    name: str
    value: Value = None
    revision: int = 0
    attributes: Mapping[str, Value] = {}


class SubscriberDetached(Event, frozen=True, kw_only=True):
    """A subscriber of knowledge changes raised an exception and was detached; `revision` is that of the change."""

    callback: str
    revision: int
    detail: str


class RuleChanged(Event, frozen=True, kw_only=True):
    """A reflex rule changed its state.

    Attributes:
        rule: Rule as `file/Rule`.
        phase: New state: `latched`, `fired` (its activation began), `fired again` (the action had ended while the rule
            was latched), `stopped` (the action raised an exception, so Stop replaces it), `waits` (another reflex is
            active), `updated` (parameters changed), `released`, `ended` (its activation ended).
        priority: Priority of the rule.
        reading: Guard values of the rule, such as `min(front) = 0.21 m`.
        parameters: Parameters of the action, SI units.
        refirings: Number of times that the rule has fired again since this activation.
    """

    rule: str
    phase: str
    priority: int
    reading: str = ""
    parameters: Mapping[str, Value] = {}
    refirings: int = 0


class RulesReplaced(Event, frozen=True, kw_only=True):
    """A rule file changed during the run: its new rules were activated, or refused, and the old rules kept.

    Attributes:
        rules: Name of the rule file.
        accepted: Whether the new rules are active.
        detail: Description of the active rules, or faults of the file.
    """

    rules: str
    accepted: bool
    detail: str


class NodeTicked(Event, frozen=True, kw_only=True):
    """A node of the mission's tree changed its status, or the mission waits in it and what it waits for changed.

    Attributes:
        node: Path of the node: names from the root, joined by `/`.
        status: Status of the node.
        feedback: Feedback of the node; while the mission waits in it, the values and deadline for which it waits.
    """

    node: str
    status: str
    feedback: str = ""


class SubtreeSwapped(Event, frozen=True, kw_only=True):
    """A subtree of the running mission was replaced.

    Attributes:
        node: Path of the root of the removed subtree.
        by: Path of the root of the new subtree.
        nodes: The whole new tree, parents before children: path, class and parent's path of each node.
        ports: Given ports of each node as text, such as `(goal="kitchen")`.
    """

    node: str
    by: str
    nodes: tuple[tuple[str, str, str], ...]
    ports: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """The swap in words."""
        return f"'{self.node}' was replaced by '{self.by}'"


class SwapRefused(Event, frozen=True, kw_only=True):
    """A subtree of the running mission was not replaced as requested; the old one remains in use.

    Attributes:
        node: Path or name of the subtree's root, as requested.
        detail: Reason.
    """

    node: str
    detail: str

    @property
    def text(self) -> str:
        """The refusal in words."""
        return f"'{self.node}' was not replaced: {self.detail}"


class Replanned(Event, frozen=True, kw_only=True):
    """A leaf submitted its action again after a reflex; `count` is the number of times that it did so far."""

    node: str
    count: int


class BlackboardChanged(Event, frozen=True, kw_only=True):
    """A value on a blackboard of the mission's tree changed in a tick.

    Attributes:
        key: Key on this blackboard.
        value: New value as a text of at most 120 characters; empty if the key has no value any more.
        subtree: Path of the subtree with this blackboard; empty for the blackboard of the main tree.
    """

    key: str
    value: str
    subtree: str = ""

    @property
    def text(self) -> str:
        """The change in words."""
        at = f" in {self.subtree}" if self.subtree else ""
        return f"{self.key} = {self.value}{at}" if self.value else f"{self.key} has no value{at}"


class Said(Event, frozen=True, kw_only=True):
    """A leaf of a mission issued a message.

    Attributes:
        node: Path of the leaf.
        text: The message.
        aloud: Whether the message is for people near the robot, and not for the log only.
    """

    node: str
    text: str
    aloud: bool = False


class TicketChanged(Event, frozen=True, kw_only=True):
    """The ticket of an action changed its state.

    Attributes:
        ticket: Number of the ticket, counted from 1 in each agent.
        action: Name of the action.
        parameters: Parameters of the action, SI units.
        priority: `NORMAL` or `HIGH`.
        state: New state: `QUEUED`, `RUNNING`, `SUCCEEDED`, `FAILED`, `CANCELLED`.
        by: Block, leaf or rule that submitted or cancelled the ticket.
        reason: Reason of a failure, with evidence.
    """

    ticket: int
    action: str
    priority: str
    state: str
    by: str
    reason: str = ""
    parameters: Mapping[str, Value] = {}


class AtomicStarted(Event, frozen=True, kw_only=True):
    """Execute began an atomic action of a ticket; `route` is `reactive` or `deliberative`."""

    ticket: int
    action: str
    route: str
    parameters: Mapping[str, Value] = {}


class ActuatorCommanded(Event, frozen=True, kw_only=True):
    """Execute sent a command; `data` contains the packed values, SI units: wheel linear speeds, or a twist."""

    actuator: str
    route: str
    data: bytes

    @property
    def values(self) -> list[float]:
        """Commanded values, SI units."""
        return unpack(self.data)


class FollowerStepped(Event, frozen=True, kw_only=True):
    """The trajectory follower computed one command. `solve_time` is wall time [s]; zero if not measured."""

    cross_track: float  # [m], left of the path positive
    heading_error: float  # [rad]
    rung: str
    solve_time: float = 0.0


class BlockFailed(Event, frozen=True, kw_only=True):
    """A block or an actuator failed: it raised an exception, ended, or hung. The robot was stopped first.

    Attributes:
        block: Name of the block or of the actuator.
        kind: `raised`, `ended` or `hung`.
        detail: Reason of the failure.
        owner: Owner of the failed code: `content` for an actuator (its driver belongs to the robot); else `engine`.
    """

    block: str
    kind: str
    detail: str
    owner: str = "engine"

    @property
    def what(self) -> str:
        """Failed part in words, such as `actuator wheels` or `block plan`."""
        return f"{'actuator' if self.owner == 'content' else 'block'} {self.block}"


class ContentRaised(Event, frozen=True, kw_only=True):
    """User content raised an exception. For a sensor or monitor that raises repeatedly, only the first is reported.

    Attributes:
        kind: Kind of the content: `leaf`, `planner`, `route planner`, `action`, `reflex action`, `sensor`, `monitor`
            ...
        content: Name of the content, such as the path of a leaf or the class of an action.
        detail: Type and message of the exception.
        file: Name of the content file; empty if no line of content is in the traceback.
        line: Line in the file.
        effect: Reaction of the agent, such as `brakes and replans (1 of 3 within 10 s)`.
    """

    kind: str
    content: str
    detail: str
    file: str = ""
    line: int = 0
    effect: str = ""


class AgentStopped(Event, frozen=True, kw_only=True):
    """An agent was stopped; after this event it only cancels its remaining tickets. `by` is the cause."""

    by: str


class PeerAppeared(Event, frozen=True, kw_only=True):
    """An agent that shares its knowledge appeared or reappeared; `start` identifies its process start."""

    peer: str
    start: str


class PeerVanished(Event, frozen=True, kw_only=True):
    """An agent that shares its knowledge left or is no longer received; `start` identifies its process start."""

    peer: str
    start: str


class PeerFault(Event, frozen=True, kw_only=True):
    """A fault occurred in the exchange of knowledge with a peer; emitted once per kind and start of the peer.

    `kind` is `refused` (a write of the peer was refused), `behind` (the peer's clock was behind, and was corrected) or
    `clock` (this agent's own clock was behind the peer's, and was corrected).
    """

    peer: str
    start: str
    kind: str
    detail: str


class BodyMoved(Event, frozen=True, kw_only=True, omit_defaults=True):
    """A body moved: its ground-truth pose from the simulation, world frame; on hardware, the robot's own estimate.

    `height` of the base's origin, `roll` and `pitch` are recorded for simulated robots without wheels only.
    """

    agent: str = field(default_factory=str)  # a factory's default is not omitted from recordings
    body: str
    x: float  # [m]
    y: float  # [m]
    yaw: float  # [rad]
    wheels: bytes = field(default_factory=bytes)  # [m/s]
    height: float | None = None  # [m]
    roll: float | None = None  # [rad]
    pitch: float | None = None  # [rad]

    @property
    def tilt(self) -> float:
        """Angle between the base's z axis and the vertical [rad], in [0, pi]; NaN if it is not recorded."""
        if self.roll is None or self.pitch is None:
            return math.nan
        return math.acos(max(-1.0, min(1.0, math.cos(self.roll) * math.cos(self.pitch))))


class ContactBegan(Event, frozen=True, kw_only=True):
    """A contact of an agent's robot began in simulation; `kind` is `collision` or `struck` (docs/architecture.md)."""

    other: str
    kind: str


class RobotPushed(Event, frozen=True, kw_only=True):
    """A scheduled push of a robot's base began in simulation.

    Attributes:
        body: Name of the robot.
        force: Force [N] forward, to the left and up, horizontal frame of the base.
        duration: Duration of the push [s].
    """

    body: str
    force: tuple[float, float, float]
    duration: float

    @property
    def text(self) -> str:
        """Description of the push in words."""
        return f"pushed by {math.hypot(*self.force):.3g} N for {self.duration:.3g} s"


class MinClearanceLowered(Event, frozen=True, kw_only=True):
    """An agent's hull has its smallest clearance of the run so far: `distance` [m], negative if penetrating."""

    other: str
    distance: float


class GoalEntered(Event, frozen=True, kw_only=True):
    """An agent's ground-truth pose came within the tolerance of a goal; `distance` from the goal [m]."""

    goal: str
    distance: float


class RequirementViolated(Event, frozen=True, kw_only=True):
    """A requirement of the scenario is violated; emitted once, as soon as this is known.

    Attributes:
        requirement: Name of the requirement.
        about: Time of the violation [s].
        margin: Robustness margin at that time, negative; None if the requirement has no margin.
    """

    requirement: str
    about: float
    margin: float | None = None


class CommandLimited(Event, frozen=True, kw_only=True):
    """A safety gate reduced a command that exceeded the actuator's limits.

    Attributes:
        actuator: Name of the actuator.
        wanted: Requested command, SI units.
        given: Command sent to the device, SI units.
        action: Name of the atomic action that commanded; empty outside of actions.
    """

    actuator: str
    wanted: tuple[float, ...]
    given: tuple[float, ...]
    action: str = ""


class CommandExpired(Event, frozen=True, kw_only=True):
    """The watchdog of an actuator sent it to neutral, because no command had arrived in time."""

    actuator: str


class MotionHeld(Event, frozen=True, kw_only=True):
    """A safety gate holds an actuator in neutral, whatever is commanded, such as in an emergency stop."""

    actuator: str
    reason: str


class MotionReleased(Event, frozen=True, kw_only=True):
    """A safety gate passes commands again after MotionHeld. `by` names the person or device; may be empty."""

    actuator: str
    by: str = ""


class OtherPublisherFound(Event, frozen=True, kw_only=True):
    """A node that is not part of the run publishes commands of an actuator; `node` names it."""

    actuator: str
    topic: str
    node: str

    @property
    def text(self) -> str:
        """Sentence about the event."""
        return f"{self.node} publishes on {self.topic} too: its commands override stops of {self.actuator}"


class LandingBegan(Event, frozen=True, kw_only=True):
    """A flying robot began to land, because it had not been commanded to move for the time in `[locomotion]`."""

    actuator: str


class Stuck(Event, frozen=True, kw_only=True):
    """A robot on hardware made no progress for 15 s although it tried to move; the run continues.

    `rule` is the active reflex rule; empty if there is none.
    """

    reason: str
    rule: str = ""


class OutcomeDecided(Event, frozen=True, kw_only=True):
    """An agent got its outcome, with a reason; docs/architecture.md lists the outcomes.

    `fell` is True if the robot fell, also if an outcome of higher precedence hides the fall.
    """

    outcome: str
    reason: str = ""
    time_to_goal: float | None = None  # [s]
    fell: bool = False
