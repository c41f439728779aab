"""Actions: what Plan and the reflexes ask for, and Execute carries out (paper, 5.1; docs/architecture.md).

An action is a dataclass whose fields are its parameters, in SI units; a field's annotation tells files which
dimension they must give, and which numbers make sense:

    @dataclass(kw_only=True, eq=False)
    class Nod(AtomicAction):
        \"\"\"Move the head once.\"\"\"
        angle: Radians = 0.3
        rate: PositiveRadiansPerSecond = 1.0
        def act(self, body: Body) -> Progress | Failure: ...
"""

from __future__ import annotations

import dataclasses
import functools
import math
import typing
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from .clock import Clock
from .device import Actuator
from .errors import Fault, InputError, interrupts, unknown
from .event import Event, Value
from .parameter import Parameter as Parameter
from .raised import Raised

if TYPE_CHECKING:  # for the types of Body alone; at run time every arrow points down
    from .control.drive import Drive
    from .control.follower import Follower
    from .knowledge import Knowledge
    from .knowledge.share import Messenger


class Progress(Enum):
    """What an action that did not fail says of itself."""

    RUNNING = "RUNNING"
    SUCCEEDED = "SUCCEEDED"


class Reason(Enum):
    """Why an action or a leaf failed."""

    LOST_POSE = "the pose is not known"
    LOST_LEADER = "nobody knows where the leader is"
    LOST_SENSOR = "a reading that it needs is not valid"
    NO_GOAL = "the goal is not known"
    BLOCKED = "the way is blocked"
    STUCK = "no progress"
    TIMEOUT = "it took too long"
    REFUSED = "a device refused"
    UNHEARD = "nobody acknowledged it"
    RUNAWAY = "it never came to a command"
    CANNOT = "the robot cannot do it"
    RAISED = "it raised an exception"
    OTHER = "for a reason of its own"


@dataclass(frozen=True, slots=True)
class Failure:
    """A failed act, with its evidence, such as `no progress: 3 pre-emptions by AvoidCollision, front = 0.21 m`."""

    reason: Reason
    evidence: str = ""

    @classmethod
    def cannot(cls, error: InputError) -> Failure:
        """The failure of who was asked for something impossible."""
        return cls(Reason.CANNOT, " ".join(str(fault) for fault in error.faults))

    def __str__(self) -> str:
        return f"{self.reason.name}: {self.evidence or self.reason.value}"


class ActionFailed(Exception):
    """Raised inside `decompose` where a yielded action failed; raised by it to fail the macro itself."""

    def __init__(self, reason: Reason, evidence: str = "") -> None:
        self.failure = Failure(reason, evidence)
        super().__init__(str(self.failure))


class Body(Protocol):
    """What an action may use; built by the agent."""

    @property
    def clock(self) -> Clock:
        """Time."""
        ...

    @property
    def period(self) -> float:
        """The control period: `act` is called this often [s]."""
        ...

    @property
    def knowledge(self) -> Knowledge:
        """All that the robot knows."""
        ...

    @property
    def drive(self) -> Drive:
        """Kinematics and limits of the wheels."""
        ...

    @property
    def follower(self) -> Follower:
        """The trajectory follower; one user at a time, who resets it first."""
        ...

    @property
    def actuators(self) -> Mapping[str, Actuator]:
        """All actuators, by name."""
        ...

    @property
    def wheels(self) -> Actuator:
        """The actuator that takes the drive's wheel rim speeds [m/s]."""
        ...

    @property
    def messenger(self) -> Messenger | None:
        """Sends messages to other robots; None where the robot shares nothing."""
        ...

    def note(self, event: type[Event], **values: Any) -> None:
        """Tell the record something, as in `body.note(Followed, cross_track=0.01, ...)`; time and agent are added."""
        ...


@dataclass(kw_only=True, eq=False)
class Action(ABC):
    """The common part of atomic actions and macro-actions; the dataclass fields of a subclass are its parameters.

    Attributes:
        live: The parameters that Plan keeps up to date while the action runs, from the keys that its node reads.
    """

    live: ClassVar[tuple[str, ...]] = ()

    @property
    def name(self) -> str:
        """What files, tickets and reports call it: the class's name."""
        return type(self).__name__

    @property
    def parameters(self) -> dict[str, Value]:
        """The parameters as plain data."""
        return {name: _plain(getattr(self, name)) for name in parameters_of(type(self))}

    @classmethod
    def can_move(cls, parameters: Mapping[str, Any]) -> bool:
        """Whether the action can move the robot; rules whose action cannot are examined for holding it for ever.

        Args:
            parameters: The parameters that are known before the action is made, by name.
        """
        return True

    def update(self, **parameters: Any) -> None:
        """Take new parameters while acting; a reflex does so while its rule stays latched.

        Raises:
            InputError: No parameter has that name, or a value is out of its bounds; then all stay as they were.
        """
        if faults := _faults(type(self), parameters):
            raise InputError(*faults)
        for name, value in parameters.items():
            setattr(self, name, value)

    @classmethod
    def misfits(cls, parameters: Mapping[str, Any], knowledge: Knowledge) -> Iterable[tuple[str, str]]:
        """Parameters that a robot cannot carry out: each name with the reason; none by default.

        Called when a mission or a rule file is checked, and when an agent is built.

        Args:
            parameters: Parameters that are known before the run, in SI units and of the declared types.
            knowledge: Knowledge of the robot.
        """
        return ()

    def remaining(self, knowledge: Knowledge) -> float:
        """How far it is from done [m], by which Plan tells progress from being stuck; NaN where nobody can say."""
        return math.nan

    def resume(self, cut_off: Action) -> None:
        """Take over the timers of the action that a reflex cut off, in whose place it is submitted; of any class."""

    def stop(self, body: Body) -> None:
        """Called once when the action is cancelled while it runs, before any other action commands."""


class AtomicAction(Action):
    """An action that commands actuators itself."""

    @abstractmethod
    def act(self, body: Body) -> Progress | Failure:
        """Do one control period's worth; called once a period until it is done. Must not block.

        An `ActionFailed` or an `InputError` that it raises is its failure, the latter for Reason.CANNOT.
        """


class MacroAction(Action):
    """An action made of smaller ones."""

    @abstractmethod
    def decompose(self, body: Body) -> Iterator[Action]:
        """Yield the next smaller action when the one before has succeeded, reading Knowledge as it goes.

        Where a yielded action fails, `ActionFailed` is raised at the `yield`; what is not caught fails the macro. So
        does an `InputError`, for Reason.CANNOT.
        """


class InvalidAction(AtomicAction):
    """Stands in for an action that cannot be made as it was asked for, and fails at once (CANNOT).

    A reflex whose parameters come out impossible must still stop what runs, and be told of, as any other.

    Args:
        asked: The action's name.
        parameters: What was asked of it.
        error: Why it cannot be.
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
        """Nothing makes it possible: it is made anew when it is asked for again."""

    def act(self, body: Body) -> Failure:
        return self._failure


@functools.cache
def parameters_of(action: type[Action]) -> dict[str, Parameter]:
    """The parameters that an action class declares, in their order."""
    hints = typing.get_type_hints(action, include_extras=True, localns=_hint_names())
    found = {}
    for field in dataclasses.fields(action):
        if not field.init:
            continue
        required = field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
        default = None if required or field.default is dataclasses.MISSING else field.default
        found[field.name] = Parameter.annotated(field.name, hints[field.name], required, default)
    return found


def make_action(table: Mapping[str, type[Action]], name: str, parameters: Mapping[str, Any]) -> Action:
    """An action by name, as rules and leaves ask for it.

    Raises:
        InputError: The name, or a parameter, does not exist, a required one is missing, or a value is not of its type
            or out of its bounds; lists what does exist.
    """
    if name not in table:
        raise InputError(unknown("action", name, table))
    declared = parameters_of(table[name])
    faults = _faults(table[name], parameters)
    missing = [p for p, d in declared.items() if d.required and p not in parameters]
    if missing:
        faults.append(Fault(f"{name} needs {', '.join(missing)}.", hint=f"It takes: {', '.join(declared)}."))
    if faults:
        raise InputError(*faults)
    return table[name](**parameters)


def misfits_of(action: type[Action], parameters: Mapping[str, Any], knowledge: Knowledge) -> Sequence[tuple[str, str]]:
    """`Action.misfits`; what it raises, as a user's class may, is a misfit too."""
    try:
        return list(action.misfits(parameters, knowledge))
    except BaseException as error:  # a user's class may raise anything
        if interrupts(error):
            raise
        return [("misfits", f"it raised {Raised.of('action', action.__name__, error, action).detail}")]


def refuse_misfits(action: type[Action], parameters: Mapping[str, Any], knowledge: Knowledge) -> None:
    """Refuse parameters, known before the run, that a robot cannot carry out.

    Raises:
        InputError: There are such parameters; a fault for each.
    """
    if found := misfits_of(action, parameters, knowledge):
        raise InputError(*(f"{name} of {action.__name__}: {reason}." for name, reason in found))


def _faults(action: type[Action], parameters: Mapping[str, Any]) -> list[Fault]:
    """What is wrong with values for an action's parameters: names and bounds."""
    declared, name, faults = parameters_of(action), action.__name__, list[Fault]()
    for key, value in parameters.items():
        if key not in declared:
            faults.append(unknown(f"parameter of {name}", key, declared, name))
        else:
            faults += declared[key].faults(value, f"{key} of {name}")
    return faults


def _plain(value: Any) -> Value:
    if type(value) in _PLAIN or isinstance(value, (bool, int, float, str)):
        plain: Value = value
        return plain
    try:
        return [float(v) for v in value]
    except (TypeError, ValueError):
        return getattr(value, "__name__", type(value).__name__)


_PLAIN = frozenset((type(None), bool, int, float, str))


def _hint_names() -> dict[str, Any]:
    # Fields may be annotated with names that their module imports for type checking only.
    return {"Body": Body}
