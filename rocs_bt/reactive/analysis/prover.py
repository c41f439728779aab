"""Answers one kind of question: can this expression be true?

An answer is an example that the interpreter confirms, a proof that there is none, or why neither was found.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ...expression import Environment, Node, compile_node, evaluate
from .formula import Effort, Undecided
from .interval import Range
from .sample import Array, Samples, draw_rows
from .simplex import Span
from .solve import Solution, Solver
from .translate import Translator, unknown_texts

DRAWN = 400  # snapshots tried before anything is proved
STEPS = 100_000  # of one question, see Effort
ALL_STEPS = 400_000  # of all questions about one rule set, ...
STEPS_EACH = 1000  # ... and for each of its expressions


@dataclass(frozen=True)
class Answer:
    """Whether an expression can be true.

    Attributes:
        example: A snapshot, (size,), where it is; None where there is none, or none was found.
        unknown: Why it cannot be decided; empty where it is.
    """

    example: Array | None = None
    unknown: str = ""

    @property
    def never(self) -> bool:
        """Whether it is proved that it is never true."""
        return self.example is None and not self.unknown


class Prover:
    """Answers questions about expressions over a robot's signals.

    Args:
        environment: The signals, with their bounds.
        nodes: The expressions that questions will be made of.
    """

    def __init__(self, environment: Environment, nodes: Sequence[Node]) -> None:
        self.bounds = _bounds(environment)
        self.samples = Samples(draw_rows(nodes, self.bounds, DRAWN))
        self._effort = Effort(STEPS, ALL_STEPS + STEPS_EACH * len(nodes))
        self._translator = Translator(len(self.bounds), self._range, self._effort)
        self._calm = np.array([_calm(bounds) for bounds in self.bounds])
        self._answers: dict[Node, Answer] = {}

    def ask(self, node: Node) -> Answer:
        """Whether a single truth value can be true while all signals are valid."""
        if node not in self._answers:
            self._answers[node] = self._drawn(node) or self._proved(node)
        return self._answers[node]

    def example(self, node: Node) -> Array:
        """An example for people: with few digits where there is one.

        Raises:
            LookupError: None is known; `ask` tells before.
        """
        proved = self._proved(node).example
        found = proved if proved is not None else self.ask(node).example
        if found is None:
            raise LookupError(f"no example of '{node.text}' is known")
        return found

    def confirmed(self, node: Node, x: Array) -> bool:
        """Whether an expression is true on a snapshot that has stood for a while."""
        row = x.tolist()
        if not node.temporal:
            return evaluate(node, row) is True
        expression = compile_node(node)
        expression(row, 0.0)
        return expression(row, 1.0 + 2.0 * sum(n.value for n in node.walk() if n.temporal)) is True

    def _range(self, index: int) -> Range:
        return self.bounds[index]

    def _drawn(self, node: Node) -> Answer | None:
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
        """A snapshot of a solution that the interpreter confirms; what it leaves open may be tried out."""
        x = self._calm.copy()
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
            return f"of {', '.join(repr(text) for text in texts[:3])} only the range is known"
        return "the numbers are too close to each other"


def _calm(bounds: Range) -> float:
    """A value for a signal that has no say."""
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
    """Which signal an index of the snapshot belongs to, and its place in it."""
    owners = {
        environment.offsets[name] + i: (name, i)
        for name, signal in environment.signals.items()
        for i in range(signal.size)
    }
    return owners.__getitem__
