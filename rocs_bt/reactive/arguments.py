"""Expressions and action parameters inside a rule file, with faults at the column where they are written."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from ..action import Action, Parameter, misfits_of, parameters_of
from ..document import Table
from ..errors import Fault, InputError, unknown
from ..expression import TRUTH, Environment, Expression, Node, compile_node, evaluate, parse
from ..knowledge import Knowledge
from ..units import TIME, Dimension, convert
from .rule import Argument, Place, Rule


class Placed:
    """The expressions of one document.

    Args:
        root: The document.
        environment: What names mean; grows with the document's aliases.
        lines: The document's lines; empty where its text is not at hand.
    """

    def __init__(self, root: Table, environment: Environment, lines: list[str]) -> None:
        self.root = root
        self.environment = environment
        self.never = compile_node(Node("truth", TRUTH, value=False, text="False"))
        self._lines = lines
        self._parsed_with = environment
        self._trees: dict[str, Node] = {}
        self._numbers: dict[Node, Expression] = {}

    def guard(self, table: Table, key: str) -> Expression | None:
        """The true-or-false expression at a key; None, and a fault, where it is none."""
        text = table.text(key)
        node = self.node(table, key, text) if key in table and isinstance(table.raw(key), str) else None
        if node is None:
            return None
        if node.kind != TRUTH:
            hint = "Use any or all." if node.kind.boolean else "Compare it, such as min(front) < 0.5 m."
            fault = Fault(f"'{key}' must be true or false, but {text} is {node.kind.words}.", hint=hint)
            self._note(table, key, text, fault)
            return None
        return compile_node(node)

    def number(self, table: Table, key: str, text: str, dimension: Dimension) -> Expression | None:
        """The expression of one number of a dimension; None, and a fault, where it is none."""
        node = self.node(table, key, text)
        if node is None:
            return None
        if node.kind.boolean or node.kind.size or node.kind.dimension != dimension:
            fault = Fault(f"'{key}' must be one number in {dimension}, but {text} is {node.kind.words}.")
            self._note(table, key, text, fault)
            return None
        return compile_node(node) if node.temporal else self._numbers.setdefault(node, compile_node(node))

    def node(self, table: Table, key: str, text: str) -> Node | None:
        """The typed tree of a text at a key; None, and faults, where it has none."""
        try:
            return self._parsed(text)
        except InputError as error:
            for fault in error.faults:
                self._note(table, key, text, fault)
            return None

    def place(self, table: Table, key: str, text: str = "") -> Place:
        """Where a key stands, or the first character of the expression that is its value."""
        line, column = table.position(key)
        if text and 0 < line <= len(self._lines):
            written = self._lines[line - 1]
            # An escape or a text of many lines is not found as it stands; then the key must do as the place.
            found = [at for quote in "\"'" if (at := written.find(f"{quote}{text}{quote}", column)) >= 0]
            if found:
                return Place(table.file, line, min(found) + 2)
        return Place(table.file, line, column)

    def duration(self, table: Table, key: str) -> float:
        """A length of time [s]: a quantity, or a threshold's name; 0 where there is none."""
        named = self.environment.aliases.get(table.raw(key)) if key in table and type(table.raw(key)) is str else None
        if named is None or named.op != "number":
            return table.quantity(key, TIME, 0.0, low=0.0)
        if named.kind.dimension != TIME or not 0.0 <= float(named.value) < math.inf:
            found = f"{named.value:g} {named.kind.dimension}"
            table.fault(key, f"{key} must be a time of 0 s or more, but the threshold '{named.text}' is {found}.")
            return 0.0
        return float(named.value)

    def _parsed(self, text: str) -> Node:
        """The typed tree of a text; rules of a file often share an expression."""
        if self._parsed_with is not self.environment:
            self._parsed_with, self._trees = self.environment, {}
        if text not in self._trees:
            self._trees[text] = parse(text, self.environment)
        return self._trees[text]

    def _note(self, table: Table, key: str, text: str, fault: Fault) -> None:
        place = self.place(table, key, text)
        column = place.column
        if place != self.place(table, key):
            column += max(1, fault.column) - 1
        table.faults.append(replace(fault, file=table.file, line=place.line, column=column))


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


def rule_misfits(rules: Iterable[Rule], actions: Mapping[str, type[Action]], knowledge: Knowledge) -> Iterator[Fault]:
    """Faults of constant parameters of rules' actions that a robot cannot carry out.

    Args:
        rules: Rules without other faults.
        actions: The agent's actions by name.
        knowledge: Knowledge of the robot.
    """
    for rule in rules:
        known = {n: _known(a) for n, a in rule.arguments.items() if not isinstance(a.value, Expression)}
        for name, reason in misfits_of(actions[rule.action], known, knowledge):
            places = (rule.places.get(key) for key in (f"action.{name}", "action", ""))
            place = next(p for p in places if p is not None)
            yield Fault(f"{name} of {rule.action}: {reason}.", place.file, place.line, place.column)


def _known(argument: Argument) -> Any:
    """An argument's value, with NaN for what of a list depends on signals."""
    value = argument.value
    if isinstance(value, tuple):
        return [math.nan if isinstance(part, Expression) else part for part in value]
    return value
