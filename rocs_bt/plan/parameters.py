"""Declarations in a mission file: the parameters of `build`, and action classes."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Mapping
from typing import Any, get_type_hints

from ..base.errors import Fault, InputError
from ..declare import MISSING, Field, read_arguments
from ..interfaces.action import Action

_FORM = "Write: def build(mission: Mission, *, ...)."


def mission_parameters(build: Callable[..., Any]) -> dict[str, Field]:
    """Parameters of a mission, which a scenario may set, by name; see `Mission` for the form of `build`.

    Raises:
        InputError: `build` does not have this form; the error lists all deviations.
    """
    if (known := getattr(build, "parameters", None)) is not None:
        return dict(known)
    try:
        given = inspect.signature(build).parameters.values()
        hints = get_type_hints(build, include_extras=True)
    except (TypeError, NameError, AttributeError, SyntaxError) as error:
        raise InputError(Fault(f"the parameters of build cannot be read: {error}.")) from error
    by_position = [p for p in given if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    by_name = [p for p in given if p.kind is p.KEYWORD_ONLY]
    faults = []
    if not by_position and not any(p.kind is p.VAR_POSITIONAL for p in given):
        faults.append(Fault("build takes no mission.", hint=_FORM))
    for parameter in by_position[1:]:
        hint = f"Write a '*' before it: parameters are passed by name. {_FORM}"
        faults.append(Fault(f"parameter '{parameter.name}' of build is not keyword-only.", hint=hint))
    for parameter in (p for p in by_name if p.name not in hints):
        hint = "Write for example 'cruise: MetresPerSecond = 0.5'."
        faults.append(Fault(f"parameter '{parameter.name}' of build has no type.", hint=hint))
    if any(p.kind is p.VAR_KEYWORD for p in given):
        faults.append(Fault("build accepts any keyword, so scenarios cannot be checked.", hint=_FORM))
    if faults:
        raise InputError(*faults)
    defaults = {p.name: MISSING if p.default is p.empty else p.default for p in by_name}
    return {name: Field.annotated(name, hints[name], default, object) for name, default in defaults.items()}


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
