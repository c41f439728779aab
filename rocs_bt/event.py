"""What blocks tell the world about themselves: typed, frozen, stamped events.

Every block is given an `EventSink`; the recorder is one, a list in a test another. Events are data: they hold no
object of the engine, so they can be written, read back and compared.
"""

from __future__ import annotations

from collections.abc import Mapping

from .sink import Event as Event
from .sink import EventSink as EventSink
from .sink import Fanout as Fanout
from .sink import ListSink as ListSink
from .sink import NullSink as NullSink
from .sink import Value as Value
from .sink import pack as pack
from .sink import unpack as unpack


class SensorRead(Event, frozen=True, kw_only=True):
    """A sensor gave a sample. `stamp` is when the device took it [s]; `data` its packed values in SI units."""

    sensor: str
    stamp: float
    data: bytes

    @property
    def values(self) -> list[float]:
        """The values that were read, SI units."""
        return unpack(self.data)


class SensorFailed(Event, frozen=True, kw_only=True):
    """A sensor refused to be read; its signals go stale."""

    sensor: str
    detail: str


class SignalsWritten(Event, frozen=True, kw_only=True, omit_defaults=True):
    """A monitor, or an Analyze, wrote signals to Knowledge: names, sizes, and the packed values one after the other.

    `stamp` is when they were true [s], where that was not `t`; else it is not recorded.
    """

    monitor: str
    signals: tuple[str, ...]
    sizes: tuple[int, ...]
    data: bytes
    stamp: float | None = None

    @property
    def values(self) -> dict[str, list[float]]:
        """The values by signal, SI units."""
        flat, found, at = unpack(self.data), {}, 0
        for name, size in zip(self.signals, self.sizes, strict=True):
            found[name] = flat[at : at + size]
            at += size
        return found


class Change(Event, frozen=True, kw_only=True):
    """An Analyze block found that the world changed; delivered to Plan (paper, 4.2).

    Attributes:
        source: The Analyze block.
        kind: What changed: `obstacle`, `pose`, `reflex ended` ...
        subject: The node of the knowledge graph it is about; may be empty.
        values: The evidence, in SI units.
    """

    source: str
    kind: str
    subject: str = ""
    values: Mapping[str, Value] = {}


class KnowledgeChanged(Event, frozen=True, kw_only=True):
    """The knowledge graph changed.

    Attributes:
        what: `node added`, `node removed`, `attribute`, `edge added`, `edge changed`, `edge removed`.
        subject: Node, or the edge's source.
        name: Attribute, or the edge's relation, or the node's kind.
        value: The new value; an edge's target.
        revision: Knowledge's revision after it.
        attributes: The attributes of an edge that was added or changed.
    """

    what: str
    subject: str
    name: str
    value: Value = None
    revision: int = 0
    attributes: Mapping[str, Value] = {}


class SubscriberDetached(Event, frozen=True, kw_only=True):
    """A callback raised on a change of the knowledge graph and hears no more; `revision` is that change's."""

    callback: str
    revision: int
    detail: str


class RuleChanged(Event, frozen=True, kw_only=True):
    """A reflex rule did something.

    Attributes:
        rule: `file/Rule`.
        phase: `latched`, `fired` (an activation), `fired again` (the action ended while the rule was latched),
            `stopped` (its action raised), `waits`, `updated`, `released`, `ended`.
        priority: The rule's.
        reading: The rule's guard with its readings, such as `min(front) = 0.21 m`.
        parameters: The action's parameters, SI units.
        refirings: Number of times that the rule has fired again since this activation.
    """

    rule: str
    phase: str
    priority: int
    reading: str = ""
    parameters: Mapping[str, Value] = {}
    refirings: int = 0


class RulesReplaced(Event, frozen=True, kw_only=True):
    """A rule file changed while the agent ran: its rules were put in force, or the old ones left there.

    Attributes:
        rules: The rule file's name.
        accepted: Whether the new rules are in force.
        detail: What is in force now, or what is wrong with the file.
    """

    rules: str
    accepted: bool
    detail: str


class NodeTicked(Event, frozen=True, kw_only=True):
    """A node of the mission tree changed its status. `node` is its path from the root, names joined by `/`."""

    node: str
    status: str
    feedback: str = ""


class SubtreeSwapped(Event, frozen=True, kw_only=True):
    """A subtree of the running mission was put in another's place.

    Attributes:
        node: The path of the root of the one that left.
        by: The path of the root of the one that came.
        nodes: The whole tree from now on, parents before children: each node's path, class and parent's path.
    """

    node: str
    by: str
    nodes: tuple[tuple[str, str, str], ...]


class Replanned(Event, frozen=True, kw_only=True):
    """A leaf submitted its action anew after a reflex. `count` is how often it has."""

    node: str
    count: int


class Said(Event, frozen=True, kw_only=True):
    """A mission said something: `aloud`, for people nearby, or for the log only. `node` is the path of the leaf."""

    node: str
    text: str
    aloud: bool = False


class TicketChanged(Event, frozen=True, kw_only=True):
    """An action's ticket changed its state.

    Attributes:
        ticket: Its number, counted from 1 in each agent.
        action: The action's name.
        parameters: The action's parameters, SI units.
        priority: `NORMAL` or `HIGH`.
        state: `QUEUED`, `RUNNING`, `SUCCEEDED`, `FAILED`, `CANCELLED`.
        by: Who submitted it, or who cancelled it.
        reason: Why it failed, with the evidence.
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
    """Execute sent a command; `data` holds the packed values, SI units (wheel rim speeds [m/s])."""

    actuator: str
    route: str
    data: bytes

    @property
    def values(self) -> list[float]:
        """The commanded values, SI units."""
        return unpack(self.data)


class Followed(Event, frozen=True, kw_only=True):
    """The trajectory follower solved one tick. `solve_time` is wall time [s], zero where nobody measured."""

    cross_track: float  # [m], left of the path positive
    heading_error: float  # [rad]
    rung: str
    solve_time: float = 0.0


class BlockFailed(Event, frozen=True, kw_only=True):
    """A block or an actuator raised, ended or hung; the wheels were stopped first.

    Attributes:
        block: Name of the block or of the actuator.
        kind: `raised`, `ended` or `hung`.
        detail: Reason.
        owner: `content` if an actuator failed, whose driver belongs to the robot's content; else `engine`.
    """

    block: str
    kind: str
    detail: str
    owner: str = "engine"

    @property
    def what(self) -> str:
        """The failed part in words, such as `actuator wheels` or `block plan`."""
        return f"{'actuator' if self.owner == 'content' else 'block'} {self.block}"


class ContentRaised(Event, frozen=True, kw_only=True):
    """Content raised an exception; reported once while a sensor or monitor goes on to raise.

    Attributes:
        kind: `leaf`, `planner`, `route planner`, `action`, `reflex action`, `sensor`, `monitor` ...
        content: Its name, such as the path of a leaf or the class of an action.
        detail: Type and message of the exception.
        file: Name of the file of content; empty where no line of content took part. `line` is the line in it.
        effect: What the agent does about it, such as `brakes, and asks the plan again`.
    """

    kind: str
    content: str
    detail: str
    file: str = ""
    line: int = 0
    effect: str = ""


class AgentStopped(Event, frozen=True, kw_only=True):
    """An agent was stopped, and does nothing after this but to cancel what is left. `by` says who stopped it."""

    by: str


class PeerCame(Event, frozen=True, kw_only=True):
    """An agent that shares its knowledge came, or came back; `start` tells its starts apart."""

    peer: str
    start: str


class PeerVanished(Event, frozen=True, kw_only=True):
    """An agent that shares its knowledge has left, or is no longer heard of; `start` tells its starts apart."""

    peer: str
    start: str


class PeerFault(Event, frozen=True, kw_only=True):
    """What is wrong between an agent and a peer that shares its knowledge; once for each kind and start of the peer.

    `kind` is `refused` (a write of the peer was refused), `behind` (the peer's clock was behind, and was corrected) or
    `clock` (this agent's own clock was behind the peer's, and was corrected).
    """

    peer: str
    start: str
    kind: str
    detail: str


class BodyMoved(Event, frozen=True, kw_only=True):
    """True pose of a body in the world frame, from the simulation; on hardware the robot's own estimate."""

    body: str
    x: float  # [m]
    y: float  # [m]
    yaw: float  # [rad]
    wheels: bytes = b""  # [m/s]


class Touched(Event, frozen=True, kw_only=True):
    """A contact began, told by the simulation; `kind` is `collision` or `struck` (docs/architecture.md)."""

    other: str
    kind: str


class Approached(Event, frozen=True, kw_only=True):
    """An agent's hull came nearer to something than ever before in its run: `distance` [m], negative inside."""

    other: str
    distance: float


class GoalEntered(Event, frozen=True, kw_only=True):
    """An agent truly came within the tolerance of a goal, told by the simulation; `distance` [m] from it."""

    goal: str
    distance: float


class RequirementViolated(Event, frozen=True, kw_only=True):
    """A requirement of the scenario does not hold; told once, when it is known.

    Attributes:
        requirement: Its name.
        about: When it did not hold [s].
        margin: How far it is from holding, negative; None where it has no number.
    """

    requirement: str
    about: float
    margin: float | None = None


class CommandLimited(Event, frozen=True, kw_only=True):
    """The safety gate scaled a command that exceeded the actuator's limits.

    Attributes:
        actuator: Name of the actuator.
        wanted: Wanted command, SI units.
        given: Command that the device got, SI units.
        action: Name of the atomic action that commanded; empty outside of actions.
    """

    actuator: str
    wanted: tuple[float, ...]
    given: tuple[float, ...]
    action: str = ""


class CommandExpired(Event, frozen=True, kw_only=True):
    """No command came for too long: the actuator's watchdog went to neutral."""

    actuator: str


class Stuck(Event, frozen=True, kw_only=True):
    """A robot on hardware made no progress for 15 s while it tried to move; the run goes on. `rule` may be empty."""

    reason: str
    rule: str = ""


class Judged(Event, frozen=True, kw_only=True):
    """An agent's outcome and its reason; the outcomes are listed in docs/architecture.md."""

    outcome: str
    reason: str = ""
    time_to_goal: float | None = None  # [s]
