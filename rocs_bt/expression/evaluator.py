"""Evaluators of expressions: sample after sample, in the kernel where it is compiled, and in series, in numpy."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .kernel import kernel_missing, program_machine
from .lower import lower
from .node import TEMPORAL_OPS, Node
from .program import GRAIN, Program
from .rows import Rows

Snapshot = NDArray[np.float64] | Sequence[float]


class Expression:
    """Compiled expression with a single value, called with a snapshot of the signals.

    An expression with temporal operators keeps state between calls: each call is a sample. A call with an earlier time
    than the last one resets this state.

    Args:
        node: Typed tree of the expression.
        margins: Whether each call also computes the robustness margin, for an expression with a truth value.

    Attributes:
        margin: Robustness margin at the last call, positive if the expression was true; NaN if unknown or not
            requested.
    """

    def __init__(self, node: Node, margins: bool = False) -> None:
        self.node = node
        self.margin = math.nan
        self._margins = margins

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Expression) and self.node == other.node

    def __hash__(self) -> int:
        return hash(self.node)

    @property
    def text(self) -> str:
        """Text of the expression."""
        return self.node.text

    def __call__(self, x: Snapshot, t: float = 0.0) -> float | bool | None:
        """Value on a snapshot; None if invalid, because a required signal is NaN or the result is not a number.

        Args:
            x: Snapshot of all signals, SI units, shape (size,).
            t: Time of the snapshot [s].
        """
        root, margin, machine = self._compiled
        value = machine.value(np.asarray(x, float), t, root)
        if margin >= 0:
            self.margin = machine.register(margin)
        if value != value:
            return None
        return value == 1.0 if self.node.kind.boolean else value

    def prepare(self) -> None:
        """Compile the expression now instead of at the first call."""
        _ = self._compiled

    def reset(self) -> None:
        """Discard the state of all earlier calls."""
        self.__dict__.pop("_compiled", None)  # a cached property, which is computed again

    @cached_property
    def _compiled(self) -> tuple[int, int, Machine]:
        """Registers of the value and of the margin, -1 for none, and the machine."""
        program = lower([self.node], margins=int(self._margins))
        root, margin = int(program.roots[0]), int(program.margins[0])
        machine = _NumpyMachine(program) if kernel_missing() else program_machine(program)
        return root, margin, machine


class Machine(Protocol):
    """Program of one expression, run step by step."""

    def value(self, x: NDArray[np.float64], t: float, index: int, /) -> float:
        """Value of a register on a snapshot; an earlier time than the last one resets the state first."""
        ...

    def register(self, index: int, /) -> float:
        """Value of a register after the last step."""
        ...


class _NumpyMachine:
    def __init__(self, program: Program) -> None:
        self._program, self._rows = program, Rows(program)
        self._time = -math.inf

    def value(self, x: NDArray[np.float64], t: float, index: int, /) -> float:
        if t < self._time or self._time == -math.inf:
            self._cells = self._program.cells[np.newaxis].copy()
        self._time = t
        self._registers = registers = self._rows(x[np.newaxis], np.array([t]), self._cells)
        return float(registers[index, 0])

    def register(self, index: int, /) -> float:
        return float(self._registers[index, 0])


class Values:
    """Expressions evaluated together on series of samples, also with several values.

    Args:
        nodes: Typed trees of the expressions.
    """

    def __init__(self, nodes: Sequence[Node]) -> None:
        program = lower(nodes)
        self._nodes, self._roots = nodes, program.roots.tolist()
        self._rows, self._cells = Rows(program), program.cells[np.newaxis].copy()

    def __call__(self, x: NDArray[np.float64], t: NDArray[np.float64]) -> list[NDArray[np.float64]]:
        """Values of each expression, shape (n,), or (n, size) for several values; NaN if invalid.

        Args:
            x: Snapshots of all signals, SI units, shape (n, signals).
            t: Their times, ascending, not before those of the last call [s], shape (n,).
        """
        found = [np.empty((len(t), max(1, node.kind.size))) for node in self._nodes]
        for part, registers in self._rows.chunks(x, t, self._cells):
            for root, values in zip(self._roots, found, strict=True):
                values[part] = registers[root : root + values.shape[1]].T
        return [v if node.kind.size else v[:, 0] for v, node in zip(found, self._nodes, strict=True)]


class Steady:
    """Expressions with single values on snapshots that have been constant for longer than all time windows.

    Args:
        nodes: Typed trees of the expressions.
    """

    def __init__(self, nodes: Sequence[Node]) -> None:
        self._program = lower([_with_short_windows(node) for node in nodes])
        self._rows = Rows(self._program)
        # One step for each window, because the window of an operator on another one fills later.
        self._steps = 1 + max((sum(part.op in TEMPORAL_OPS for part in node.walk()) for node in nodes), default=0)

    def __call__(self, x: NDArray[np.float64]) -> list[NDArray[np.float64]]:
        """Values of each expression on each of n snapshots, shape (n,); NaN if invalid.

        Args:
            x: Snapshots of all signals, SI units, shape (n, signals).
        """
        cells = np.tile(self._program.cells, (len(x), 1))
        for step in range(self._steps):
            registers = self._rows(x, np.full(len(x), float(step)), cells)
        return [registers[root] for root in self._program.roots.tolist()]


def _with_short_windows(node: Node) -> Node:
    """Expression with the shortest time windows, which have the smallest states, and the same steady values."""
    if not node.temporal:
        return node
    window = GRAIN if node.op in TEMPORAL_OPS else node.value
    return replace(node, value=window, args=tuple(map(_with_short_windows, node.args)))


def evaluate(node: Node, x: Snapshot) -> float | bool | None:
    """Value of an expression without temporal operators, with a single value, on one snapshot; None if invalid.

    Args:
        node: Typed tree from `parse`.
        x: Snapshot: values of all signals, SI units.
    """
    if node.kind.size or node.temporal:
        raise TypeError(f"'{node.text}' gives {node.kind.words} over time, not a single value")
    return node.value if node.op in ("number", "truth") else Expression(node)(x)
