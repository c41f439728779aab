"""Events of the world and of the judges of a run: motion, contacts, pushes, goals, requirements, and outcomes."""

from __future__ import annotations

import math
from typing import ClassVar

from msgspec import field

from .sink import Event, Level


class BodyMoved(Event, frozen=True, kw_only=True, omit_defaults=True):
    """A body moved: its ground-truth pose from the simulation, world frame; on hardware, the robot's own estimate.

    `height` of the base's origin, `roll`, `pitch` and `joints` are recorded for simulated robots without wheels only.
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
    joints: tuple[float, ...] = ()  # [rad, m], in the order of the body's links in the header, rounded to 0.001

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
    level: ClassVar[Level] = Level.ERROR

    @property
    def sentence(self) -> str:
        return f"struck by {self.other}" if self.kind == "struck" else f"{self.kind} with {self.other}"


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
    level: ClassVar[Level] = Level.WARNING

    @property
    def sentence(self) -> str:
        """The event for people; a robot without an agent is named."""
        subject = "" if self.agent else f"{self.body} was "
        return f"{subject}pushed by {math.hypot(*self.force):.3g} N for {self.duration:.3g} s (scripted)"


class ScriptActed(Event, frozen=True, kw_only=True):
    """The script of the run changed something of an agent: it broke a device, or gave a fact.

    Attributes:
        topic: Topic of the track that it changes: `sensor`, `command` of an actuator, or `fact`.
        name: Name of the sensor, actuator or node.
        what: Effect in words, such as `DeadSensor breaks the sensor sonar`.
        until: Time at which it ends [s]; None if it lasts.
    """

    topic: str
    name: str
    what: str
    until: float | None = None

    @property
    def sentence(self) -> str:
        return f"{self.what}{'' if self.until is None else f' until {self.until:.2f} s'} (scripted)"


class MinClearanceLowered(Event, frozen=True, kw_only=True):
    """An agent's hull has its smallest clearance of the run so far: `distance` [m], negative if penetrating."""

    other: str
    distance: float


class GoalEntered(Event, frozen=True, kw_only=True):
    """An agent's ground-truth pose came within the tolerance of a goal; `distance` from the goal [m]."""

    goal: str
    distance: float

    @property
    def sentence(self) -> str:
        return f"goal {self.goal} reached"


class RequirementViolated(Event, frozen=True, kw_only=True):
    """A requirement of the scenario is violated; emitted once, as soon as this is known.

    Attributes:
        requirement: Name of the requirement.
        about: Time of the violation [s].
        margin: Robustness margin at that time, negative; None if the requirement has no margin.
        reading: Values at that time, such as `speed = 1.2 m/s`; may be empty.
    """

    requirement: str
    about: float
    margin: float | None = None
    reading: str = ""
    level: ClassVar[Level] = Level.WARNING

    @property
    def sentence(self) -> str:
        return f"{self.requirement} was violated at {self.about:.2f} s" + (f" ({self.reading})" if self.reading else "")


class Stuck(Event, frozen=True, kw_only=True):
    """A robot on hardware made no progress for 15 s although it tried to move; the run continues.

    `rule` is the active reflex rule; empty if there is none.
    """

    reason: str
    rule: str = ""
    level: ClassVar[Level] = Level.WARNING

    @property
    def sentence(self) -> str:
        return self.reason


class OutcomeDecided(Event, frozen=True, kw_only=True):
    """An agent got its outcome, with a reason; docs/architecture.md lists the outcomes.

    `fell` is True if the robot fell, also if an outcome of higher precedence hides the fall.
    """

    outcome: str
    reason: str = ""
    time_to_goal: float | None = None  # [s]
    fell: bool = False

    @property
    def sentence(self) -> str:
        return f"outcome: {self.outcome}" + (f", {self.reason}" if self.reason else "")


class RunControlled(Event, frozen=True, kw_only=True):
    """A person controlled the run, for example from the live page.

    Attributes:
        command: `pause`, `step` (one control period), `continue`, `swap` (of a subtree) or `reload` (of a rule file).
        target: Root of the subtree, or name of the rule file.
        source: Mission with the new subtree.
        tree: ID of the new tree in the mission; empty for its main tree.
        content: Hash of the mission's content, as `content_hash` in summary.json.
        by: Name of the person or program.
        refusal: Reason why nothing was changed; empty if the command was applied.
    """

    command: str
    target: str = ""
    source: str = ""
    tree: str = ""
    content: str = ""
    by: str = ""
    refusal: str = ""

    @property
    def sentence(self) -> str:
        what = " ".join(
            filter(None, [self.command, self.target and f"'{self.target}'", self.source and f"by {self.source}"])
        )
        return f"{self.by}: {what}" + (self.refusal and f" refused: {self.refusal}")

    @property
    def level(self) -> Level:
        return Level.WARNING if self.refusal else Level.INFO
