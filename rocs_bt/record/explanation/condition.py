"""Condition over a run: the sides of its comparisons, how near it is to being true, and what has to change for that."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...expression import Node, Values

Numbers = NDArray[np.float64]
Wanted = NDArray[Any]

_ALMOST = 0.999  # the most of what is not true
_MINOR = 1e-3  # part of a distance in the cost of a change; the number of changes comes first
_SIGNS = {"<": np.less, "<=": np.less_equal, ">": np.greater, ">=": np.greater_equal, "==": np.equal}


def parts_of(node: Node) -> Iterator[Node]:
    """Parts of a condition that are true or false by their values, as written from left to right.

    These are comparisons of two sides each, `held` and `once` behind what they are about, and everything that is not
    joined by `and`, `or`, `not`, `if`, `any` and `all`.
    """
    if node.op == "compare":
        yield from node.pairs
    elif node.op != "truth":
        if _joins(node):
            for arg in node.args:
                yield from parts_of(arg)
        if not _joins(node) or node.op in ("held", "once"):
            yield node


def unit_of(part: Node) -> str:
    """Unit of both sides of a part; may be empty."""
    if part.op != "compare":
        return "s" if part.op in ("held", "once") else ""
    unit = str(part.args[0].kind.dimension or "")
    return "" if unit == "1" else unit


def _joins(node: Node) -> bool:
    if node.op in ("any", "all"):
        return node.args[0].op == "compare" or not node.args[0].kind.size
    return node.op in ("and", "or", "not", "held", "once", "since") or (node.op == "if" and not node.kind.size)


class Found(NamedTuple):
    """Condition at n times.

    Attributes:
        rows: Left side, right side and truth (1, 0 or NaN) of each part, shape (n, 3); of a group those that decide.
        truth: Truth of the condition, shape (n,).
        near: Nearness to being true, shape (n,): 1 where the condition is true, and only there.
        needs: 1 for a part that has to become true so that the condition does, -1 for one that has to become false,
            else 0; the fewest. Shape (n, parts).
    """

    rows: list[Numbers]
    truth: Numbers
    near: Numbers
    needs: Wanted


class Condition:
    """Evaluates a condition on one sample after the other.

    Args:
        node: Typed tree of the condition; not of a requirement that refers to later samples.

    Attributes:
        parts: Parts of the condition; see `parts_of`.
    """

    def __init__(self, node: Node) -> None:
        self.parts = list(parts_of(node))
        self._node = node
        # Begin of the present run of what each `held` is about, or of what each `once` lacks [s].
        self._runs = [-math.inf if part.op == "once" else math.nan for part in self.parts]
        self._computed = [n for n in _computed(node) if n.op != "read"]
        self._values = Values(self._computed)

    def __call__(self, t: Sequence[float], x: Numbers) -> Found:
        """Evaluate the condition.

        Args:
            t: Times of the samples, at least one, after those of the last call [s].
            x: Samples of all signals, SI units, shape (n, size).
        """
        times = np.array(t, float)
        found = zip(self._computed, self._values(x, times), strict=True)
        values = {id(node): series for node, series in found}
        reader, truth = _Reader(times, x, values, self._runs), values[id(self._node)]
        whole = reader.read(self._node)
        whole.need(np.where((truth == 1.0) | np.isinf(whole.yes), 0, 1))
        near = np.where(truth == 1.0, 1.0, np.minimum(whole.score, _ALMOST))
        needs = [part.needs for part in reader.parts] or [np.zeros(len(t), np.int8)]
        return Found([part.row for part in reader.parts], truth, near, np.stack(needs, axis=1))


def run_starts(on: NDArray[np.bool_], t: Numbers, before: float) -> Numbers:
    """Begin of the run of true values that each time is in; NaN where the value is false.

    Args:
        on: Values at the times.
        t: Times [s].
        before: Begin of the run that goes on before the first time; NaN if none does.
    """
    begins = on & ~np.concatenate([[not math.isnan(before)], on[:-1]])
    at = np.maximum.accumulate(np.where(begins, np.arange(len(t)), -1))
    return np.where(on, np.where(at >= 0, t[at], before), np.nan)


def _computed(node: Node) -> Iterator[Node]:
    """What is evaluated of a condition: its whole, sides of comparisons, and the truth of other parts."""
    yield node
    if node.op == "compare":
        yield from node.args
    elif _joins(node):
        for arg in node.args:
            yield from _computed(arg) if not arg.kind.size else arg.args


class _Value:
    """Condition, or part of one, at n times; its arrays have the shape (n,), or (n, k) for a group.

    Attributes:
        score: Below 1 where it is false, the nearer to true the greater; above 1 where it is true.
        yes: Cost of making it true: the number of parts that have to change, and a little for their distances.
        no: Cost of making it false.
    """

    score: Numbers
    yes: Numbers
    no: Numbers

    def need(self, wanted: Wanted) -> None:
        """Mark the parts that have to change so that it becomes true (1) or false (-1); 0 where it may stay."""


class _Fixed(_Value):
    """What no part can change now, such as `True`, or the past."""

    def __init__(self, truth: Numbers) -> None:
        self.score = np.where(truth == 1.0, 2.0, 0.0)
        self.yes, self.no = (np.where(truth == wanted, 0.0, math.inf) for wanted in (1.0, 0.0))


class _Part(_Value):
    """Part with a left side, a right side and a truth.

    Attributes:
        row: Left side, right side and truth, shape (n, 3); of a group those of the value that decides.
        needs: See `Found.needs`, shape (n,).
    """

    def __init__(self, left: Numbers, right: Numbers, truth: Numbers) -> None:
        sides = np.broadcast_arrays(left, right, truth)
        self._sides: Numbers = np.stack(sides, axis=-1)
        with np.errstate(invalid="ignore", divide="ignore"):
            far = np.abs(left - right) / np.maximum(np.abs(left), np.abs(right))
        self._far = np.where(left == right, 0.0, np.where(np.isfinite(far), np.minimum(far, 1.0), 1.0))
        score = np.where(truth == 1.0, 1.0 + np.maximum(self._far, _MINOR), np.minimum(1.0 - self._far, _ALMOST))
        self.score = np.where(np.isnan(truth), np.nan, score)
        cost = 1.0 + _MINOR * self._far
        self.yes, self.no = np.where(truth == 1.0, 0.0, cost), np.where(truth == 0.0, 0.0, cost)
        self._marks = np.zeros(self.yes.shape, np.int8)
        self.row = self._sides

    @property
    def needs(self) -> Wanted:
        return self._marks if self._marks.ndim == 1 else np.sign(self._marks.sum(axis=1)).astype(np.int8)

    def need(self, wanted: Wanted) -> None:
        self._marks += np.where(wanted > 0, self.yes > 0.0, np.where((wanted < 0) & (self.no > 0.0), -1, 0))

    def decide(self, chosen: NDArray[np.intp]) -> None:
        """Show one value of a group: the farthest of those that have to change; if there is none, the chosen ones."""
        marked = self._marks != 0
        at = np.where(marked.any(axis=1), np.where(marked, self._far, -1.0).argmax(axis=1), chosen)
        self.row = self._sides[np.arange(len(at)), at]


class _Not(_Value):
    """What is true where its part is false."""

    def __init__(self, value: _Value) -> None:
        self._value = value
        self.score, self.yes, self.no = 2.0 - value.score, value.no, value.yes

    def need(self, wanted: Wanted) -> None:
        self._value.need(-wanted)


class _All(_Value):
    """What is true where all of its parts are."""

    def __init__(self, values: Sequence[_Value]) -> None:
        self._values = values
        self.score = np.fmin.reduce([value.score for value in values])
        self.yes = np.sum([value.yes for value in values], axis=0)
        self.no = np.min([value.no for value in values], axis=0)

    def need(self, wanted: Wanted) -> None:
        cheapest = np.argmin([value.no for value in self._values], axis=0)
        for i, value in enumerate(self._values):
            value.need(np.where((wanted < 0) & (cheapest != i), 0, wanted))


def _any(values: Sequence[_Value]) -> _Value:
    return _Not(_All([_Not(value) for value in values]))


class _Group(_Value):
    """Comparison of a group with all of its values, or with any (`some`)."""

    def __init__(self, pairs: Sequence[_Part], *, some: bool) -> None:
        self._pairs, self._some, self._each = pairs, some, _All(pairs)
        each, up, down = self._each, np.max, np.min
        self.score = (np.fmax if some else np.fmin).reduce(each.score, axis=1)
        self.yes, self.no = (down(each.yes, axis=1), up(each.no, axis=1))
        if not some:
            self.yes, self.no = (up(each.yes, axis=1), down(each.no, axis=1))

    def need(self, wanted: Wanted) -> None:
        each, one = self._each, (wanted > 0) == self._some
        cheapest = (each.yes if self._some else each.no).argmin(axis=1)
        others = np.arange(each.score.shape[1]) != cheapest[:, None]
        each.need(np.where(one[:, None] & others, 0, wanted[:, None]))
        nearest = np.nan_to_num(each.score, nan=-1.0).argmax(axis=1)
        for pair in self._pairs:
            pair.decide(nearest if self._some else np.nan_to_num(pair.score, nan=3.0).argmin(axis=1))


class _Choice(_Value):
    """`then if test else other`."""

    def __init__(self, test: _Value, then: _Value, other: _Value) -> None:
        self._true = _any([_All([test, then]), _All([_Not(test), other])])
        self._false = _any([_All([test, _Not(then)]), _All([_Not(test), _Not(other)])])
        self.score, self.yes, self.no = self._true.score, self._true.yes, self._false.yes

    def need(self, wanted: Wanted) -> None:
        self._true.need(np.maximum(wanted, 0))
        self._false.need(np.maximum(-wanted, 0))


class _Reader:
    """Reads a condition at n times; `parts` holds its parts, in the order of `parts_of`."""

    def __init__(self, t: Numbers, x: Numbers, values: Mapping[int, Numbers], runs: list[float]) -> None:
        self._t, self._x, self._values, self._runs = t, x, values, runs
        self.parts: list[_Part] = []

    def read(self, node: Node) -> _Value:
        if node.op == "truth":
            return _Fixed(np.full(len(self._t), float(node.value)))
        if node.op == "compare":
            pairs = self._pairs(node)
            return _All(pairs) if len(pairs) > 1 else pairs[0]
        if not _joins(node):
            return self._part(np.full(len(self._t), np.nan), np.array(np.nan), self._values[id(node)])
        if node.op in ("any", "all") and node.args[0].kind.size:
            return _Group(self._pairs(node.args[0]), some=node.op == "any")
        args = [self.read(arg) for arg in node.args]
        match node.op:
            case "not":
                return _Not(args[0])
            case "and":
                return _All(args)
            case "or":
                return _any(args)
            case "if":
                return _Choice(*args)
            case "held" | "once":
                return self._timed(node, args[0])
            case "since":  # only the past can make it true without its second part
                return _any([args[1], _All([args[0], _Fixed(self._values[id(node)])])])
        return args[0]

    def _pairs(self, node: Node) -> list[_Part]:
        found = []
        for pair in node.pairs:
            left, right = (self._side(side, node.kind.size) for side in pair.args)
            truth = _SIGNS.get(pair.signs[0], np.not_equal)(left, right).astype(float)
            found.append(self._part(left, right, np.where(np.isnan(left) | np.isnan(right), np.nan, truth)))
        return found

    def _side(self, node: Node, wide: int) -> Numbers:
        if node.op != "read":
            found = self._values[id(node)]
        else:
            found = self._x[:, node.start : node.stop] if node.kind.size else self._x[:, node.start]
        return np.broadcast_to(found[:, None], (len(found), wide)) if wide and not node.kind.size else found

    def _timed(self, node: Node, about: _Value) -> _Value:
        """A part that is true after its time: the time since which something holds, or does not, and this time."""
        held, truth = node.op == "held", self._values[id(node)]
        on = self._values[id(node.args[0])] == 1.0
        starts = run_starts(on if held else ~on, self._t, self._runs[len(self.parts)])
        self._runs[len(self.parts)] = float(starts[-1])
        part = self._part(np.nan_to_num(self._t - starts, nan=0.0), np.full(len(self._t), node.value), truth)
        past = _Fixed(truth)
        if held:
            part.no = past.no
            return _All([about, part])
        part.yes = past.yes
        return _any([about, part])

    def _part(self, left: Numbers, right: Numbers, truth: Numbers) -> _Part:
        self.parts.append(_Part(left, right, truth))
        return self.parts[-1]
