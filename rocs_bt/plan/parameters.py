"""The parameters of a mission: the keyword-only parameters of its `build`."""

from __future__ import annotations

import inspect
import typing
from collections.abc import Callable, Mapping
from typing import Any

from ..action import Parameter
from ..errors import Fault, InputError, unknown
from ..units import NONE, convert


def mission_parameters(build: Callable[..., Any]) -> dict[str, Parameter]:
    """What a scenario may set, by name; see `Mission` for the form of `build`.

    Raises:
        InputError: `build` does not have that form; all that is wrong with it.
    """
    try:
        signature = inspect.signature(build)
        hints = typing.get_type_hints(build, include_extras=True)
    except (TypeError, NameError) as error:
        raise InputError(Fault(f"the parameters of build cannot be read: {error}.")) from error
    found, faults = {}, []
    given = list(signature.parameters.values())
    if not given or given[0].kind not in (given[0].POSITIONAL_ONLY, given[0].POSITIONAL_OR_KEYWORD):
        faults.append(Fault("build takes no mission.", hint="Write: def build(mission: Mission, *, ...)."))
    for parameter in given[1:]:
        if parameter.kind is not parameter.KEYWORD_ONLY:
            hint = "Write a '*' before it: parameters are given by name."
            faults.append(Fault(f"parameter '{parameter.name}' of build is not keyword-only.", hint=hint))
        elif parameter.name not in hints:
            hint = "Write for example 'cruise: MetresPerSecond = 0.5'."
            faults.append(Fault(f"parameter '{parameter.name}' of build has no type.", hint=hint))
        else:
            required = parameter.default is parameter.empty
            default = None if required else parameter.default
            found[parameter.name] = Parameter.annotated(parameter.name, hints[parameter.name], required, default)
    if faults:
        raise InputError(*faults)
    return found


def mission_arguments(build: Callable[..., Any], values: Mapping[str, object]) -> dict[str, Any]:
    """A file's values for a mission's parameters: numbers in SI units, the rest as it is.

    Args:
        build: The mission's.
        values: What the file says, such as `{"cruise": "0.5 m/s", "goal": "dock"}`.

    Raises:
        InputError: A name, a type, a unit or a value is wrong, or a required parameter is missing; all faults at once.
    """
    declared = mission_parameters(build)
    faults = [unknown("parameter", name, declared, "The mission") for name in values if name not in declared]
    missing = [name for name, parameter in declared.items() if parameter.required and name not in values]
    if missing:
        faults.append(Fault(f"the mission needs {', '.join(missing)}.", hint=f"It takes: {', '.join(declared)}."))
    arguments: dict[str, Any] = {}
    for name in (name for name in values if name in declared):
        try:
            arguments[name] = _argument(declared[name], values[name])
        except InputError as error:
            faults.extend(error.faults)
    if faults:
        raise InputError(*faults)
    return arguments


def _argument(parameter: Parameter, value: object) -> Any:
    if parameter.type is float:
        number = convert(value, parameter.dimension or NONE, parameter.name)
        if faults := parameter.faults(number, parameter.name):
            raise InputError(*faults)
        return number
    # bool is an int to Python, and True is no number of rounds.
    fits = isinstance(value, parameter.type) if parameter.type in (str, int, bool) else True
    if not fits or (parameter.type is int and isinstance(value, bool)):
        raise InputError(Fault(f"{parameter.name} must be of type {parameter.type.__name__}, found {value!r}."))
    return value
