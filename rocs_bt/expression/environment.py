"""What the names in an expression mean: signals with their place in the snapshot, and aliases."""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

from ..signal import Signal
from .node import Node


class SignalLayout(Protocol):
    """The part of Knowledge's signal table that an environment is built from."""

    @property
    def names(self) -> Collection[str]:
        """All signals."""
        ...

    def spec(self, name: str) -> Signal:
        """A signal's declaration."""
        ...

    def slice_of(self, name: str) -> slice:
        """Where a signal stands in the snapshot."""
        ...


class Forms(Protocol):
    """What an environment understands beside names of numbers: dotted names, texts in quotes, functions of things."""

    def read(self, tree: ast.expr, at: Callable[[ast.expr], int]) -> Node | None:
        """What a part of an expression means; None where it is for the language itself to say.

        Args:
            tree: The part. A text in quotes is blanked out in it.
            at: Where any part begins in the text that was written, 0-based.

        Raises:
            Misuse: It means nothing here.
        """
        ...


@dataclass(frozen=True)
class Environment:
    """The names that expressions may use.

    Attributes:
        signals: Each signal's declaration.
        offsets: Where each signal begins in the snapshot.
        aliases: Names for expressions.
        forms: What else it understands, such as the things of a query; None for nothing.
    """

    signals: Mapping[str, Signal]
    offsets: Mapping[str, int]
    aliases: Mapping[str, Node] = field(default_factory=dict)
    forms: Forms | None = None

    @staticmethod
    def of(table: SignalLayout) -> Environment:
        """The environment of a signal table that is complete: its layout must not change any more."""
        names = list(table.names)
        return Environment(
            signals={name: table.spec(name) for name in names},
            offsets={name: table.slice_of(name).start for name in names},
        )

    @staticmethod
    def packed(signals: Iterable[Signal]) -> Environment:
        """The environment of signals that stand in the snapshot one after the other."""
        declared, offsets, at = {}, {}, 0
        for signal in signals:
            declared[signal.name], offsets[signal.name] = signal, at
            at += signal.size
        return Environment(declared, offsets)

    def with_alias(self, name: str, node: Node) -> Environment:
        """This environment and one name more."""
        return replace(self, aliases={**self.aliases, name: node})

    @property
    def size(self) -> int:
        """How many values a snapshot has, as far as is known here."""
        return max((at + self.signals[name].size for name, at in self.offsets.items()), default=0)

    @property
    def names(self) -> list[str]:
        """All names that an expression may use for values."""
        return [*self.signals, *self.aliases]
