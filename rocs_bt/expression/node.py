"""Typed tree of an expression: created by `parse`; evaluated by the evaluator; compiled by `lower`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

from ..base.units import NONE, Dimension


@dataclass(frozen=True)
class Kind:
    """Kind of an expression's value: dimension, number of values, and whether it is a truth value.

    Attributes:
        dimension: Common dimension of the numbers; None for truth values, and for numbers of different dimensions, as
            in a pose.
        size: Number of values; 0 for a single value.
        boolean: Whether the values are truth values.
    """

    dimension: Dimension | None = NONE
    size: int = 0
    boolean: bool = False

    @property
    def mixed(self) -> bool:
        """Whether the numbers have different dimensions, so that they can only be used by index."""
        return self.dimension is None and not self.boolean

    @property
    def words(self) -> str:
        """Text for messages, such as `in m`, `6 values in m`, `true or false`."""
        if self.mixed:
            return f"{self.size} values of different units"
        one = "true or false" if self.boolean else f"in {self.dimension}"
        return f"{self.size} values {one}" if self.size else one


TRUTH = Kind(dimension=None, boolean=True)
PLAIN = Kind()


TEMPORAL_OPS = frozenset({"held", "once", "since", "time_since", "rate", "delay"})


@dataclass(frozen=True)
class Node:
    """Node of a typed tree: one operation, constant or read of a signal.

    Nodes that compute the same value are equal, whatever their text or position is.

    Attributes:
        op: `number`, `truth`, `read`, `vector`, `neg`, `+`, `-`, `*`, `/`, `compare`, `and`, `or`, `not`, `if`,
            `within`, the name of a function, or `delay` (value of the argument a fixed time ago), which only
            `look_back` creates.
        args: Operands. Those of `if` are condition, then, else; those of temporal operators do not include the window.
        kind: Kind of the result.
        value: Value of a `number`, in SI units, or of a `truth`; length of the window of a temporal operator [s].
        start: First index of a `read` in the snapshot.
        stop: Index after the last one of a `read` in the snapshot.
        signs: Comparison signs between the operands of a `compare`.
        text: Source text of the node.
        span: Upper minus lower bound of the signal of a `read`, in SI units; +inf if unbounded.
        column: Column in the source text, counted from 1; 0 if unknown.
    """

    op: str
    kind: Kind
    args: tuple[Node, ...] = ()
    value: float | bool = 0.0
    start: int = 0
    stop: int = 0
    signs: tuple[str, ...] = ()
    text: str = field(default="", compare=False)
    span: float = field(default=math.inf, compare=False)
    column: int = field(default=0, compare=False)

    @cached_property
    def _hash(self) -> int:
        return hash((self.op, self.args, self.value, self.start, self.signs))

    def __hash__(self) -> int:
        return self._hash  # kept, because trees are keys of many tables, and a hash visits the whole tree

    def __getstate__(self) -> dict[str, object]:
        return {key: value for key, value in self.__dict__.items() if key != "_hash"}  # it differs between processes

    def walk(self) -> Iterator[Node]:
        """This node and all its descendants, depth first, left to right."""
        yield self
        for arg in self.args:
            yield from arg.walk()

    @property
    def pairs(self) -> tuple[Node, ...]:
        """Comparisons of two operands each that a `compare`, such as `a < b < c`, joins by "and"."""
        if len(self.signs) < 2:
            return (self,)
        found = zip(self.signs, pairwise(self.args), strict=True)
        return tuple(
            Node("compare", self.kind, (a, b), signs=(sign,), text=f"{a.text} {sign} {b.text}", column=a.column)
            for sign, (a, b) in found
        )

    def reads(self) -> set[int]:
        """All indices of the snapshot that the node reads."""
        spans = {(node.start, node.stop) for node in self.walk() if node.op == "read"}
        return {i for span in spans for i in range(*span)}

    @cached_property
    def extent(self) -> tuple[int, int]:
        """Nesting depth and number of operations; an alias counts at each of its uses."""
        depth = operations = 0
        for arg in self.args:
            inner, count = arg.extent
            depth, operations = max(depth, inner), operations + count
        return depth + 1, operations + 1

    @cached_property
    def temporal(self) -> bool:
        """Whether the value depends on earlier snapshots."""
        return self.op in TEMPORAL_OPS or any(arg.temporal for arg in self.args)

    @cached_property
    def future(self) -> bool:
        """Whether the value depends on later snapshots, because of a `within`."""
        return self.op == "within" or any(arg.future for arg in self.args)

    @property
    def constant(self) -> bool:
        """Whether the value depends neither on the snapshot nor on time."""
        return all(node.op != "read" and node.op not in TEMPORAL_OPS for node in self.walk())
