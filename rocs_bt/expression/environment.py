"""What the names in an expression mean: signals with their place in the snapshot, and aliases."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
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


@dataclass(frozen=True)
class Environment:
    """The names that expressions may use.

    Attributes:
        signals: Each signal's declaration.
        offsets: Where each signal begins in the snapshot.
        aliases: Names for expressions.
    """

    signals: Mapping[str, Signal]
    offsets: Mapping[str, int]
    aliases: Mapping[str, Node] = field(default_factory=dict)

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
