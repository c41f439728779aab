"""The action of a rule: its name and its parameters, checked against what the action class declares."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..action import Action, Parameter, parameters_of
from ..document import Table
from ..errors import InputError, unknown
from ..expression import Expression, evaluate
from ..units import Dimension, convert
from .placed import Placed
from .rule import Argument

_PLAIN = {str: "a text", bool: "true or false", int: "a whole number"}


def read_arguments(
    placed: Placed, table: Table, actions: Mapping[str, type[Action]]
) -> tuple[str, dict[str, Argument]]:
    """The action's name and its arguments; faults are noted in the table.

    Args:
        placed: The document.
        table: The rule's `action` table.
        actions: The agent's actions by name.
    """
    name = table.text("name")
    fallbacks = table.table("on_invalid")
    written = table.keys()
    keys = [key for key in written if key not in ("name", "on_invalid")]
    for owner, used in ((table, keys), (fallbacks, fallbacks.keys())):
        for key in used:
            owner.raw(key)  # asked for: what is wrong with it is said here, not by Table
    if name not in actions:
        if name:
            table.adopt("name", InputError(unknown("action", name, actions)))
        return name, {}
    declared = parameters_of(actions[name])
    for owner, used in ((table, keys), (fallbacks, fallbacks.keys())):
        for key in used:
            if key not in declared:
                owner.adopt(key, InputError(unknown(f"parameter of {name}", key, declared, name)))
    if missing := [p.name for p in declared.values() if p.required and p.name not in keys]:
        table.fault("name", f"{name} needs {', '.join(missing)}.", hint=f"It takes: {', '.join(declared)}.")
    arguments = {}
    for key, parameter in declared.items():
        if key in keys:
            arguments[key] = _argument(placed, table, fallbacks, parameter, name)
        elif key in fallbacks:
            arguments[key] = Argument(parameter.default, _constant(fallbacks, parameter, name), blind=True)
    return name, arguments


def _argument(placed: Placed, table: Table, fallbacks: Table, parameter: Parameter, action: str) -> Argument:
    key = parameter.name
    blind = key in fallbacks
    fallback = _constant(fallbacks, parameter, action) if blind else None
    if parameter.dimension is None:
        return Argument(_plain(table, parameter), fallback, blind)
    value = _value(placed, table, parameter, parameter.dimension)
    _hold(table, parameter, value, action)
    if isinstance(value, (Expression, tuple)) and not blind:
        fallback = parameter.default
        if fallback is None:
            table.fault(
                key,
                f"'{key}' reads signals, so it can be invalid when the rule fires, and has no default.",
                hint=f'Add a value for that case: [{fallbacks.label}] {key} = "...".',
            )
    return Argument(value, fallback, blind)


def _value(placed: Placed, table: Table, parameter: Parameter, dimension: Dimension) -> Any:
    """The parameter's number, its expression, or a list of either."""
    value = table.raw(parameter.name)
    if parameter.type is float:
        return _number(placed, table, parameter.name, value, dimension)
    if not isinstance(value, list):
        table.fault(parameter.name, f"'{parameter.name}' must be a list of numbers in {dimension}, found {value!r}.")
        return None
    parts = [_number(placed, table, parameter.name, part, dimension) for part in value]
    if any(isinstance(part, Expression) for part in parts):
        return tuple(parts)
    return parts


def _hold(table: Table, parameter: Parameter, value: Any, action: str) -> None:
    """Note what is out of bounds whatever is sensed; what is not known before is held when the action is made."""
    parts = value if isinstance(value, (list, tuple)) else [value]
    for part in parts:
        if part is None or isinstance(part, Expression):
            continue
        if faults := parameter.bound_faults(part, f"{parameter.name} of {action}"):
            table.adopt(parameter.name, InputError(*faults))


def _number(placed: Placed, table: Table, key: str, value: Any, dimension: Dimension) -> Any:
    """A number in SI units, or the expression of one that depends on the snapshot; None, and a fault, for neither."""
    if not isinstance(value, str):
        return _converted(table, key, value, dimension)
    expression = placed.number(table, key, value, dimension)
    if expression is None or not expression.node.constant:
        return expression
    constant = evaluate(expression.node, ())  # no function is compiled for a single use
    if constant is None:
        table.fault(key, f"'{key}' has no value: {value} cannot be computed.")
    return constant


def _constant(table: Table, parameter: Parameter, action: str) -> Any:
    """A fallback: a plain value, which nothing can make invalid."""
    value: Any = table.raw(parameter.name)
    if parameter.dimension is None:
        return _plain(table, parameter)
    if isinstance(value, list) and parameter.type is not float:
        value = [_converted(table, parameter.name, part, parameter.dimension) for part in value]
    else:
        value = _converted(table, parameter.name, value, parameter.dimension)
    _hold(table, parameter, value, action)
    return value


def _converted(table: Table, key: str, value: Any, dimension: Dimension) -> float | None:
    try:
        return convert(value, dimension, what=f"'{key}'")
    except InputError as error:
        table.adopt(key, error)
        return None


def _plain(table: Table, parameter: Parameter) -> Any:
    value = table.raw(parameter.name)
    if parameter.type not in _PLAIN:
        table.fault(parameter.name, f"'{parameter.name}' cannot be given in a rule file.")
    elif type(value) is not parameter.type:
        table.fault(parameter.name, f"'{parameter.name}' must be {_PLAIN[parameter.type]}, found {value!r}.")
    return value
