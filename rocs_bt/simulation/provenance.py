"""Code provenance: the classes of the engine that a built agent consists of."""

from __future__ import annotations

import enum
import gc
import sys
import types
from collections.abc import Iterable, Iterator, Mapping, Sequence

from ..action import Action
from ..agent import Agent
from ..plan import Act
from ..reactive import RuleModel

_ENGINE = __package__.partition(".")[0]
_MAKERS = ("actions", "analyze", "control", "monitor")  # whose objects make others only once the robot drives
_MADE = ("actions", "control")


def used_classes(agent: Agent, foreign: Sequence[object], actions: Mapping[str, type[Action]]) -> tuple[type, ...]:
    """The engine's classes that an agent is made of, devices included, sorted by their names.

    Everything that can be reached from the agent counts, and the actions that its mission's leaves and its rules name.
    So do the actions and the numerics that these, and its blocks, take in: what they decompose into, and the paths,
    references and filters that they make once the robot drives. What holds values only (frozen dataclasses, tuples,
    enums) does not, nor do private classes; the bases of what counts do.

    Args:
        agent: A built agent; it need not have run.
        foreign: What it holds and shares with others: the world, its clock, the sink.
        actions: Its action table.
    """
    things = list(_reachable(agent, foreign))
    found = set(_with_taken_in({type(thing) for thing in things} | set(_asked_for(things, actions))))
    bases = {base for cls in found for base in cls.__mro__}
    return tuple(sorted(filter(is_counted, bases), key=lambda cls: (cls.__module__, cls.__qualname__)))


def package_of(cls: type) -> str:
    """The engine's folder in which a class stands, such as `monitor`; the module's name for those at its root."""
    return cls.__module__.split(".")[1]


def is_counted(cls: type) -> bool:
    """Whether a class is the engine's, nobody's private one, and holds more than values."""
    if cls.__module__.partition(".")[0] != _ENGINE or cls.__name__.startswith("_"):
        return False
    parameters = getattr(cls, "__dataclass_params__", None)
    return not ((parameters and parameters.frozen) or issubclass(cls, (tuple, enum.Enum)))


def _reachable(root: object, foreign: Sequence[object]) -> Iterator[object]:
    """Every object that hangs on another; functions stand for what they have bound, not for their module."""
    seen, open_ = set(map(id, foreign)), [root]
    while open_:
        thing = open_.pop()
        if id(thing) in seen or isinstance(thing, (type, types.ModuleType, types.CodeType)):
            continue
        seen.add(id(thing))
        yield thing
        if isinstance(thing, types.FunctionType):
            open_ += [*(thing.__closure__ or ()), *(thing.__defaults__ or ())]
        else:
            open_ += gc.get_referents(thing)


def _asked_for(things: Iterable[object], actions: Mapping[str, type[Action]]) -> Iterator[type[Action]]:
    """The actions that leaves and rules ask for."""
    for thing in things:
        if isinstance(thing, Act):
            yield type(thing.make())
        elif isinstance(thing, RuleModel):
            yield from (actions[rule.action] for rule in thing.rules.rules)


def _with_taken_in(classes: Iterable[type]) -> Iterator[type]:
    """Classes, and the actions and numerics that their modules take in, and so on."""
    seen: set[type] = set()
    open_ = list(classes)
    while open_:
        cls = open_.pop()
        if cls in seen:
            continue
        seen.add(cls)
        yield cls
        if _is_of(cls, _MAKERS):
            known = vars(sys.modules[cls.__module__]).values()
            open_ += [value for value in known if isinstance(value, type) and _is_of(value, _MADE)]


def _is_of(cls: type, rooms: Sequence[str]) -> bool:
    """Whether a class is the engine's, and of one of its folders."""
    return cls.__module__.startswith(f"{_ENGINE}.") and package_of(cls) in rooms
