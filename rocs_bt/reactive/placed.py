"""Expressions inside a TOML file: compiled, with faults at the column where they stand in the file."""

from __future__ import annotations

import math
from dataclasses import replace

from ..document import Table
from ..errors import Fault, InputError
from ..expression import TRUTH, Environment, Expression, Node, compile_node, parse
from ..units import TIME, Dimension
from .rule import Place


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
        line, column = table.place(key)
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
