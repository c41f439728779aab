"""The typed tree of an expression: what `parse` gives and both evaluators read."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from .kind import Kind


@dataclass(frozen=True)
class Node:
    """One operation of an expression.

    Two nodes that compute the same are equal, wherever they stand in a text.

    Attributes:
        op: `number`, `truth`, `read`, `neg`, `+`, `-`, `*`, `/`, `compare`, `and`, `or`, `not`, `if`, or a function.
        args: What it works on. Of `if`: condition, then, else.
        kind: What it gives.
        value: Of `number` and `truth` the value, in SI units.
        start: Of `read` the first index in the snapshot.
        stop: Of `read` the index after the last.
        signs: Of `compare` the comparison signs between the args.
        text: How it was written.
    """

    op: str
    kind: Kind
    args: tuple[Node, ...] = ()
    value: float | bool = 0.0
    start: int = 0
    stop: int = 0
    signs: tuple[str, ...] = ()
    text: str = field(default="", compare=False)

    def walk(self) -> Iterator[Node]:
        """This node and all below it, from the top, left to right."""
        yield self
        for arg in self.args:
            yield from arg.walk()

    def reads(self) -> set[int]:
        """Every index of the snapshot that must be valid for this expression to be valid."""
        if self.op == "read":
            return set(range(self.start, self.stop))
        if self.op == "min_valid":
            return set()
        return set().union(*(arg.reads() for arg in self.args))

    @property
    def constant(self) -> bool:
        """Whether it reads nothing of the snapshot."""
        return all(node.op != "read" for node in self.walk())
