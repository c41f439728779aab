"""Readers of the expressions and action parameters of a rule file; each fault has its line and column."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from ..base.errors import Fault, InputError, unknown
from ..base.toml_table import Table
from ..base.units import TIME, Dimension, convert
from ..base.words import listed
from ..declare import Field, read_key
from ..expression import ABSENT, NO_NAME, TRUTH, Environment, Expression, Node, evaluate, parse
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
        self.never = Expression(Node("truth", TRUTH, value=False, text="False"))
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
        return Expression(node)

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
        return Expression(node) if node.temporal else self._numbers.setdefault(node, Expression(node))

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
    for key, each in declared.items():
        if key in keys:
            arguments[key] = _argument(reader, table, fallbacks, each, name)
        elif key in fallbacks:
            arguments[key] = Argument(None if each.required else each.default, read_key(each, fallbacks), blind=True)
    return name, arguments


def _argument(reader: ExpressionReader, table: Table, fallbacks: Table, each: Field, action: str) -> Argument:
    key = each.key
    blind = key in fallbacks
    fallback = read_key(each, fallbacks) if blind else None
    if each.dimension is None:
        if each.many or not each.is_plain:
            table.fault(key, f"'{key}' cannot be given in a rule file.")
        return Argument(read_key(each, table), fallback, blind)
    value = _value(reader, table, each, each.dimension, action)
    if isinstance(value, (Expression, tuple)) and not blind:
        fallback = None if each.required else each.default
        if fallback is None:
            table.fault(
                key,
                f"'{key}' reads signals, so it can be invalid when the rule fires, but it has no default value.",
                hint=f'Add a value for that case: [{fallbacks.label}] {key} = "...".',
            )
    return Argument(value, fallback, blind)


def _value(reader: ExpressionReader, table: Table, each: Field, dimension: Dimension, action: str) -> Any:
    """Value of a parameter: a number, an expression, or a list of numbers and expressions.

    Values that depend on signals are checked when the rule fires.
    """
    written = table.data[each.key]
    if each.many and not isinstance(written, list):
        table.fault(each.key, f"'{each.key}' must be a list of numbers in {dimension}, found {written!r}.")
        return None
    values = [_number(reader, table, each.key, part, dimension) for part in (written if each.many else [written])]
    for constant in (value for value in values if isinstance(value, float)):
        if faults := each.faults([constant] if each.many else constant, f"{each.key} of {action}"):
            table.adopt(each.key, InputError(*faults))
    if not each.many:
        return values[0]
    return tuple(values) if any(isinstance(value, Expression) for value in values) else values


def _number(reader: ExpressionReader, table: Table, key: str, value: Any, dimension: Dimension) -> Any:
    """Read a number in SI units, or an expression that depends on signals; if it is neither, record a fault."""
    if not isinstance(value, str):
        try:
            return convert(value, dimension, what=f"'{key}'")
        except InputError as error:
            table.adopt(key, error)
            return None
    expression = reader.number(table, key, value, dimension)
    if expression is None or not expression.node.constant:
        return expression
    constant = evaluate(expression.node, ())  # interpreted: compiling does not pay for a single evaluation
    if constant is None:
        table.fault(key, f"'{key}' has no value: {value} cannot be computed.")
    return constant


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
