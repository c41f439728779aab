"""Prover that decides whether an expression can be true for any values of the signals.

The answer is an example that the interpreter confirms, a proof that no example exists, or the reason why neither was
found.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ...expression import Environment, Node, compile_node, evaluate
from .formula import Effort, Undecided
from .interval import Range
from .sample import Array, Samples, sample_rows
from .simplex import Span
from .solve import Solution, Solver
from .translate import Translator, unknown_texts

SAMPLED = 400  # number of sampled snapshots that are tried before a proof
STEPS = 100_000  # solver steps for one question, see Effort
ALL_STEPS = 400_000  # solver steps for all questions about one rule set, ...
STEPS_EACH = 1000  # ... and in addition for each of its expressions


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
        self.samples = Samples(sample_rows(nodes, self.bounds, SAMPLED))
        self._effort = Effort(STEPS, ALL_STEPS + STEPS_EACH * len(nodes))
        self._translator = Translator(len(self.bounds), self._range, self._effort)
        self._defaults = np.array([_default(bounds) for bounds in self.bounds])
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
        proved = self._proved(node).example
        found = proved if proved is not None else self.decide(node).example
        if found is None:
            raise LookupError(f"no example of '{node.text}' is known")
        return found

    def confirmed(self, node: Node, x: Array) -> bool:
        """Whether the interpreter evaluates an expression as true on a snapshot.

        A temporal expression is evaluated after the snapshot has been constant for longer than its time windows.
        """
        row = x.tolist()
        if not node.temporal:
            return evaluate(node, row) is True
        expression = compile_node(node)
        expression(row, 0.0)
        return expression(row, 1.0 + 2.0 * sum(n.value for n in node.walk() if n.temporal)) is True

    def _range(self, index: int) -> Range:
        return self.bounds[index]

    def _sampled(self, node: Node) -> Answer | None:
        (found,) = np.nonzero(self.samples.truth(node))
        for i in found[:3]:
            if self.confirmed(node, self.samples.rows[i]):
                return Answer(self.samples.rows[i])
        return None

    def _proved(self, node: Node) -> Answer:
        self._effort.begin()
        try:
            solution = Solver(self._translator.range, self._effort).solve(self._translator.formula(node))
        except Undecided as reason:
            return Answer(unknown=self._reason(str(reason)))
        if solution is None:
            return Answer()
        example = self._example(node, solution)
        return Answer(example) if example is not None else Answer(unknown=self._reason(""))

    def _example(self, node: Node, solution: Solution) -> Array | None:
        """Complete a solution to a snapshot on which the interpreter confirms the expression; None if none is found.

        Signals that the solution leaves free get default values, or those of the sampled snapshots in turn.
        """
        x = self._defaults.copy()
        wanted = {var: value for var in solution.spans if var < len(x) and (value := solution.value(var)) is not None}
        wanted.update({var: float(value) for var, value in solution.values.items() if var < len(x)})
        for var, value in wanted.items():
            x[var] = value
        if self.confirmed(node, x):
            return x
        free = np.isin(np.arange(len(x)), sorted(node.reads() - wanted.keys()))
        rows = np.where(free, self.samples.rows, x)
        (found,) = np.nonzero(Samples(rows).truth(node))
        return next((rows[i] for i in found[:3] if self.confirmed(node, rows[i])), None)

    def _reason(self, why: str) -> str:
        if why:
            return why
        if reasons := list(self._translator.reasons):
            return "; ".join(reasons[:2])
        texts = unknown_texts(self._translator.unknown)
        if texts:
            return f"only the range of {', '.join(repr(text) for text in texts[:3])} is known"
        return "the numbers are too close to each other"


def _default(bounds: Range) -> float:
    """Default of a signal that the solution leaves free: 0, or a value inside the bounds if 0 is not inside them."""
    low, high = bounds
    return float(Span.of(low, high).pick()) if low > 0.0 or high < 0.0 or low == 0.0 else 0.0


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
