"""Named thresholds: constants of a rule file, which follow the robot that the file is loaded for.

[robot]                         # in a rule file: values of the robot; those written here hold without a robot
latency = "0.1 s"
deceleration = "3 m/s2"

[threshold]
fast = "0.5 m/s"
margin = "0.2 m"
near = "fast * latency + fast * fast / (2 * deceleration) + margin"

[rules.avoid_collision]         # in robot.toml: a value of its own, from which those above follow, too
margin = "0.3 m"
"""

from __future__ import annotations

import keyword
import math
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..base.errors import Fault, InputError, did_you_mean, unknown
from ..base.units import NONE, Quantity, convert, parse_quantity, unit_names
from ..control.body_values import BODY_VALUES as ROBOT_VALUES
from ..declare import NOWHERE, Location, Open
from ..expression import FUNCTIONS, Environment, Kind, Node, evaluate
from .arguments import ExpressionReader, words
from .include import RuleDocument
from .rule_keys import is_name

DIGITS = 4
"""Significant digits of a computed threshold."""
_OPERATION = re.compile(r"[-+*(]|\s/")
WORDS = frozenset({"inf", "always", "within", "implies"})


@dataclass(frozen=True)
class Override:
    """Value that overrides a threshold of a rule file.

    Attributes:
        value: Value as written in the file, such as `0.5 m`.
        place: Position of the value.
    """

    value: Any
    place: Location = NOWHERE


def usable(name: str, taken: Collection[str]) -> bool:
    """Whether a word can be a new name in expressions."""
    words = {*FUNCTIONS, *unit_names(), *keyword.kwlist, *WORDS, *taken}
    return is_name(name) and name not in words


def read_thresholds(
    documents: Sequence[RuleDocument], environment: Environment, overrides: Mapping[str, Override], rules: str
) -> tuple[dict[str, Node], list[Fault]]:
    """Read the `[robot]` and `[threshold]` tables of a rule file and of its included files.

    Returns constants by name, and the faults of `overrides`. Later documents override thresholds of earlier ones.
    """
    reader = _ThresholdReader(environment, overrides)
    for document in documents:
        reader.declare(document, document.keys.robot, robot=True)
        reader.declare(document, document.keys.threshold, robot=False)
    return reader.read(rules)


@dataclass(frozen=True)
class _Declaration:
    """One declaration of a threshold: its table, and the reader of the file's expressions."""

    table: Open
    reader: ExpressionReader
    robot: bool


class _ThresholdReader:
    """Reader of thresholds, which may name each other in any order."""

    def __init__(self, environment: Environment, overrides: Mapping[str, Override]) -> None:
        self._environment = environment
        self._overrides = overrides
        self._declared: dict[str, list[_Declaration]] = {}
        self._nodes: dict[str, Node] = {}
        self._open: list[str] = []  # thresholds that are being read
        self._faults: list[Fault] = []

    def declare(self, document: RuleDocument, table: Open, robot: bool) -> None:
        """Add the thresholds of one table of a file."""
        reader = ExpressionReader(document, self._environment)
        for name in table:
            before = self._declared.get(name, [])
            if not usable(name, self._environment.signals):
                hint = "It must be a new word: no signal, function or unit."
                reader.fault(table, name, Fault(f"'{name}' cannot be a threshold.", hint=hint))
            elif robot and name not in ROBOT_VALUES:
                reader.fault(table, name, unknown("value of a robot", name, ROBOT_VALUES, "A robot"))
            elif before and (before[-1].reader.faults is reader.faults or before[-1].robot is not robot):
                other = "[robot]" if before[-1].robot else "[threshold]"
                fault = Fault(f"'{name}' is declared in {other} already.", hint="Use another name.")
                reader.fault(table, name, fault)
            else:
                self._declared[name] = [*before, _Declaration(table, reader, robot)]

    def read(self, rules: str) -> tuple[dict[str, Node], list[Fault]]:
        """Values of all thresholds, and the faults of the overrides."""
        for name in self._declared:
            self._node(name)
        for name, own in self._overrides.items():
            if name not in self._declared:
                hint = did_you_mean(name, self._declared, f"The rule file '{rules}'")
                self._faults.append(Fault(f"no threshold of '{rules}' is named '{name}'.", *own.place, hint))
        return {name: self._nodes[name] for name in self._declared if name in self._nodes}, self._faults

    def _node(self, name: str) -> Node | None:
        """Node of a threshold: the robot's value, else the last one of the files; None if it is invalid."""
        if name in self._nodes or name in self._open:
            return self._nodes.get(name)
        self._open.append(name)
        node: Node | None = None
        for declaration in self._declared[name]:
            try:
                node = self._written(name, declaration, node)
            except InputError as error:
                declaration.reader.fault(declaration.table, name, *error.faults)
        if node is not None and (own := self._overrides.get(name)) is not None:
            try:
                node = _constant(name, _quantity(name, own.value, node))
            except InputError as error:
                self._faults.extend(error.at(*own.place).faults)
        self._open.pop()
        if node is not None:
            self._nodes[name] = node
        return node

    def _written(self, name: str, declaration: _Declaration, before: Node | None) -> Node | None:
        """Node of one declaration; None if its expression is invalid, with the faults recorded."""
        value = declaration.table[name]
        if declaration.robot:
            quantity = _quantity(name, value, _constant(name, Quantity(0.0, ROBOT_VALUES[name].dimension)))
            return _constant(name, self._environment.robot.get(name, quantity))
        try:
            return _constant(name, _quantity(name, value, before))
        except InputError:
            if isinstance(value, str) and (_OPERATION.search(value) or words(value) & self._declared.keys()):
                return self._computed(name, value, declaration, before)
            raise

    def _computed(self, name: str, text: str, declaration: _Declaration, before: Node | None) -> Node | None:
        """Constant of an expression over other thresholds."""
        used = sorted(words(text) & self._declared.keys())
        if circle := [other for other in used if other in self._open]:
            chain = [*self._open[self._open.index(circle[0]) :], circle[0]]
            raise InputError(f"the thresholds depend on each other: {' -> '.join(chain)}.")
        known = {other: node for other in used if (node := self._node(other)) is not None}
        if len(known) < len(used):
            return None  # reported where they are declared
        if read := sorted(words(text) & self._environment.signals.keys()):
            message = f"a threshold is constant, but '{text}' reads the signal '{read[0]}'."
            raise InputError(Fault(message, hint="Write an [alias] instead."))
        others = dict.fromkeys(self._declared, Node("number", Kind()))  # for the list of valid names only
        reader = declaration.reader
        reader.environment = Environment({}, {}, aliases=others | known)
        node = reader.node(declaration.table, name, text)
        if node is None:
            return None
        if node.kind.boolean or node.kind.size or (before is not None and before.kind != node.kind):
            expected = "a number" if before is None else before.kind.words
            raise InputError(f"'{name}' must be {expected}, but {text} is {node.kind.words}.")
        value = evaluate(node, ()) if node.constant else None
        if value is None or not math.isfinite(value):
            raise InputError(f"'{name}' has no value: {text} cannot be computed.")
        # Rounded, so that messages show the value that is used; the robot's constants have at most three digits.
        return Node("number", node.kind, value=float(f"{value:.{DIGITS}g}"), text=name)


def _quantity(name: str, value: Any, before: Node | None) -> Quantity:
    """Quantity of a threshold as written; it must have the dimension of the threshold that it replaces, if any."""
    if before is not None and before.kind.dimension is not None:
        return Quantity(convert(value, before.kind.dimension, what=f"'{name}'"), before.kind.dimension)
    if isinstance(value, str):
        return parse_quantity(value)
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return Quantity(float(value), NONE)
    raise InputError(f"'{name}' must be a quantity, such as \"0.5 m\", found {value!r}.")


def _constant(name: str, quantity: Quantity) -> Node:
    """Expression node of a threshold."""
    return Node("number", Kind(quantity.dimension), value=quantity.value, text=name)
