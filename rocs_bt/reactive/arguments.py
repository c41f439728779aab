"""Readers of the expressions and action parameters of a rule file; each fault has its line and column."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from ..base.errors import Fault, InputError, unknown
from ..base.parameter import Parameter
from ..base.toml_table import Table
from ..base.units import TIME, Dimension, convert
from ..base.words import listed
from ..expression import ABSENT, NO_NAME, TRUTH, Environment, Expression, Node, compile_node, evaluate, parse
from ..interfaces.action import Action, misfits_of, parameters_of
from ..knowledge import Knowledge
from .rule import Argument, Position, Rule


class ExpressionReader:
    """Parser of the expressions of one rule file.

    `absent` contains signals that the robot lacks, by name that has therefore no meaning: optional signals, other
    signals that rules require, and aliases that read them.
    """

    def __init__(
        self, root: Table, environment: Environment, lines: list[str], absent: dict[str, tuple[str, ...]]
    ) -> None:
        self.root = root
        self.environment = environment
        self.absent = absent
        self.never = compile_node(Node("truth", TRUTH, value=False, text="False"))
        self._lines = lines
        self._parsed_with = environment
        self._trees: dict[str, Node] = {}
        self._numbers: dict[Node, Expression] = {}

    def guard(self, table: Table, key: str) -> Expression | None:
        """Read the boolean expression at a key; if it is not one, record a fault and return None."""
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
        """Parse an expression that must have one number as its value; if it does not, record a fault and return None.

        Args:
            table: Table that contains the key, for the fault's position.
            key: Key of the expression.
            text: Expression.
            dimension: Required dimension.
        """
        node = self.node(table, key, text)
        if node is None:
            return None
        if node.kind.boolean or node.kind.size or node.kind.dimension != dimension:
            fault = Fault(f"'{key}' must be one number in {dimension}, but {text} is {node.kind.words}.")
            self._note(table, key, text, fault)
            return None
        return compile_node(node) if node.temporal else self._numbers.setdefault(node, compile_node(node))

    def node(self, table: Table, key: str, text: str) -> Node | None:
        """Parse the expression at a key to its typed tree; if it is invalid, record its faults and return None."""
        try:
            return self._parsed(text)
        except InputError as error:
            for fault in error.faults:
                self._note(table, key, text, self._explained(fault))
            return None

    def missing(self, text: str) -> tuple[str, ...]:
        """Optional signals that an expression needs and the robot lacks."""
        unknown_words = words(text).difference(self.environment.names)
        return tuple(sorted({name for word in unknown_words for name in self.absent.get(word, ())}))

    def position(self, table: Table, key: str, text: str = "") -> Position:
        """Position of a key, or of the first character of its value if this expression is given as `text`."""
        line, column = table.position(key)
        if text and 0 < line <= len(self._lines):
            written = self._lines[line - 1]
            # A text with escapes or several lines is not found literally; then the position of the key is used.
            found = [at for quote in "\"'" if (at := written.find(f"{quote}{text}{quote}", column)) >= 0]
            if found:
                return Position(table.file, line, min(found) + 2)
        return Position(table.file, line, column)

    def duration(self, table: Table, key: str) -> float:
        """Duration at a key [s], written as a quantity or as the name of a threshold; 0 if the key is missing."""
        named = self.environment.aliases.get(table.raw(key)) if key in table and type(table.raw(key)) is str else None
        if named is None or named.op != "number":
            return table.quantity(key, TIME, 0.0, low=0.0)
        if named.kind.dimension != TIME or not 0.0 <= float(named.value) < math.inf:
            found = f"{named.value:g} {named.kind.dimension}"
            table.fault(key, f"{key} must be a time of 0 s or more, but the threshold '{named.text}' is {found}.")
            return 0.0
        return float(named.value)

    def _parsed(self, text: str) -> Node:
        """Typed tree of an expression, cached because rules of a file often share expressions."""
        if self._parsed_with is not self.environment:
            self._parsed_with, self._trees = self.environment, {}
        if text not in self._trees:
            self._trees[text] = parse(text, self.environment)
        return self._trees[text]

    def _explained(self, fault: Fault) -> Fault:
        """Fault about a name that is known on other robots, with a hint about `require`; other faults are unchanged."""
        found = NO_NAME.fullmatch(fault.message)
        if found is None or found[1] not in self.absent:
            return fault
        missing = self.absent[found[1]]
        message = f"{ABSENT} {listed(missing)}"
        reads = "" if missing == (found[1],) else f", which the alias '{found[1]}' reads"
        written = ", ".join(f'"{name}"' for name in missing)
        lack = "it" if len(missing) == 1 else "them"
        hint = f"With require = [{written}], a rule is inactive on robots that lack {lack}."
        return replace(fault, message=f"{message}{reads}.", hint=hint)

    def _note(self, table: Table, key: str, text: str, fault: Fault) -> None:
        position = self.position(table, key, text)
        column = position.column
        if position != self.position(table, key):
            column += max(1, fault.column) - 1
        table.faults.append(replace(fault, file=table.file, line=position.line, column=column))


def words(text: str) -> set[str]:
    """Names in an expression."""
    return set(_WORD.findall(text))


_WORD = re.compile(r"[A-Za-z_]\w*")
_PLAIN = {str: "a text", bool: "true or false", int: "a whole number"}


def read_action(table: Table, actions: Mapping[str, type[Action]]) -> tuple[str, list[str], Table]:
    """Read a rule's action, its parameters' names and the table of fallbacks; faults go to `table`."""
    name, fallbacks = table.text("name"), table.table("on_invalid")
    keys = [key for key in table.keys() if key not in ("name", "on_invalid")]  # noqa: SIM118 - a Table is no mapping
    for owner, used in ((table, keys), (fallbacks, fallbacks.keys())):
        for key in used:
            owner.raw(key)  # marks the key as read: its faults are reported here, not by Table
    if name not in actions:
        if name:
            table.adopt("name", InputError(unknown("action", name, actions)))
        return name, [], fallbacks
    declared = parameters_of(actions[name])
    for owner, used in ((table, keys), (fallbacks, fallbacks.keys())):
        for key in declared:
            owner.raw(key, None)  # the reader takes it, also if it is not written
        for key in used:
            if key not in declared:
                owner.adopt(key, InputError(unknown(f"parameter of {name}", key, declared, name)))
    if missing := [p.name for p in declared.values() if p.required and p.name not in keys]:
        table.fault("name", f"{name} needs {', '.join(missing)}.", hint=f"It takes: {', '.join(declared)}.")
    return name, keys, fallbacks


def read_arguments(
    reader: ExpressionReader, table: Table, actions: Mapping[str, type[Action]]
) -> tuple[str, dict[str, Argument]]:
    """Read the name and the arguments of a rule's action; faults are recorded in `table`."""
    name, keys, fallbacks = read_action(table, actions)
    arguments = dict[str, Argument]()
    declared = parameters_of(actions[name]) if name in actions else {}
    for key, parameter in declared.items():
        if key in keys:
            arguments[key] = _argument(reader, table, fallbacks, parameter, name)
        elif key in fallbacks:
            arguments[key] = Argument(parameter.default, _constant(fallbacks, parameter, name), blind=True)
    return name, arguments


def _argument(reader: ExpressionReader, table: Table, fallbacks: Table, parameter: Parameter, action: str) -> Argument:
    key = parameter.name
    blind = key in fallbacks
    fallback = _constant(fallbacks, parameter, action) if blind else None
    if parameter.dimension is None:
        return Argument(_plain(table, parameter), fallback, blind)
    value = _value(reader, table, parameter, parameter.dimension)
    _hold(table, parameter, value, action)
    if isinstance(value, (Expression, tuple)) and not blind:
        fallback = parameter.default
        if fallback is None:
            table.fault(
                key,
                f"'{key}' reads signals, so it can be invalid when the rule fires, but it has no default value.",
                hint=f'Add a value for that case: [{fallbacks.label}] {key} = "...".',
            )
    return Argument(value, fallback, blind)


def _value(reader: ExpressionReader, table: Table, parameter: Parameter, dimension: Dimension) -> Any:
    """Value of a parameter: a number, an expression, or a list of numbers and expressions."""
    value = table.raw(parameter.name)
    if parameter.type is float:
        return _number(reader, table, parameter.name, value, dimension)
    if not isinstance(value, list):
        table.fault(parameter.name, f"'{parameter.name}' must be a list of numbers in {dimension}, found {value!r}.")
        return None
    parts = [_number(reader, table, parameter.name, part, dimension) for part in value]
    if any(isinstance(part, Expression) for part in parts):
        return tuple(parts)
    return parts


def _hold(table: Table, parameter: Parameter, value: Any, action: str) -> None:
    """Record faults of constants out of bounds. Values that depend on signals are checked when the rule fires."""
    parts = value if isinstance(value, (list, tuple)) else [value]
    for part in parts:
        if part is None or isinstance(part, Expression):
            continue
        if faults := parameter.bound_faults(part, f"{parameter.name} of {action}"):
            table.adopt(parameter.name, InputError(*faults))


def _number(reader: ExpressionReader, table: Table, key: str, value: Any, dimension: Dimension) -> Any:
    """Read a number in SI units, or an expression that depends on signals; if it is neither, record a fault."""
    if not isinstance(value, str):
        return _converted(table, key, value, dimension)
    expression = reader.number(table, key, value, dimension)
    if expression is None or not expression.node.constant:
        return expression
    constant = evaluate(expression.node, ())  # interpreted: compiling does not pay for a single evaluation
    if constant is None:
        table.fault(key, f"'{key}' has no value: {value} cannot be computed.")
    return constant


def _constant(table: Table, parameter: Parameter, action: str) -> Any:
    """Fallback value: a constant, which cannot become invalid."""
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
    """Faults of constant action parameters that do not fit the robot, such as a speed above its maximum.

    Args:
        rules: Rules without other faults.
        actions: Actions of the agent, keyed by name.
        knowledge: Knowledge of the robot.
    """
    for rule in rules:
        known = {n: _known(a) for n, a in rule.arguments.items() if not isinstance(a.value, Expression)}
        for name, reason in misfits_of(actions[rule.action], known, knowledge):
            positions = (rule.positions.get(key) for key in (f"action.{name}", "action", ""))
            position = next(p for p in positions if p is not None)
            yield Fault(f"{name} of {rule.action}: {reason}.", position.file, position.line, position.column)


def _known(argument: Argument) -> Any:
    """Value of an argument; NaN replaces list items that depend on signals."""
    value = argument.value
    if isinstance(value, tuple):
        return [math.nan if isinstance(part, Expression) else part for part in value]
    return value
