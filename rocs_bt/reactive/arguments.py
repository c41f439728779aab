"""Readers of the expressions and action parameters of a rule file; each fault has its line and column."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from ..base.errors import Fault, InputError, unknown
from ..base.toml_table import Table
from ..base.units import NOT_NEGATIVE, TIME, Dimension, convert
from ..base.words import listed
from ..declare import Declared, Field, Location, Open, known_key, location_of, read_key
from ..expression import ABSENT, NO_NAME, TRUTH, Environment, Expression, Node, evaluate, parse
from ..interfaces.action import Action, misfits_of, parameters_of
from ..knowledge import Knowledge
from .include import RuleDocument
from .rule import Argument, Rule
from .rule_keys import ActionKeys

Source = Declared | Open
"""Table with a key."""


class ExpressionReader:
    """Parser of the expressions of one rule file; notes their faults.

    `absent` contains signals that the robot lacks, by name that has therefore no meaning: optional signals, other
    signals that rules require, and aliases that read them.
    """

    def __init__(
        self, document: RuleDocument, environment: Environment, absent: dict[str, tuple[str, ...]] | None = None
    ) -> None:
        self.faults = document.table.faults
        self.environment = environment
        self.absent = {} if absent is None else absent
        self.never = Expression(Node("truth", TRUTH, value=False, text="False"))
        self._lines = document.lines
        self._parsed_with = environment
        self._trees: dict[str, Node] = {}
        self._numbers: dict[Node, Expression] = {}

    def guard(self, of: Declared, key: str, text: str | None) -> Expression | None:
        """Parse a boolean expression; if it is not one, record a fault and return None."""
        node = self.node(of, key, text) if text else None
        if node is None or text is None:
            return None
        if node.kind != TRUTH:
            hint = "Use any or all." if node.kind.boolean else "Compare it, such as min(front) < 0.5 m."
            fault = Fault(f"'{key}' must be true or false, but {text} is {node.kind.words}.", hint=hint)
            self._note(of, key, text, fault)
            return None
        return Expression(node)

    def number(self, of: Source, key: str, text: str, dimension: Dimension) -> Expression | None:
        """Parse an expression that must have one number as its value; if it does not, record a fault and return None.

        Args:
            of: Table that contains the key, for the fault's position.
            key: Key of the expression.
            text: Expression.
            dimension: Required dimension.
        """
        node = self.node(of, key, text)
        if node is None:
            return None
        if node.kind.boolean or node.kind.size or node.kind.dimension != dimension:
            fault = Fault(f"'{key}' must be one number in {dimension}, but {text} is {node.kind.words}.")
            self._note(of, key, text, fault)
            return None
        return Expression(node) if node.temporal else self._numbers.setdefault(node, Expression(node))

    def node(self, of: Source, key: str, text: str) -> Node | None:
        """Parse the expression at a key to its typed tree; if it is invalid, record its faults and return None."""
        try:
            return self._parsed(text)
        except InputError as error:
            for fault in error.faults:
                self._note(of, key, text, self._explained(fault))
            return None

    def fault(self, of: Source, key: str, *faults: Fault | str) -> None:
        """Record faults at a key of a table."""
        self.faults.extend(InputError(*faults).at(*location_of(of, key)).faults)

    def missing(self, text: str) -> tuple[str, ...]:
        """Optional signals that an expression needs and the robot lacks."""
        unknown_words = words(text).difference(self.environment.names)
        return tuple(sorted({name for word in unknown_words for name in self.absent.get(word, ())}))

    def position(self, of: Source, key: str, text: str = "") -> Location:
        """Position of a key, or of the first character of its value if this expression is given as `text`."""
        file, line, column = location_of(of, key)
        if text and 0 < line <= len(self._lines):
            written = self._lines[line - 1]
            # A text with escapes or several lines is not found literally; then the position of the key is used.
            found = [at for quote in "\"'" if (at := written.find(f"{quote}{text}{quote}", column)) >= 0]
            if found:
                return Location(file, line, min(found) + 2)
        return Location(file, line, column)

    def duration(self, of: Declared, key: str, value: Any) -> float:
        """Duration at a key [s], written as a quantity or as the name of a threshold; 0 if it is invalid."""
        named = self.environment.aliases.get(value) if isinstance(value, str) else None
        try:
            if named is None or named.op != "number":
                seconds = convert(value, TIME, what=key)
                if not NOT_NEGATIVE.admit(seconds):
                    raise InputError(f"{key} must be {NOT_NEGATIVE.broken(seconds, TIME)}, found {value!r}.")
                return seconds
            if named.kind.dimension == TIME and 0.0 <= float(named.value) < math.inf:
                return float(named.value)
            found = f"the threshold '{named.text}' is {named.value:g} {named.kind.dimension}"
            raise InputError(f"{key} must be a time of 0 s or more, but {found}.")
        except InputError as error:
            self.fault(of, key, *error.faults)
            return 0.0

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

    def _note(self, of: Source, key: str, text: str, fault: Fault) -> None:
        file, line, column = self.position(of, key, text)
        if (file, line, column) != location_of(of, key):
            column += max(1, fault.column) - 1
        self.faults.append(replace(fault, file=file, line=line, column=column))


def words(text: str) -> set[str]:
    """Names in an expression."""
    return set(_WORD.findall(text))


_WORD = re.compile(r"[A-Za-z_]\w*")


def parameters_in(
    reader: ExpressionReader, keys: ActionKeys, actions: Mapping[str, type[Action]]
) -> Mapping[str, Field]:
    """Parameters that a rule's action takes; faults of the names of the action and of its parameters are recorded."""
    if (name := keys.name) not in actions:
        if name:
            reader.fault(keys, "name", unknown("action", name, actions))
        return {}
    declared = parameters_of(actions[name])
    for owner in (keys.parameters, keys.on_invalid):
        for key in owner:
            if key not in declared:
                reader.fault(owner, key, unknown(f"parameter of {name}", key, declared, name))
    if missing := [p.name for p in declared.values() if p.required and p.name not in keys.parameters]:
        takes = f"It takes: {', '.join(declared)}."
        reader.fault(keys, "name", Fault(f"{name} needs {', '.join(missing)}.", hint=takes))
    return declared


def read_arguments(
    reader: ExpressionReader, keys: ActionKeys, actions: Mapping[str, type[Action]]
) -> dict[str, Argument]:
    """Arguments of a rule's action; faults are recorded."""
    own, fallbacks = keys.parameters.opened(), keys.on_invalid.opened()
    arguments = dict[str, Argument]()
    for key, each in parameters_in(reader, keys, actions).items():
        for table in (own, fallbacks):
            table.faults = reader.faults
            table.known[key] = known_key(each)
        if key in own:
            arguments[key] = _argument(reader, own, fallbacks, each, keys)
        elif key in fallbacks:
            arguments[key] = Argument(None if each.required else each.default, read_key(each, fallbacks), blind=True)
    return arguments


def _argument(reader: ExpressionReader, own: Table, fallbacks: Table, each: Field, keys: ActionKeys) -> Argument:
    key = each.key
    blind = key in fallbacks
    fallback = read_key(each, fallbacks) if blind else None
    if each.dimension is None:
        if each.many or not each.is_plain:
            own.fault(key, f"'{key}' cannot be given in a rule file.")
        return Argument(read_key(each, own), fallback, blind)
    value = _value(reader, keys, each, each.dimension)
    if isinstance(value, (Expression, tuple)) and not blind:
        fallback = None if each.required else each.default
        if fallback is None:
            own.fault(
                key,
                f"'{key}' reads signals, so it can be invalid when the rule fires, but it has no default value.",
                hint=f'Add a value for that case: [{own.label}.on_invalid] {key} = "...".',
            )
    return Argument(value, fallback, blind)


def _value(reader: ExpressionReader, keys: ActionKeys, each: Field, dimension: Dimension) -> Any:
    """Value of a parameter: a number, an expression, or a list of numbers and expressions.

    Values that depend on signals are checked when the rule fires.
    """
    key, written = each.key, keys.parameters[each.key]
    if each.many and not isinstance(written, list):
        reader.fault(keys, key, f"'{key}' must be a list of numbers in {dimension}, found {written!r}.")
        return None
    values = [_number(reader, keys, key, part, dimension) for part in (written if each.many else [written])]
    for constant in (value for value in values if isinstance(value, float)):
        if faults := each.faults([constant] if each.many else constant, f"{key} of {keys.name}"):
            reader.fault(keys, key, *faults)
    if not each.many:
        return values[0]
    return tuple(values) if any(isinstance(value, Expression) for value in values) else values


def _number(reader: ExpressionReader, keys: ActionKeys, key: str, value: Any, dimension: Dimension) -> Any:
    """Read a number in SI units, or an expression that depends on signals; if it is neither, record a fault."""
    if not isinstance(value, str):
        try:
            return convert(value, dimension, what=f"'{key}'")
        except InputError as error:
            reader.fault(keys, key, *error.faults)
            return None
    expression = reader.number(keys, key, value, dimension)
    if expression is None or not expression.node.constant:
        return expression
    constant = evaluate(expression.node, ())  # interpreted: compiling does not pay for a single evaluation
    if constant is None:
        reader.fault(keys, key, f"'{key}' has no value: {value} cannot be computed.")
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
