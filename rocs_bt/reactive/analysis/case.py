"""State shared by the checks of a rule set: rules, prover and findings."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from ...base.errors import Fault
from ...base.units import NONE, Dimension, Quantity
from ...expression import Environment, Node
from ..rule import Rule
from .prover import Prover, by_index
from .sample import Array


class Case:
    """Rule set under analysis, with the findings so far."""

    def __init__(self, rules: Sequence[Rule], environment: Environment) -> None:
        self.rules = rules
        self.environment = environment
        self.faults: list[Fault] = []
        self._owner = by_index(environment)

    @cached_property
    def prover(self) -> Prover:
        """Prover for all expressions of the rules, created on first use."""
        return Prover(self.environment, [node for rule in self.rules for node in rule.nodes()])

    def warn(
        self,
        rule: Rule,
        key: str,
        message: str,
        hint: str,
        node: Node | None = None,
        column: int = 0,
        note: bool = False,
    ) -> None:
        """Add a warning at the position of a rule's key.

        If the rule omits the key, the finding is at the rule's position. Columns are 1-based.
        """
        position = rule.positions.get(key) or rule.positions.get("")
        found = Fault(message, hint=hint, warning=True, note=note)
        if position is not None:
            inside = max(0, (column or (node.column if node else 0)) - 1) if _in_expression(position.column, key) else 0
            found = replace(found, file=position.file, line=position.line, column=position.column + inside)
        self.faults.append(found)

    def error(self, rule: Rule, key: str, message: str, hint: str) -> None:
        """Add an error. Rules with errors cannot be loaded."""
        self.warn(rule, key, message, hint)
        self.faults[-1] = replace(self.faults[-1], warning=False)

    def signals_of(self, node: Node) -> list[str]:
        """Names of the signals that an expression reads."""
        return list(dict.fromkeys(self._owner(i)[0] for i in sorted(node.reads())))

    def undecided(self, rule: Rule, key: str, question: str, why: str) -> None:
        """Add a note that a question could not be decided."""
        self.warn(rule, key, f"cannot decide {question}: {why}.", "", note=True)

    def shown(self, x: Array, nodes: Iterable[Node]) -> str:
        """Text with the values of all signals that expressions read: `front[2] = 0.3 m, each other front = 1 m`.

        Args:
            x: Snapshot, shape (size,).
            nodes: Expressions.
        """
        indices: dict[str, list[int]] = {}
        for index in sorted(set().union(*(node.reads() for node in nodes))):
            name, i = self._owner(index)
            indices.setdefault(name, []).append(i)
        return ", ".join(self._signal(name, x, read) for name, read in indices.items()) or "every snapshot"

    def value_at(self, x: Array, index: int) -> str:
        """Text with the name and value of one signal value: `front[2] = 0.3 m`.

        Args:
            x: Snapshot, shape (size,).
            index: Index of the value in the snapshot.
        """
        name, i = self._owner(index)
        signal = self.environment.signals[name]
        which = name if signal.size == 1 else f"{name}[{i}]"
        return f"{which} = {_quantity(float(x[index]), signal.dimension or signal.dimensions[i])}"

    def bounds(self, nodes: Iterable[Node]) -> str:
        """Text with the bounds of all signals that expressions read: `front is between 0 m and 3 m`."""
        shown = []
        for name in dict.fromkeys(name for node in nodes for name in self.signals_of(node)):
            signal = self.environment.signals[name]
            low, high = (_quantity(bound, signal.dimension) for bound in signal.bounds)
            shown.append(f"{name} is between {low} and {high}")
        return " and ".join(shown)

    def _signal(self, name: str, x: Array, read: list[int]) -> str:
        signal, start = self.environment.signals[name], self.environment.offsets[name]
        values = {i: float(x[start + i]) for i in read}
        if signal.size == 1:
            return f"{name} = {_quantity(values[0], signal.dimension)}"
        if signal.dimension is None:
            dimensions = signal.dimensions
            return ", ".join(f"{name}[{i}] = {_quantity(v, dimensions[i])}" for i, v in values.items())
        if len(set(values.values())) == 1:
            which = f"each {name}" if len(read) == signal.size else ", ".join(f"{name}[{i}]" for i in read)
            return f"{which} = {_quantity(values[read[0]], signal.dimension)}"
        common = max(values.values(), key=list(values.values()).count)
        odd = [f"{name}[{i}] = {_quantity(v, signal.dimension)}" for i, v in values.items() if v != common]
        rest = f"each other {name}" if len(odd) < len(read) - 1 else f"{name}[{_index(values, common)}]"
        return ", ".join([*odd, f"{rest} = {_quantity(common, signal.dimension)}"])


def short(rule: Rule) -> str:
    """Name of a rule without its file: `Rule` for `file/Rule`."""
    return rule.name.rpartition("/")[2]


def nodes_with_columns(node: Node, column: int = 0) -> Iterator[tuple[Node, int]]:
    """All nodes of an expression tree, each with its column in the text of the guard.

    Nodes inside an alias get the column of the alias, because their own text is not in the guard.
    """
    here = column or node.column
    yield node, here
    inside = here if column or (node.op != "read" and node.text.isidentifier()) else 0
    for arg in node.args:
        yield from nodes_with_columns(arg, inside)


def _index(values: dict[int, float], value: float) -> int:
    return next(i for i, v in values.items() if v == value)


def _quantity(value: float, dimension: Dimension | None) -> str:
    shown = float(np.format_float_positional(value, 6, fractional=False)) if np.isfinite(value) else value
    return str(Quantity(shown, dimension or NONE))


def _in_expression(column: int, key: str) -> bool:
    """Whether a column lies inside the expression of a key; it is the key's own for an expression of several lines."""
    return key in ("when", "until") and column > len(key) + 3
