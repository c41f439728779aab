"""What the checks of a rule set share: the rules, the prover, and how findings are told."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from ...errors import Fault
from ...expression import Environment, Node
from ...units import NONE, Dimension, Quantity
from ..rule import Rule
from .prover import Prover, by_index
from .sample import Array


class Case:
    """A rule set under examination.

    Args:
        rules: The rules.
        environment: The robot's signals.

    Attributes:
        faults: What was found.
    """

    def __init__(self, rules: Sequence[Rule], environment: Environment) -> None:
        self.rules = rules
        self.environment = environment
        self.faults: list[Fault] = []
        self._owner = by_index(environment)

    @cached_property
    def prover(self) -> Prover:
        """Made when it is first asked."""
        return Prover(self.environment, [node for rule in self.rules for node in rule.nodes()])

    def tell(
        self,
        rule: Rule,
        key: str,
        message: str,
        hint: str,
        node: Node | None = None,
        column: int = 0,
        note: bool = False,
    ) -> None:
        """Note a finding.

        Args:
            rule: Whose.
            key: Which of its keys; the rule itself where it has none.
            message: What was found, with an example.
            hint: What to do.
            node: What of the key's expression is meant.
            column: Where that stands in the expression, 1-based; the node's own column by default.
            note: Whether nothing is known to be wrong.
        """
        place = rule.places.get(key) or rule.places.get("")
        found = Fault(message, hint=hint, warning=True, note=note)
        if place is not None:
            inside = max(0, (column or (node.column if node else 0)) - 1) if _in_expression(place.column, key) else 0
            found = replace(found, file=place.file, line=place.line, column=place.column + inside)
        self.faults.append(found)

    def tell_wrong(self, rule: Rule, key: str, message: str, hint: str) -> None:
        """Note what keeps the rules from being loaded."""
        self.tell(rule, key, message, hint)
        self.faults[-1] = replace(self.faults[-1], warning=False)

    def signals_of(self, node: Node) -> list[str]:
        """The signals that an expression reads."""
        return list(dict.fromkeys(self._owner(i)[0] for i in sorted(node.reads())))

    def undecided(self, rule: Rule, key: str, question: str, why: str) -> None:
        """Say that a question could not be decided."""
        self.tell(rule, key, f"cannot decide {question}: {why}.", "", note=True)

    def shown(self, x: Array, nodes: Iterable[Node]) -> str:
        """The signals that expressions read, with their values: `front[2] = 0.3 m, all other front = 1 m`."""
        places: dict[str, list[int]] = {}
        for index in sorted(set().union(*(node.reads() for node in nodes))):
            name, i = self._owner(index)
            places.setdefault(name, []).append(i)
        return ", ".join(self._signal(name, x, read) for name, read in places.items()) or "every snapshot"

    def value_at(self, x: Array, index: int) -> str:
        """One value of a snapshot: `front[2] = 0.3 m`."""
        name, i = self._owner(index)
        signal = self.environment.signals[name]
        which = name if signal.size == 1 else f"{name}[{i}]"
        return f"{which} = {_quantity(float(x[index]), signal.dimension or signal.dimensions[i])}"

    def bounds(self, nodes: Iterable[Node]) -> str:
        """The bounds of the signals that expressions read."""
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
    """A rule's name without its file's."""
    return rule.name.rpartition("/")[2]


def placed(node: Node, column: int = 0) -> Iterator[tuple[Node, int]]:
    """A tree's nodes, each with the column where it, or the alias that it stands in, was written."""
    here = column or node.column
    yield node, here
    inside = here if column or (node.op != "read" and node.text.isidentifier()) else 0
    for arg in node.args:
        yield from placed(arg, inside)


def _index(values: dict[int, float], value: float) -> int:
    return next(i for i, v in values.items() if v == value)


def _quantity(value: float, dimension: Dimension | None) -> str:
    shown = float(np.format_float_positional(value, 6, fractional=False)) if np.isfinite(value) else value
    return str(Quantity(shown, dimension or NONE))


def _in_expression(column: int, key: str) -> bool:
    """Whether a place is that of an expression's text, and not of its key, which has to do for texts of many lines."""
    return key in ("when", "until") and column > len(key) + 3
