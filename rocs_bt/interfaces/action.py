"""Actions: base classes of what Plan and reflexes request and Execute carries out (paper, 5.1).

The annotations of an action class are its parameters, in SI units, with dimension and valid range:

    class Nod(AtomicAction):
        \"\"\"Move the head once.\"\"\"
        angle: Radians = 0.3
        rate: PositiveRadiansPerSecond = 1.0
        def act(self, body: Body) -> Progress | Failure: ...
"""

from __future__ import annotations

import functools
import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from ..base.clock import Clock
from ..base.errors import InputError, interrupts, unknown
from ..base.raised import Raised
from ..declare import Declared, Field, checked, fields_of, refuse_faults
from ..event import Event, Value
from .device import Actuator

if TYPE_CHECKING:  # types of Body only: at run time this module imports no higher layer
    from ..base.geometry import Twist2, Twist3
    from ..control.follower import Follower
    from ..control.locomotion import Locomotion
    from ..control.trail import Trail
    from ..knowledge import Knowledge
    from .message import Messenger


class Progress(Enum):
    """Result of one period of an action that has not failed."""

    RUNNING = "RUNNING"
    SUCCEEDED = "SUCCEEDED"


class Reason(Enum):
    """Reason for the failure of an action or a leaf."""

    LOST_POSE = "the pose is unknown"
    LOST_LEADER = "the leader's position is unknown"
    LOST_SENSOR = "a required reading is invalid"
    NO_GOAL = "the goal is unknown"
    BLOCKED = "the path is blocked"
    STUCK = "no progress"
    TIMEOUT = "time limit exceeded"
    REFUSED = "a device refused"
    UNHEARD = "no acknowledgement"
    RUNAWAY = "no command after too many steps"
    CANNOT = "the robot cannot do it"
    RAISED = "an exception was raised"
    OTHER = "another reason"


@dataclass(frozen=True, slots=True)
class Failure:
    """Failure of an action, with its reason.

    Attributes:
        reason: Category of the failure.
        evidence: Details, such as `3 pre-emptions by AvoidCollision, front = 0.21 m`; may be empty.
    """

    reason: Reason
    evidence: str = ""

    @classmethod
    def cannot(cls, error: InputError) -> Failure:
        """Create the failure of an action with impossible parameters."""
        return cls(Reason.CANNOT, " ".join(str(fault) for fault in error.faults))

    def __str__(self) -> str:
        return f"{self.reason.name}: {self.evidence or self.reason.value}"


class ActionFailed(Exception):
    """Exception about a failed action.

    It is raised in `decompose` of a macro-action, at the `yield` of an action that has failed. An action may raise it
    to fail itself.
    """

    def __init__(self, reason: Reason, evidence: str = "") -> None:
        self.failure = Failure(reason, evidence)
        super().__init__(str(self.failure))


class Body(Protocol):
    """Interface of the robot for actions; the agent builds the object."""

    @property
    def clock(self) -> Clock:
        """Source of time."""
        ...

    @property
    def period(self) -> float:
        """Control period, the interval between calls of `act` [s]."""
        ...

    @property
    def knowledge(self) -> Knowledge:
        """Knowledge of the robot."""
        ...

    @property
    def locomotion(self) -> Locomotion:
        """Kinematics, limits and response of the body."""
        ...

    @property
    def follower(self) -> Follower:
        """Trajectory follower. One action at a time uses it, and resets it first."""
        ...

    @property
    def trail(self) -> Trail:
        """Poses that the robot has passed since the start."""
        ...

    @property
    def actuators(self) -> Mapping[str, Actuator]:
        """All actuators, by name."""
        ...

    @property
    def motion(self) -> Actuator:
        """Actuator of the locomotion; its commands are the values of `locomotion.values`."""
        ...

    def move(self, twist: Twist2 | Twist3) -> None:
        """Command a body twist for this period; motions that the body cannot make are ignored."""
        ...

    def rest(self) -> None:
        """Command the body not to move in this period: wheels brake, legs do not step, and a flying body hovers."""
        ...

    @property
    def messenger(self) -> Messenger | None:
        """Messenger to other robots; None if the robot shares nothing."""
        ...

    def note(self, event: type[Event], **values: Any) -> None:
        """Emit an event, as in `body.note(FollowerStepped, cross_track=0.01, ...)`; its time and agent are added."""
        ...


class Action(Declared, ABC):
    """Base class of atomic actions and macro-actions; the annotations of a subclass are its parameters.

    A name with an underscore is no parameter; `__post_init__` may compute further attributes.

    Attributes:
        live: Names of parameters that may change while the action runs: a tree node reads these ports in each tick.
    """

    live: ClassVar[tuple[str, ...]] = ()

    @property
    def name(self) -> str:
        """Name of the action in files, tickets and reports: the name of its class."""
        return type(self).__name__

    @property
    def parameters(self) -> dict[str, Value]:
        """Parameters as plain data."""
        return {name: _plain(getattr(self, name)) for name in parameters_of(type(self))}

    @classmethod
    def can_move(cls, parameters: Mapping[str, Any]) -> bool:
        """Whether the action can move the robot.

        Checks use this to warn about rules that could stop the robot for ever, because their action does not move it.

        Args:
            parameters: Values of parameters that are known before the action is created, by name.
        """
        return True

    def update(self, **parameters: Any) -> None:
        """Set parameters of a running action; called in each period in which the rule of a reflex stays latched.

        Raises:
            InputError: A parameter is unknown, or a value is out of bounds. Then no parameter is changed.
        """
        refuse_faults(parameters_of(type(self)), parameters, self.name)
        for name, value in parameters.items():
            setattr(self, name, value)

    @classmethod
    def misfits(cls, parameters: Mapping[str, Any], knowledge: Knowledge) -> Iterable[tuple[str, str]]:
        """Find parameter values that the robot does not support; none by default.

        The method is called when a mission or a rule file is checked, and when an agent is built.

        Args:
            parameters: Values of parameters that are known before the run, in SI units and of the declared types.
            knowledge: Knowledge of the robot.

        Returns:
            Pairs of parameter name and reason.
        """
        return ()

    def remaining(self, knowledge: Knowledge) -> float:
        """Distance that remains to be driven [m], from which Plan detects a lack of progress; NaN if unknown."""
        return math.nan

    def awaits(self) -> str:
        """What the running action waits for, beginning with `for` or `until`; empty if it does not wait."""
        return ""

    def resume(self, cut_off: Action) -> None:
        """Take over state, such as timers, from an action that a reflex interrupted and that this action replaces.

        Args:
            cut_off: Interrupted action, which may be of any class.
        """

    def stop(self, body: Body) -> None:
        """Clean up after the running action was cancelled; called once, before any other action sends commands."""


class AtomicAction(Action):
    """Action that commands actuators directly."""

    @abstractmethod
    def act(self, body: Body) -> Progress | Failure:
        """Act for one control period. The method is called once per period until the action ends; it must not block.

        If it raises `ActionFailed`, the action fails with this reason; if it raises `InputError`, with Reason.CANNOT.
        """


class MacroAction(Action):
    """Action that is decomposed into a sequence of smaller actions."""

    @abstractmethod
    def decompose(self, body: Body) -> Iterator[Action]:
        """Yield the actions to execute, one after the other; a generator, which may read Knowledge in between.

        The generator continues when the yielded action has succeeded. If that action fails, `ActionFailed` is raised at
        the `yield`; if it is not caught, the macro-action fails. If the generator raises `InputError`, the macro-action
        fails with Reason.CANNOT.
        """


class InvalidAction(AtomicAction):
    """Placeholder for an action with invalid parameters, which fails at once with CANNOT.

    With it, a reflex with invalid computed parameters still pre-empts the running action and is recorded.
    """

    def __init__(self, asked: str, parameters: Mapping[str, Any], error: InputError) -> None:
        self._asked = asked
        self._parameters = {name: _plain(value) for name, value in parameters.items()}
        self._failure = Failure.cannot(error)

    @property
    def name(self) -> str:
        return self._asked

    @property
    def parameters(self) -> dict[str, Value]:
        return self._parameters

    def update(self, **parameters: Any) -> None:
        """Do nothing, because a new action is created at the next request."""

    def act(self, body: Body) -> Failure:
        return self._failure


@functools.cache
def parameters_of(action: type[Action]) -> dict[str, Field]:
    """Parameters that an action class declares, by name, in order."""
    return {each.name: each for each in fields_of(action)}


def make_action(table: Mapping[str, type[Action]], name: str, parameters: Mapping[str, Any]) -> Action:
    """Create an action by its name, for a rule or a leaf.

    Raises:
        InputError: The action or a parameter is unknown, a required parameter is missing, or a value is of a wrong type
            or out of bounds.
    """
    if name not in table:
        raise InputError(unknown("action", name, table))
    return checked(table[name], parameters, name)


def misfits_of(action: type[Action], parameters: Mapping[str, Any], knowledge: Knowledge) -> Sequence[tuple[str, str]]:
    """Result of `Action.misfits`; if a user's class raises an exception, this is returned as a misfit."""
    try:
        return list(action.misfits(parameters, knowledge))
    except BaseException as error:  # a user's class may raise anything
        if interrupts(error):
            raise
        return [("misfits", f"it raised {Raised.of('action', action.__name__, error, action).detail}")]


def refuse_misfits(action: type[Action], parameters: Mapping[str, Any], knowledge: Knowledge) -> None:
    """Check that the robot supports parameter values which are known before the run.

    Raises:
        InputError: The robot does not support some of them; the error contains a fault for each.
    """
    if found := misfits_of(action, parameters, knowledge):
        raise InputError(*(f"{name} of {action.__name__}: {reason}." for name, reason in found))


def _plain(value: Any) -> Value:
    if type(value) in _PLAIN or isinstance(value, (bool, int, float, str)):
        plain: Value = value
        return plain
    try:
        return [float(v) for v in value]
    except (TypeError, ValueError):
        if isinstance(value, (list, tuple)):
            return f"{len(value)} points"  # a route has hundreds; its track has them
        return getattr(value, "__name__", type(value).__name__)


_PLAIN = frozenset((type(None), bool, int, float, str))
