"""Declarations in a mission file: the parameters of `build`, and action classes."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Mapping
from typing import Any

from ..base.errors import Fault, InputError
from ..declare import Field, keyword_fields, read_arguments
from ..interfaces.action import Action

_FORM = "Write: def build(mission: Mission, *, ...)."


def mission_parameters(build: Callable[..., Any]) -> dict[str, Field]:
    """Parameters of a mission, which a scenario may set, by name; see `Mission` for the form of `build`.

    Raises:
        InputError: `build` does not have this form; the error lists all deviations.
    """
    found, more = keyword_fields(build, ("mission",), "build", _FORM)
    if more:
        raise InputError(Fault("build accepts any keyword, so scenarios cannot be checked.", hint=_FORM))
    return found


def mission_arguments(build: Callable[..., Any], values: Mapping[str, object]) -> dict[str, Any]:
    """Convert values from a file to the arguments of a mission: numbers in SI units, other values unchanged.

    Args:
        build: `build` function of the mission.
        values: Values from the file, such as `{"cruise": "0.5 m/s", "goal": "dock"}`; an `Open` has their places.

    Raises:
        InputError: A name, type, unit or value is wrong, or a required parameter is missing; the error lists all
            faults.
    """
    return read_arguments(mission_parameters(build), values, "the mission")


def mission_actions(build: Callable[..., Any]) -> list[type[Action]]:
    """Action classes that the file of a mission defines; they need no registration."""
    module = sys.modules.get(getattr(inspect.unwrap(build), "__module__", ""))
    found = [v for v in vars(module).values() if isinstance(v, type) and issubclass(v, Action)] if module else []
    return [a for a in found if module is not None and a.__module__ == module.__name__ and not inspect.isabstract(a)]
