"""Typed tree of an expression: created by `parse`, used by the interpreter and by `lower`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

from ..units import NONE, Dimension


@dataclass(frozen=True)
class Kind:
    """Kind of a value.

    Attributes:
        dimension: Common dimension of the numbers; None for truth values, and if dimensions differ (as in a pose).
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
    """Operation of an expression.

    Nodes that compute the same value are equal, independent of their position in a text.

    Attributes:
        op: `number`, `truth`, `read`, `vector`, `neg`, `+`, `-`, `*`, `/`, `compare`, `and`, `or`, `not`, `if`, a
            function, or `delay` (the argument's value a fixed time ago), which only `look_back` creates.
        args: Operands. Of `if`: condition, then, else. Of temporal operations: without the window.
        kind: Kind of the result.
        value: Value of `number` and `truth`, in SI units; length of the window [s] of temporal operations.
        start: First index in the snapshot, of `read`.
        stop: Index after the last one, of `read`.
        signs: Comparison signs between the operands, of `compare`.
        text: Text of the operation.
        span: Width of the signal's bounds in SI units, of `read`; +inf if unbounded.
        column: Column in the text, counted from 1; 0 if unknown.
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

    def walk(self) -> Iterator[Node]:
        """This node and all its descendants, depth first, left to right."""
        yield self
        for arg in self.args:
            yield from arg.walk()

    def reads(self) -> set[int]:
        """All indices of the snapshot that the node reads."""
        if self.op == "read":
            return set(range(self.start, self.stop))
        return set().union(*(arg.reads() for arg in self.args))

    @cached_property
    def extent(self) -> tuple[int, int]:
        """Nesting depth and number of operations; aliases count at each use."""
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
