"""Making a block of robot.toml: a Monitor or an Analyze with the parameters that its table gives."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from typing import Any, TypeVar

from ..errors import Fault, InputError
from ..raised import content_line

T = TypeVar("T")

_WORDS = {"float": "a number", "int": "a whole number", "str": "a text"}
_TYPES: Mapping[str, tuple[type, ...]] = {"float": (int, float), "int": (int,), "str": (str,)}


def make_block(cls: type[T], parameters: Mapping[str, Any], *args: Any) -> T:
    """A block, made of `args` (its name first) and its parameters.

    Raises:
        InputError: A parameter does not exist, is missing, or is not of the type that the class declares.
        Exception: What a user's own class raises.
    """
    what = f"{cls.__name__} '{args[0]}'"
    declared = _declared(cls)
    faults = [
        Fault(f"{name} of {what} must be {_WORDS[kind]}, found {value!r}.")
        for name, value in parameters.items()
        if (kind := declared.get(name, "")) in _TYPES and not _fits(value, _TYPES[kind])
    ]
    if faults:
        raise InputError(*faults)
    try:
        inspect.signature(cls).bind(*args, **parameters)
        return cls(*args, **parameters)
    except (TypeError, ValueError, OverflowError) as error:  # what only the class itself can tell
        if content_line(error) is not None:  # a user's own class raised it, at that line
            raise
        raise InputError(f"{what} does not take these parameters: {error}.") from error


def _declared(cls: type) -> dict[str, str]:
    """How the constructors of a class and of its bases annotate what they take, as written; its own word wins."""
    found: dict[str, str] = {}
    for base in reversed(cls.__mro__):
        if inspect.isfunction(make := vars(base).get("__init__")):
            for name, kind in make.__annotations__.items():
                found[name] = kind if isinstance(kind, str) else getattr(kind, "__name__", "")
    return found


def _fits(value: Any, types: tuple[type, ...]) -> bool:
    # What is not equal to itself is NaN, with which no comparison holds.
    return isinstance(value, types) and not isinstance(value, bool) and value == value
