"""Prover that decides whether an expression can be true for any values of the signals.

The answer is an example, a proof that no example exists, or the reason why neither was found. Sampled snapshots answer
most questions; z3 answers the others. Every example is a snapshot on which the evaluator gives true, also those of z3.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ...expression import TRUTH, Environment, Node, Steady
from .sample import Array, Range, Samples, sample_rows

if TYPE_CHECKING:
    from .translator import Translator

SAMPLED = 400  # number of sampled snapshots that are tried before a proof
STEPS = 10_000_000  # steps of z3 for one question, about 1 s
ALL_STEPS = 40_000_000  # steps of z3 for all questions about one rule set, ...
STEPS_EACH = 200_000  # ... and in addition for each of its expressions


@dataclass(frozen=True)
class Answer:
    """Answer to the question whether an expression can be true.

    Attributes:
        example: Snapshot on which the expression is true, shape (size,); None if none exists or none was found.
        unknown: Reason why the question is undecided; empty if decided.
    """

    example: Array | None = None
    unknown: str = ""

    @property
    def never(self) -> bool:
        """Whether the expression is proved to be never true."""
        return self.example is None and not self.unknown


class Prover:
    """Prover for expressions over a robot's signals."""

    def __init__(self, environment: Environment, nodes: Sequence[Node]) -> None:
        self.bounds = _bounds(environment)
        self.samples = Samples(sample_rows(nodes, self.bounds, SAMPLED), nodes)
        self._groups = sorted((environment.offsets[name], s.size) for name, s in environment.signals.items())
        self._left = self._all = ALL_STEPS + STEPS_EACH * len(nodes)
        self._answers: dict[Node, Answer] = {}

    def decide(self, node: Node) -> Answer:
        """Decide whether a scalar boolean expression can be true while all signals are valid."""
        if node not in self._answers:
            self._answers[node] = self._sampled(node) or self._proved(node)
        return self._answers[node]

    def example(self, node: Node) -> Array:
        """Find a snapshot on which an expression is true, to be shown to the user: with few digits if possible.

        Raises:
            LookupError: No example is known; see `decide`.
        """
        found = self.decide(node).example
        if found is None:
            raise LookupError(f"no example of '{node.text}' is known")
        return self._plain(node, found)

    @cached_property
    def _symbols(self) -> Translator:
        from .translator import Translator  # imports z3, which takes 40 ms

        return Translator(self.bounds)

    def _sampled(self, node: Node) -> Answer | None:
        true = self.samples.truth(node)
        return Answer(self.samples.rows[true.argmax()]) if true.any() else None

    def _proved(self, node: Node) -> Answer:
        unknown: tuple[str, ...] = ()
        for steady in (True, False) if node.temporal else (False,):
            steps = max(1, min(STEPS, self._left))  # 0 is no limit
            solution = self._symbols.solve(node, self._free, steps, steady)
            self._left -= solution.steps
            if solution.x is not None:
                if (found := _first(Steady([node]), self._around(solution.x))) is not None:
                    return Answer(found)
            elif not solution.never:
                return Answer(
                    unknown=self._spent(steps) if solution.steps > steps else f"z3 gives up: {solution.reason}"
                )
            elif not steady:
                return Answer()
            unknown = solution.unknown
        texts = ", ".join(repr(text) for text in unknown[:3])
        return Answer(
            unknown=f"only a part of the meaning of {texts} is known"
            if texts
            else "it holds for real numbers, but for none of the rounded numbers that were tried"
        )

    def _around(self, x: Array) -> Array:
        """A solution, and snapshots near it: at the limit of a comparison, rounding decides."""
        size = np.where(np.isfinite(x), np.maximum(1.0, np.abs(x)), 1.0)
        steps = np.repeat([1e-6, 1e-3, 1e-2], 20)[:, None] * np.random.default_rng(0).uniform(-size, size, (60, len(x)))
        return self._inside(np.array([x, *(np.round(x, digits) for digits in (6, 3, 2, 1)), *(x + steps)]))

    def _spent(self, steps: int) -> str:
        if steps < STEPS:
            return f"all questions about the rules together take more than {self._all} steps"
        return f"it takes more than {STEPS} steps"

    @cached_property
    def _free(self) -> Array:
        """Values of signals that an expression leaves free: 1, or a value inside the bounds."""
        return self._inside(np.ones(len(self.bounds)))

    def _inside(self, x: Array) -> Array:
        low, high = np.array(self.bounds, float).reshape(-1, 2).T
        inside: Array = np.clip(x, low, high)
        return inside

    def _plain(self, node: Node, x: Array) -> Array:
        """Replace the values of an example by plainer ones, signal by signal, as long as the expression is true."""
        read = node.reads()
        x = np.where(np.isin(np.arange(len(x)), sorted(read)), x, self._free)
        marks = sorted({float(n.value) for n in node.walk() if n.op == "number" and np.isfinite(n.value)}, key=abs)
        near = [m + step for step in (1.0, -1.0, 0.1, -0.1, 0.01, -0.01, 0.0) for m in marks]
        values = list(dict.fromkeys([1.0, 2.0, 0.5, 0.1, -1.0, *(round(v, 6) for v in near), 0.0]))
        holds = Steady([node])
        for start, size in self._groups:
            indices = [i for i in range(start, start + size) if i in read]
            if not indices:
                continue
            rows = [with_values(x, indices, one) for one in values]
            if len(indices) > 1:  # one value that is different, then all equal, then one after the other
                rows = [rows[0], *(with_values(rows[0], indices[:1], one) for one in values), *rows]
            found = _first(holds, self._allowed(rows))
            if found is not None:
                x = found
                continue
            for i in indices:
                rows = [with_values(x, [i], one) for one in [*values, *(round(x[i], digits) for digits in range(6))]]
                found = _first(holds, self._allowed(rows))
                x = x if found is None else found
        return x

    def _allowed(self, rows: Sequence[Array]) -> Array:
        found = np.array(rows)
        allowed: Array = found[(self._inside(found) == found).all(axis=1)]
        return allowed


def _first(node: Steady, rows: Array) -> Array | None:
    """The first snapshot on which an expression is true."""
    true = node(rows)[0] == 1.0
    return rows[true.argmax()] if true.any() else None


def with_values(x: Array, indices: Sequence[int], value: float) -> Array:
    """Copy of a snapshot with another value at some indices."""
    x = x.copy()
    x[list(indices)] = value
    return x


def conjunction(nodes: Sequence[Node]) -> Node:
    """Expression that is true if all given expressions are."""
    return nodes[0] if len(nodes) == 1 else Node("and", TRUTH, tuple(nodes), text=" and ".join(n.text for n in nodes))


def negation(node: Node) -> Node:
    """Expression that is true if the given one is false."""
    return node.args[0] if node.op == "not" else Node("not", TRUTH, (node,), text=f"not ({node.text})")


def _bounds(environment: Environment) -> list[Range]:
    size = max((environment.offsets[name] + s.size for name, s in environment.signals.items()), default=0)
    bounds = [(-np.inf, np.inf)] * size
    for name, signal in environment.signals.items():
        start = environment.offsets[name]
        bounds[start : start + signal.size] = [signal.bounds] * signal.size
    return bounds


def by_index(environment: Environment) -> Callable[[int], tuple[str, int]]:
    """Function from an index of the snapshot to the name of the signal there and the index within this signal."""
    owners = {
        environment.offsets[name] + i: (name, i)
        for name, signal in environment.signals.items()
        for i in range(signal.size)
    }
    return owners.__getitem__
