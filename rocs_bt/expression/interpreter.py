"""What expressions mean, as plainly as it can be told: the reference that all else is tested against.

A trace keeps every snapshot; a temporal operation looks back over all of them. None is *invalid*, for numbers and for
truth values; a number that is NaN is invalid. Truth is three-valued (Kleene): `False and invalid` is False. How windows
and margins are meant is told in `program`. Sources: O. Maler, D. Nickovic, "Monitoring Temporal Properties of
Continuous Signals" (2004), for the temporal operations over signals that stand from one sample to the next; A. Donze,
O. Maler, "Robust Satisfaction of Temporal Logic over Real-Valued Signals" (2010), for margins; J. Deshmukh et al.,
"Robust Online Monitoring of Signal Temporal Logic" (2015), for what a margin is while parts of it are not known.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..geometry import wrap_angle
from .lower import margin_scale, mixed_units
from .node import Node
from .program import TOLERANCE, ring_shape

Value = Any  # a float, a bool, None, or a list of such
_SIGNS: Mapping[str, Callable[[Any, Any], bool]] = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq, "!=": operator.ne,
}  # fmt: skip


def evaluate(node: Node, x: Sequence[float], t: float = 0.0) -> float | bool | None:
    """The value of an expression of a single value, of a first snapshot; None where it is invalid.

    Args:
        node: From `parse`.
        x: The snapshot, all signals one after the other.
        t: Its time [s].
    """
    trace = Trace()
    trace.append(x, t)
    value: float | bool | None = trace.value(node)
    if isinstance(value, list):
        raise TypeError(f"'{node.text}' gives {node.kind.words}, not a single value")
    return value


class Trace:
    """The snapshots so far, and what expressions make of them."""

    def __init__(self) -> None:
        self._forget()

    def _forget(self) -> None:
        self._times: list[float] = []
        self._rows: list[Sequence[float]] = []
        self._memo: dict[tuple[int, int, bool | None], Value] = {}
        self._kept: dict[int, Node] = {}

    def append(self, x: Sequence[float], t: float) -> None:
        """A new snapshot, at a time [s]; one before the last one's forgets them all."""
        if self._times and t < self._times[-1]:
            self._forget()
        self._times.append(t)
        self._rows.append(x)

    def value(self, node: Node, i: int = -1) -> Value:
        """The value at the i-th snapshot; None where it is invalid."""
        return self._remembered(node, i % len(self._times), None)

    def margin(self, node: Node, i: int = -1) -> float | None:
        """How far a single truth value is from changing; None where that is not known."""
        margin: float | None = self._remembered(node, i % len(self._times), mixed_units(node))
        return margin

    def _remembered(self, node: Node, i: int, mixed: bool | None) -> Value:
        key = (id(node), i, mixed)
        if key not in self._memo:
            self._kept[id(node)] = node  # or its id could be another's
            self._memo[key] = _known(self._value(node, i) if mixed is None else self._margin(node, i, mixed))
        return self._memo[key]

    def _value(self, node: Node, i: int) -> Value:
        match node.op:
            case "number" | "truth":
                return node.value
            case "vector":
                return [arg.value for arg in node.args]
            case "read":
                return list(self._rows[i][node.start : node.stop]) if node.kind.size else self._rows[i][node.start]
            case "held":
                return self._held(node.args[0], i, node.value)
            case "once":
                return _any([self.value(node.args[0], j) for j in self._window(i, node.value)])
            case "since":
                return self._since(node, i)
            case "time_since":
                return self._time_since(node.args[0], i)
            case "delay" | "rate":
                return self._back(node, i)
        values = [self.value(arg, i) for arg in node.args]
        if node.kind.size:
            rows = [[v[k] if isinstance(v, list) else v for v in values] for k in range(node.kind.size)]
            return [_known(_single(node, row)) for row in rows]
        return _single(node, values)

    def _window(self, i: int, length: float) -> list[int]:
        """The samples that stood at any time of a window that ends at sample i."""
        t, limit = self._times, length - TOLERANCE
        return [j for j in range(i + 1) if j == i or t[i] - t[j + 1] < limit]

    def _covered(self, i: int, length: float) -> bool:
        return self._times[i] - self._times[0] >= length - TOLERANCE

    def _held(self, arg: Node, i: int, length: float) -> bool | None:
        if not self._covered(i, length):
            return False
        return _all([self.value(arg, j) for j in self._window(i, length)])

    def _since(self, node: Node, i: int) -> bool | None:
        a, b = node.args
        return _any(
            [
                _all([self.value(b, j), *(self.value(a, k) for k in range(j + 1, i + 1))])
                for j in self._window(i, node.value)
            ]
        )

    def _time_since(self, arg: Node, i: int) -> float | None:
        if self.value(arg, i) is None:
            return None
        held = [self._times[j] for j in range(i + 1) if self.value(arg, j)]
        return self._times[i] - held[-1] if held else math.inf

    def _pairs(self, i: int, length: float) -> list[list[int]]:
        """The samples up to i, in the groups that a ring of that window does not tell apart."""
        width, _ = ring_shape(length)
        groups: list[list[int]] = []
        for j in range(i + 1):
            if groups and self._times[j] - self._times[groups[-1][0]] < width - TOLERANCE:
                groups[-1].append(j)
            else:
                groups.append([j])
        return groups

    def _pairs_of_window(self, i: int, length: float) -> list[list[int]]:
        groups = self._pairs(i, length)
        ends = [self._times[group[0]] for group in groups[1:]]
        limit = length - TOLERANCE
        return [g for g, end in zip(groups, [*ends, math.inf], strict=True) if self._times[i] - end < limit]

    def _back(self, node: Node, i: int) -> Value:
        """`delay`: what was when the window began; `rate`: the change since, by the time since."""
        j = self._pairs_of_window(i, node.value)[0][0]
        if self._times[i] - self._times[j] < node.value - TOLERANCE:
            return None
        then = self.value(node.args[0], j)
        if node.op == "delay":
            return then
        now = self.value(node.args[0], i)
        return None if now is None or then is None else (now - then) / (self._times[i] - self._times[j])

    def _margin(self, node: Node, i: int, mixed: bool) -> Value:
        def of(arg: Node, j: int = i) -> Value:
            return self._remembered(arg, j, mixed)

        match node.op:
            case "truth":
                return math.inf if node.value else -math.inf
            case "not":
                return _negative(of(node.args[0]))
            case "and":
                return _worst([of(arg) for arg in node.args])
            case "or":
                return _best([of(arg) for arg in node.args])
            case "if":
                return self._margin_of_choice(node, i, of)
            case "any" | "all":
                group = of(node.args[0])
                fold = _best if node.op == "any" else _worst
                return fold(group if isinstance(group, list) else [group])
            case "held" | "once":
                return self._margin_of_window(node, i, of)
            case "since":
                return self._margin_of_since(node, i, of)
            case "delay":
                j = self._pairs_of_window(i, node.value)[0][0]
                return of(node.args[0], j) if self._times[i] - self._times[j] >= node.value - TOLERANCE else None
        return self._gaps(node, i, margin_scale(node) if mixed else 1.0)

    def _margin_of_choice(self, node: Node, i: int, of: Callable[..., Value]) -> Value:
        test, then, other = (of(arg) for arg in node.args)
        if self.value(node.args[0], i) is None:  # the value is invalid, whatever the branches are
            return [None] * node.kind.size if node.kind.size else None
        if not node.kind.size:
            return _best([_worst([test, then]), _worst([_negative(test), other])])
        pairs = zip(then, other, strict=True)
        return [_best([_worst([test, a]), _worst([_negative(test), b])]) for a, b in pairs]

    def _margin_of_window(self, node: Node, i: int, of: Callable[..., Value]) -> Value:
        (arg,) = node.args
        found = [of(arg, j) for group in self._pairs_of_window(i, node.value) for j in group]
        if node.op == "held":
            return _worst(found if self._covered(i, node.value) else [-math.inf, *found])
        return _best(found if self._covered(i, node.value) else [-math.inf, *found])

    def _margin_of_since(self, node: Node, i: int, of: Callable[..., Value]) -> Value:
        a, b = node.args
        found = []
        for group in self._pairs_of_window(i, node.value):
            best = of(b, group[0])
            for j in group[1:]:
                best = _best([_worst([best, of(a, j)]), of(b, j)])
            found.append(_worst([best, *(of(a, k) for k in range(group[-1] + 1, i + 1))]))
        return _best(found)

    def _gaps(self, node: Node, i: int, scale: float) -> Value:
        values = [self.value(arg, i) for arg in node.args]
        if not node.kind.size:
            return _gap_of_chain(node.signs, values, scale)
        rows = [[v[k] if isinstance(v, list) else v for v in values] for k in range(node.kind.size)]
        return [_gap_of_chain(node.signs, row, scale) for row in rows]


def _known(value: Value) -> Value:
    """None for what is not a number."""
    if isinstance(value, list):
        return [_known(v) for v in value]
    return None if isinstance(value, float) and math.isnan(value) else value


def _all(values: Sequence[bool | None]) -> bool | None:
    if any(value is False for value in values):
        return False
    return None if None in values else True


def _any(values: Sequence[bool | None]) -> bool | None:
    if any(value is True for value in values):
        return True
    return None if None in values else False


def _worst(margins: Sequence[float | None]) -> float | None:
    known = [m for m in margins if m is not None]
    least = min(known, default=math.inf)
    return least if len(known) == len(margins) or least < 0.0 else None


def _best(margins: Sequence[float | None]) -> float | None:
    best: float | None = _negative(_worst([_negative(m) for m in margins]))
    return best


def _negative(value: Value) -> Value:
    if isinstance(value, list):
        return [_negative(v) for v in value]
    return None if value is None else -value


def _gap_of_chain(signs: Sequence[str], values: Sequence[float | None], scale: float) -> float | None:
    return _worst([_gap(sign, a, b, scale) for sign, a, b in zip(signs, values, values[1:], strict=False)])


def _gap(sign: str, a: float | None, b: float | None, scale: float) -> float | None:
    """How far a comparison is from changing."""
    if a is None or b is None:
        return None
    if a == b:
        return 0.0
    if sign in ("<", "<="):
        return (b - a) / scale
    if sign in (">", ">="):
        return (a - b) / scale
    return -abs(b - a) / scale if sign == "==" else abs(b - a) / scale


def _single(node: Node, values: Sequence[Value]) -> Value:
    """One operation on values; groups have been taken apart, but for the functions that reduce them."""
    match node.op:
        case "and":
            return _all(values)
        case "or":
            return _any(values)
        case "if":
            return None if values[0] is None else values[1] if values[0] else values[2]
        case "compare":
            triples = zip(node.signs, values, values[1:], strict=False)
            return _all([None if a is None or b is None else _SIGNS[sign](a, b) for sign, a, b in triples])
        case "any":
            return _any(_flat(values[0]))
        case "all":
            return _all(_flat(values[0]))
        case "min_valid":
            valid = [v for v in _flat(values[0]) if v is not None]
            return min(valid) if len(valid) >= values[1] else None
    if any(v is None for v in _flat(*values)):
        return None
    return _OPERATIONS[node.op](*values)


def _flat(*values: Value) -> list[Any]:
    return [v for value in values for v in (value if isinstance(value, list) else [value])]


def _sum(values: Sequence[float]) -> float:
    """From the first to the last; Python's own sum is more exact, but not the same everywhere."""
    total = values[0]
    for value in values[1:]:
        total += value
    return total


def hypot(a: float, b: float) -> float:
    """The C library's: Python's own differs from it in the last digit."""
    try:
        return abs(complex(a, b))
    except OverflowError:
        return math.inf


def _angle(a: float) -> float:
    return math.nan if math.isinf(a) else wrap_angle(a)


_OPERATIONS: Mapping[str, Callable[..., float | bool]] = {
    "neg": lambda a: -a,
    "not": lambda a: not a,
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b if b != 0.0 else math.nan,
    "min": lambda *groups: min(_flat(*groups)),
    "max": lambda *groups: max(_flat(*groups)),
    "argmin": lambda group: float(_flat(group).index(min(_flat(group)))),
    "sum": lambda group: _sum(_flat(group)),
    "mean": lambda group: _sum(_flat(group)) / len(_flat(group)),
    "dot": lambda group, vector: _sum([a * b for a, b in zip(_flat(group), vector, strict=True)]),
    "count": lambda group: float(sum(_flat(group))),
    "abs": lambda a: abs(a),
    "clip": lambda a, low, high: min(max(a, low), high),
    "hypot": hypot,
    "atan2": math.atan2,
    "sign": lambda a: float((a > 0.0) - (a < 0.0)),
    "side": lambda a: 1.0 if a >= 0.0 else -1.0,
    "sqrt": lambda a: math.sqrt(a) if a >= 0.0 else math.nan,
    "wrap_angle": _angle,
}
