"""Code provenance: the classes of the engine that a built agent consists of."""

from __future__ import annotations

import enum
import gc
import sys
import types
from collections.abc import Iterable, Iterator, Mapping, Sequence

from rocs_bt.agent import Agent
from rocs_bt.interfaces.action import Action
from rocs_bt.plan import Act
from rocs_bt.reactive import RuleModel

_ENGINE = "rocs_bt"
_MAKERS = ("actions", "analyze", "control", "monitor")  # subpackages with objects that construct others during a run
_MADE = ("actions", "control")


def used_classes(agent: Agent, foreign: Sequence[object], actions: Mapping[str, type[Action]]) -> tuple[type, ...]:
    """Engine classes that an agent consists of, including devices, sorted by name.

    A class counts if one of its objects is reachable from the agent, or if a leaf of the mission or a rule names it as
    an action. Classes of `actions` and `control` that the modules of these classes import, also by a function of these
    packages, count too, because objects of them are constructed during a run, such as parts of decomposed actions,
    paths and filters. Base classes count. Value types (frozen dataclasses, tuples, enums) and private classes do not.

    Args:
        agent: A built agent; it need not have run.
        foreign: Objects that the agent shares with others, which are not followed: the world, its clock, the sink.
        actions: Actions of the agent, by name.
    """
    objects = list(_reachable(agent, foreign))
    found = set(_with_imported({type(each) for each in objects} | set(_named_actions(objects, actions))))
    bases = {base for cls in found for base in cls.__mro__}
    return tuple(sorted(filter(is_counted, bases), key=lambda cls: (cls.__module__, cls.__qualname__)))


def package_of(cls: type | types.FunctionType) -> str:
    """Subpackage of an engine class, such as `monitor`; the module's name for a class at the root of the engine."""
    return cls.__module__.split(".")[1]


def is_counted(cls: type) -> bool:
    """Whether a class belongs to the engine, is public and is no value type."""
    if cls.__module__.partition(".")[0] != _ENGINE or cls.__name__.startswith("_"):
        return False
    parameters = getattr(cls, "__dataclass_params__", None)
    return not ((parameters and parameters.frozen) or issubclass(cls, (tuple, enum.Enum)))


def _reachable(root: object, foreign: Sequence[object]) -> Iterator[object]:
    """Every object that is reachable from `root`; through functions only their closures and defaults are followed."""
    seen, open_ = set(map(id, foreign)), [root]
    while open_:
        each = open_.pop()
        if id(each) in seen or isinstance(each, (type, types.ModuleType, types.CodeType)):
            continue
        seen.add(id(each))
        yield each
        if isinstance(each, types.FunctionType):
            open_ += [*(each.__closure__ or ()), *(each.__defaults__ or ())]
        else:
            open_ += gc.get_referents(each)


def _named_actions(objects: Iterable[object], actions: Mapping[str, type[Action]]) -> Iterator[type[Action]]:
    """Classes of the actions that leaves and rules among these objects name."""
    for each in objects:
        if isinstance(each, Act):
            yield type(each.make())
        elif isinstance(each, RuleModel):
            yield from (actions[rule.action] for rule in each.rules.rules)


def _with_imported(classes: Iterable[type]) -> Iterator[type]:
    """Yield classes, and recursively the classes of the subpackages `_MADE` that their modules import."""
    seen: set[type] = set()
    open_ = list(classes)
    while open_:
        cls = open_.pop()
        if cls in seen:
            continue
        seen.add(cls)
        yield cls
        if _is_of(cls, _MAKERS):
            open_ += _imported(cls.__module__)


def _imported(module: str) -> Iterator[type]:
    """Classes of the subpackages `_MADE` in a module, and in the modules of functions that it imports from them."""
    known = list(vars(sys.modules[module]).values())
    makers = {each.__module__ for each in known if isinstance(each, types.FunctionType) and _is_of(each, _MADE)}
    for other in makers - {module}:
        known += vars(sys.modules[other]).values()
    return (each for each in known if isinstance(each, type) and _is_of(each, _MADE))


def _is_of(cls: type | types.FunctionType, packages: Sequence[str]) -> bool:
    """Whether a class belongs to one of these subpackages of the engine."""
    return cls.__module__.startswith(f"{_ENGINE}.") and package_of(cls) in packages
