"""The typed tree of an expression: what `parse` gives, the interpreter reads and `lower` lowers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

from ..units import NONE, Dimension


@dataclass(frozen=True)
class Kind:
    """What an expression gives.

    Attributes:
        dimension: The dimension its numbers share; None for truth values, and where they differ (as in a pose).
        size: How many values; 0 for a single one.
        boolean: True for truth values.
    """

    dimension: Dimension | None = NONE
    size: int = 0
    boolean: bool = False

    @property
    def mixed(self) -> bool:
        """Whether its numbers have different dimensions, so that nothing but an index can use them."""
        return self.dimension is None and not self.boolean

    @property
    def words(self) -> str:
        """For messages, such as `in m`, `6 values in m`, `true or false`."""
        if self.mixed:
            return f"{self.size} values of different units"
        one = "true or false" if self.boolean else f"in {self.dimension}"
        return f"{self.size} values {one}" if self.size else one


TRUTH = Kind(dimension=None, boolean=True)
PLAIN = Kind()


TEMPORAL_OPS = frozenset({"held", "once", "since", "time_since", "rate", "delay"})


@dataclass(frozen=True)
class Node:
    """One operation of an expression.

    Two nodes that compute the same are equal, wherever they stand in a text.

    Attributes:
        op: `number`, `truth`, `read`, `vector`, `neg`, `+`, `-`, `*`, `/`, `compare`, `and`, `or`, `not`, `if`, a
            function, or `delay` (what its arg was, so long ago), which only `look_back` makes.
        args: What it works on. Of `if`: condition, then, else. Of temporal operations without the window.
        kind: What it gives.
        value: Of `number` and `truth` the value, in SI units; of what has a window its length [s].
        start: Of `read` the first index in the snapshot.
        stop: Of `read` the index after the last.
        signs: Of `compare` the comparison signs between the args.
        text: How it was written.
        span: Of `read` how wide the signal's bounds are, in SI units; +inf where they are open.
        column: Where it stands in its text, 1-based; 0 where unknown.
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
        """This node and all below it, from the top, left to right."""
        yield self
        for arg in self.args:
            yield from arg.walk()

    def reads(self) -> set[int]:
        """Every index of the snapshot that it reads."""
        if self.op == "read":
            return set(range(self.start, self.stop))
        return set().union(*(arg.reads() for arg in self.args))

    @cached_property
    def extent(self) -> tuple[int, int]:
        """The number of operations inside each other, and of all, those of aliases counted at every use."""
        depth = operations = 0
        for arg in self.args:
            inner, count = arg.extent
            depth, operations = max(depth, inner), operations + count
        return depth + 1, operations + 1

    @cached_property
    def temporal(self) -> bool:
        """Whether its value depends on earlier snapshots, too."""
        return self.op in TEMPORAL_OPS or any(arg.temporal for arg in self.args)

    @cached_property
    def future(self) -> bool:
        """Whether its value depends on later snapshots: it has a `within`."""
        return self.op == "within" or any(arg.future for arg in self.args)

    @property
    def constant(self) -> bool:
        """Whether it reads nothing of the snapshot, nor of time."""
        return all(node.op != "read" and node.op not in TEMPORAL_OPS for node in self.walk())
