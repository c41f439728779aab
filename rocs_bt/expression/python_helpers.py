"""Functions that generated Python code calls: the instructions of a Program on Python values.

An invalid number is NaN, an invalid truth value is None. The state is a list of cells; `program` describes the cells of
each instruction.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..base.geometry import wrap_angle
from .interpreter import hypot as _hypot

Truth = bool | None
Cells = list[float]
_INF, _NAN = math.inf, math.nan


def _divide(a: float, b: float) -> float:
    return a / b if b != 0.0 else _NAN


def _root(a: float) -> float:
    return math.sqrt(a) if a >= 0.0 else _NAN


def _angle(a: float) -> float:
    return _NAN if a in (_INF, -_INF) else wrap_angle(a)


def _length(a: float, b: float) -> float:
    return _NAN if a != a or b != b else _hypot(a, b)


def _sign(a: float) -> float:
    return a if a != a else float((a > 0.0) - (a < 0.0))


def _side(a: float) -> float:
    return a if a != a else 1.0 if a >= 0.0 else -1.0


def _clip(a: float, low: float, high: float) -> float:
    return _NAN if a != a or low != low or high != high else min(max(a, low), high)


def _broken(group: Sequence[float]) -> bool:
    return any([v != v for v in group])  # noqa: C419 - a list is twice as fast


def _least(group: Sequence[float]) -> float:
    return _NAN if _broken(group) else min(group)


def _greatest(group: Sequence[float]) -> float:
    return _NAN if _broken(group) else max(group)


def _argmin(group: Sequence[float]) -> float:
    return _NAN if _broken(group) else float(group.index(min(group)))


def _total(group: Sequence[float]) -> float:
    total = group[0]
    for value in group[1:]:
        total += value
    return total


def _dot(group: Sequence[float], vector: Sequence[float]) -> float:
    return _total([a * b for a, b in zip(group, vector, strict=True)])


def _min_valid(group: Sequence[float], least: float) -> float:
    valid = [v for v in group if v == v]
    return min(valid) if len(valid) >= least else _NAN


def _lt(a: float, b: float) -> Truth:
    return None if a != a or b != b else a < b


def _le(a: float, b: float) -> Truth:
    return None if a != a or b != b else a <= b


def _eq(a: float, b: float) -> Truth:
    return None if a != a or b != b else a == b


def _ne(a: float, b: float) -> Truth:
    return None if a != a or b != b else a != b


def _negate(a: Truth) -> Truth:
    return None if a is None else not a


def _both(a: Truth, b: Truth) -> Truth:
    return False if a is False or b is False else None if a is None or b is None else True


def _either(a: Truth, b: Truth) -> Truth:
    return True if a is True or b is True else None if a is None or b is None else False


def _every(group: Sequence[Truth]) -> Truth:
    return False if False in group else None if None in group else True


def _some(group: Sequence[Truth]) -> Truth:
    return True if True in group else None if None in group else False


def _count(group: Sequence[Truth]) -> float:
    return _NAN if None in group else float(group.count(True))


def _choose_number(test: Truth, then: float, other: float) -> float:
    return _NAN if test is None else then if test else other


def _choose_truth(test: Truth, then: Truth, other: Truth) -> Truth:
    return None if test is None else then if test else other


def _gap(a: float, b: float, scale: float) -> float:
    return _NAN if a != a or b != b else 0.0 if a == b else (b - a) / scale


def _worst(a: float, b: float) -> float:
    if a != a:
        return b if b < 0.0 else _NAN
    if b != b:
        return a if a < 0.0 else _NAN
    return b if b < a else a


def _best(a: float, b: float) -> float:
    return -_worst(-a, -b)


def _worst_of(group: Sequence[float]) -> float:
    worst = group[0]
    for margin in group[1:]:
        worst = _worst(worst, margin)
    return worst


def _best_of(group: Sequence[float]) -> float:
    return -_worst_of([-margin for margin in group])


def _held(cells: Cells, k: int, a: Truth, t: float, window: float) -> Truth:
    if a is False:
        cells[k] = cells[k + 1] = _INF
        return False
    if cells[k] == _INF:
        cells[k] = t
    if a is None:
        cells[k + 1] = _INF
    elif cells[k + 1] == _INF:
        cells[k + 1] = t
    if not t - cells[k] >= window:
        return False
    return True if t - cells[k + 1] >= window else None


def _since(cells: Cells, k: int, a: Truth, b: Truth, t: float, window: float) -> Truth:
    sure, perhaps = cells[k], cells[k + 1]
    sure = t if sure == _INF else sure
    perhaps = t if perhaps == _INF else perhaps
    if b is True:
        sure = perhaps = _INF
    else:
        if a is not True:
            sure = -_INF
        if b is None:
            perhaps = _INF
        elif a is False:
            perhaps = -_INF
    cells[k], cells[k + 1] = sure, perhaps
    if t - sure < window:
        return True
    return None if t - perhaps < window else False


def _ago(cells: Cells, k: int, a: Truth, t: float) -> float:
    if a is None:
        return _NAN
    if a:
        cells[k] = t
    return t - cells[k]


def _drop(cells: Cells, k: int, t: float, window: float, capacity: int) -> None:
    head, count = int(cells[k]), int(cells[k + 1])
    while count >= 2 and t - cells[k + 2 + 2 * ((head + 1) % capacity)] >= window:
        head, count = (head + 1) % capacity, count - 1
    cells[k], cells[k + 1] = float(head), float(count)


def _push(
    cells: Cells, k: int, t: float, value: float, grain: float, capacity: int, join: Callable[[float, float], float]
) -> None:
    head, count = int(cells[k]), int(cells[k + 1])
    newest = k + 2 + 2 * ((head + count - 1) % capacity)
    if count and t - cells[newest] < grain:
        cells[newest + 1] = join(cells[newest + 1], value)
        return
    at = k + 2 + 2 * ((head + count) % capacity)
    cells[at], cells[at + 1], cells[k + 1] = t, value, float(count + 1)


def _pairs(cells: Cells, k: int, capacity: int) -> list[int]:
    """Indices in `cells` of the values in a ring buffer, the oldest first."""
    head, count = int(cells[k]), int(cells[k + 1])
    return [k + 3 + 2 * ((head + i) % capacity) for i in range(count)]


def _first(old: float, new: float) -> float:
    return old


def _then(
    cells: Cells, k: int, value: float, t: float, window: float, grain: float, capacity: int
) -> tuple[float, float]:
    """Push a sample to a ring buffer; return time and value of the oldest pair, or NaN if the window is not covered."""
    _drop(cells, k, t, window, capacity)
    _push(cells, k, t, value, grain, capacity, _first)
    at = k + 2 + 2 * int(cells[k])
    return (cells[at], cells[at + 1]) if t - cells[at] >= window else (_NAN, _NAN)


def _delay(cells: Cells, k: int, a: float, t: float, window: float, grain: float, capacity: int) -> float:
    return _then(cells, k, a, t, window, grain, capacity)[1]


def _delay_truth(cells: Cells, k: int, a: Truth, t: float, window: float, grain: float, capacity: int) -> Truth:
    then = _then(cells, k, _NAN if a is None else float(a), t, window, grain, capacity)[1]
    return None if then != then else bool(then)


def _rate(cells: Cells, k: int, a: float, t: float, window: float, grain: float, capacity: int) -> float:
    began, then = _then(cells, k, a, t, window, grain, capacity)
    return (a - then) / (t - began) if began == began else _NAN


def _lowest(
    cells: Cells, k: int, a: float, t: float, window: float, grain: float, before: float, capacity: int
) -> float:
    _drop(cells, k, t, window, capacity)
    _push(cells, k, t, a, grain, capacity, _worst)
    margins = [cells[at] for at in _pairs(cells, k, capacity)]
    covered = t - cells[k + 2 + 2 * int(cells[k])] >= window
    return _worst_of(margins if covered else [before, *margins])


def _since_margin(
    cells: Cells, k: int, a: float, b: float, t: float, window: float, grain: float, capacity: int
) -> float:
    _drop(cells, k, t, window, capacity)
    for at in _pairs(cells, k, capacity):
        cells[at] = _worst(cells[at], a)
    _push(cells, k, t, b, grain, capacity, _best)
    return _best_of([-_INF, *(cells[at] for at in _pairs(cells, k, capacity))])


HELPERS: Mapping[str, Any] = {
    "__builtins__": {}, "abs": abs, "argmin": _argmin, "ago": _ago, "angle": _angle, "any": any, "atan2": math.atan2,
    "all": all, "best": _best, "best_of": _best_of, "both": _both, "choose_number": _choose_number,
    "choose_truth": _choose_truth, "clip": _clip, "count": _count, "delay": _delay, "delay_truth": _delay_truth,
    "divide": _divide, "dot": _dot, "either": _either, "eq": _eq, "every": _every, "float": float, "gap": _gap,
    "greatest": _greatest, "held": _held, "inf": _INF, "le": _le, "least": _least, "length": _length,
    "lowest": _lowest, "lt": _lt, "max": max, "min": min, "min_valid": _min_valid, "nan": _NAN, "ne": _ne,
    "negate": _negate, "rate": _rate, "root": _root, "side": _side, "sign": _sign, "since": _since,
    "since_margin": _since_margin, "some": _some, "sum": sum, "total": _total, "worst": _worst,
    "worst_of": _worst_of, "zip": zip,
}  # fmt: skip  # a table
