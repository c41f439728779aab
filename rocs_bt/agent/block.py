"""Construction of monitors and analysers from their tables in robot.toml."""

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
    """Construct a monitor or an analyser.

    Args:
        cls: Class of the block.
        parameters: Keyword arguments from robot.toml.
        args: Positional arguments, the block's name first.

    Raises:
        InputError: A parameter is unknown, missing, or not of the type that the class annotates.
        Exception: The constructor of a user's class raised this exception.
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
    except (TypeError, ValueError, OverflowError) as error:  # refused by the constructor itself
        if content_line(error) is not None:  # raised in a user's class
            raise
        raise InputError(f"{what} does not take these parameters: {error}.") from error


def _declared(cls: type) -> dict[str, str]:
    """Annotations of the constructor parameters of a class and its bases, as text, by parameter."""
    found: dict[str, str] = {}
    for base in reversed(cls.__mro__):
        if inspect.isfunction(make := vars(base).get("__init__")):
            for name, kind in make.__annotations__.items():
                found[name] = kind if isinstance(kind, str) else getattr(kind, "__name__", "")
    return found


def _fits(value: Any, types: tuple[type, ...]) -> bool:
    # NaN is not equal to itself.
    return isinstance(value, types) and not isinstance(value, bool) and value == value
