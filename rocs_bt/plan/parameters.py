"""What a mission file declares beside its tree: parameters of `build`, and own actions."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Mapping
from typing import Any

from ..action import Action, Parameter
from ..arguments import keyword_parameters, read_arguments
from ..errors import Fault, InputError

_FORM = "Write: def build(mission: Mission, *, ...)."


def mission_parameters(build: Callable[..., Any]) -> dict[str, Parameter]:
    """What a scenario may set, by name; see `Mission` for the form of `build`.

    Raises:
        InputError: `build` does not have that form; all that is wrong with it.
    """
    found, more = keyword_parameters(build, ("mission",), "build", _FORM)
    if more:
        raise InputError(Fault("build takes any keyword, so no scenario could be checked.", hint=_FORM))
    return found


def mission_arguments(build: Callable[..., Any], values: Mapping[str, object]) -> dict[str, Any]:
    """A file's values for a mission's parameters: numbers in SI units, the rest as it is.

    Args:
        build: The mission's.
        values: What the file says, such as `{"cruise": "0.5 m/s", "goal": "dock"}`.

    Raises:
        InputError: A name, a type, a unit or a value is wrong, or a required parameter is missing; all faults at once.
    """
    return read_arguments(mission_parameters(build), values, "the mission")


def mission_actions(build: Callable[..., Any]) -> list[type[Action]]:
    """The action classes that stand in the mission's own file: writing one there is all it takes to use it."""
    module = sys.modules.get(getattr(inspect.unwrap(build), "__module__", ""))
    found = [v for v in vars(module).values() if isinstance(v, type) and issubclass(v, Action)] if module else []
    return [a for a in found if module is not None and a.__module__ == module.__name__ and not inspect.isabstract(a)]
