"""Environment of an expression: the meaning of its names, which are signals or aliases."""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

from ..base.signal import Signal
from ..base.units import Quantity
from .node import Node


class SignalLayout(Protocol):
    """Interface of a signal table: declarations of the signals and their positions in the snapshot."""

    @property
    def names(self) -> Collection[str]:
        """Names of all signals."""

    def spec(self, name: str) -> Signal:
        """Declaration of a signal."""

    def slice_of(self, name: str) -> slice:
        """Slice of the snapshot that contains a signal."""


class Forms(Protocol):
    """Interface of additional syntax, as in queries: dotted names, quoted texts, functions of graph nodes."""

    def read(self, tree: ast.expr, at: Callable[[ast.expr], int]) -> Node | None:
        """Convert a subexpression to a typed tree; None if it belongs to the base language.

        Args:
            tree: Subexpression; the characters of quoted texts are replaced by `_`.
            at: Function from a subexpression to its offset in the original text, counted from 0.

        Raises:
            Misuse: The subexpression has no meaning in this environment.
        """


@dataclass(frozen=True)
class Environment:
    """Environment of expressions: the names that they may use.

    Attributes:
        signals: Declaration of each signal, by name.
        offsets: First index of each signal in the snapshot, by name.
        aliases: Expressions that have a name of their own, by name.
        forms: Additional syntax, such as that of queries, or None.
        robot: Constants of the robot that a rule file may name in its `[robot]` table; empty without a robot.
    """

    signals: Mapping[str, Signal]
    offsets: Mapping[str, int]
    aliases: Mapping[str, Node] = field(default_factory=dict)
    forms: Forms | None = None
    robot: Mapping[str, Quantity] = field(default_factory=dict)

    @staticmethod
    def of(table: SignalLayout, robot: Mapping[str, Quantity] | None = None) -> Environment:
        """Environment of a signal table and of constants of the robot; the table must not change later."""
        names = list(table.names)
        return Environment(
            signals={name: table.spec(name) for name in names},
            offsets={name: table.slice_of(name).start for name in names},
            robot=robot or {},
        )

    @staticmethod
    def packed(signals: Iterable[Signal]) -> Environment:
        """Environment of signals that lie in the snapshot one after the other, without gaps."""
        declared, offsets, at = {}, {}, 0
        for signal in signals:
            declared[signal.name], offsets[signal.name] = signal, at
            at += signal.size
        return Environment(declared, offsets)

    def with_alias(self, name: str, node: Node) -> Environment:
        """Copy of this environment with an additional alias."""
        return replace(self, aliases={**self.aliases, name: node})

    @property
    def size(self) -> int:
        """Number of values that a snapshot needs to contain all signals."""
        return max((at + self.signals[name].size for name, at in self.offsets.items()), default=0)

    @property
    def names(self) -> list[str]:
        """All names that expressions may use for values."""
        return [*self.signals, *self.aliases]
