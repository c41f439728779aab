"""Meaning of the names in an expression: signals with their position in the snapshot, and aliases."""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

from ..signal import Signal
from .node import Node


class SignalLayout(Protocol):
    """Part of Knowledge's signal table that defines an environment."""

    @property
    def names(self) -> Collection[str]:
        """Names of all signals."""
        ...

    def spec(self, name: str) -> Signal:
        """Declaration of a signal."""
        ...

    def slice_of(self, name: str) -> slice:
        """Position of a signal in the snapshot."""
        ...


class Forms(Protocol):
    """Additional syntax of an environment: dotted names, quoted texts, functions of graph nodes."""

    def read(self, tree: ast.expr, at: Callable[[ast.expr], int]) -> Node | None:
        """Typed tree of a part of an expression; None to leave the part to the base language.

        Args:
            tree: Part of the expression, with quoted texts blanked out.
            at: Function that returns the offset of a part in the original text, counted from 0.

        Raises:
            Misuse: The part has no meaning in this environment.
        """
        ...


@dataclass(frozen=True)
class Environment:
    """Names that expressions may use.

    Attributes:
        signals: Declaration of each signal.
        offsets: First index of each signal in the snapshot.
        aliases: Names of expressions.
        forms: Additional syntax, such as that of queries; None for none.
    """

    signals: Mapping[str, Signal]
    offsets: Mapping[str, int]
    aliases: Mapping[str, Node] = field(default_factory=dict)
    forms: Forms | None = None

    @staticmethod
    def of(table: SignalLayout) -> Environment:
        """Environment of a signal table with a final layout."""
        names = list(table.names)
        return Environment(
            signals={name: table.spec(name) for name in names},
            offsets={name: table.slice_of(name).start for name in names},
        )

    @staticmethod
    def packed(signals: Iterable[Signal]) -> Environment:
        """Environment of signals that are contiguous in the snapshot."""
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
