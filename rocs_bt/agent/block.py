"""Construction of monitors and analysers from their tables in robot.toml."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from ..base.errors import InputError
from ..base.raised import content_line
from ..catalog import AnalyzeSpec, MonitorSpec
from ..declare import Declared, fields_of, read_arguments

T = TypeVar("T", bound=Declared)


def make_block(cls: type[T], spec: MonitorSpec | AnalyzeSpec, *passed: Any) -> T:
    """Construct a monitor or an analyser; `passed` are further positional arguments of its constructor.

    Raises:
        InputError: A parameter is unknown, missing, or not of the type and unit that the class annotates; the error
            lists all faults.
        Exception: The constructor of a user's class raised this exception.
    """
    what = f"{cls.__name__} '{spec.name}'"
    given = read_arguments({each.key: each for each in fields_of(cls)}, spec.parameters, what)
    make: Callable[..., T] = cls
    try:
        return make(spec.name, *passed, **given)
    except (TypeError, ValueError, OverflowError) as error:  # refused by the constructor itself
        if content_line(error) is not None:  # raised in a user's class
            raise
        raise InputError(f"{what} does not take these parameters: {error}.") from error
