"""Events of Execute, of the safety gates, and of blocks that failed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar

from ..base.raised import CodeLocation, Raised
from .sink import Event, Level, Value, unpack


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


class PathPlanned(Event, frozen=True, kw_only=True):
    """A motion action began to follow a path; `points` are its positions, world frame [m], close where it bends."""

    points: tuple[tuple[float, float], ...]


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
    level: ClassVar[Level] = Level.ERROR

    @property
    def sentence(self) -> str:
        return f"no command for {self.actuator} within its maximum age; it went to neutral"


class MotionHeld(Event, frozen=True, kw_only=True):
    """A safety gate holds an actuator in neutral, whatever is commanded, such as in an emergency stop."""

    actuator: str
    reason: str
    level: ClassVar[Level] = Level.WARNING

    @property
    def sentence(self) -> str:
        return f"{self.actuator} held in neutral: {self.reason}"


class MotionReleased(Event, frozen=True, kw_only=True):
    """A safety gate passes commands again after MotionHeld. `by` names the person or device; may be empty."""

    actuator: str
    by: str = ""

    @property
    def sentence(self) -> str:
        return f"{self.actuator} released" + (f" by {self.by}" if self.by else "")


class OtherPublisherFound(Event, frozen=True, kw_only=True):
    """A node that is not part of the run publishes commands of an actuator; `node` names it."""

    actuator: str
    topic: str
    node: str
    level: ClassVar[Level] = Level.WARNING

    @property
    def sentence(self) -> str:
        return f"{self.node} publishes on {self.topic} too: its commands override stops of {self.actuator}"


class LandingBegan(Event, frozen=True, kw_only=True):
    """A flying robot began to land, because it had not been commanded to move for the time in `[locomotion]`."""

    actuator: str


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
    level: ClassVar[Level] = Level.FATAL

    @property
    def what(self) -> str:
        """Failed part in words, such as `actuator wheels` or `block plan`."""
        return f"{'actuator' if self.owner == 'content' else 'block'} {self.block}"

    @property
    def sentence(self) -> str:
        return f"{self.what} {self.kind}: {self.detail}"


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

    @classmethod
    def of(cls, t: float, agent: str, raised: Raised, effect: str) -> ContentRaised:
        """Create the event from the description of the exception."""
        kind, content, detail, at = raised.kind, raised.content, raised.detail, raised.location
        file, line = (at.file.name, at.line) if at else ("", 0)
        return cls(t=t, agent=agent, kind=kind, content=content, detail=detail, file=file, line=line, effect=effect)

    level: ClassVar[Level] = Level.ERROR

    @property
    def raised(self) -> Raised:
        """Description of the exception."""
        location = CodeLocation(Path(self.file), self.line) if self.file else None
        return Raised(self.kind, self.content, self.detail, location)

    @property
    def sentence(self) -> str:
        return f"{self.raised}; {self.effect}"


class AgentStopped(Event, frozen=True, kw_only=True):
    """An agent was stopped; after this event it only cancels its remaining tickets. `by` is the cause."""

    by: str
