"""Temporal instructions, one sample after the other; `program` defines their cells.

Each function has the arguments `cells`, the instruction's own part of the state, which it updates; `t`, the time of the
sample [s]; `k`, the four constants window, grain, before and capacity; and the operands. Truth values are 1.0 and 0.0,
and NaN is invalid.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

_INF, _NAN = math.inf, math.nan
Cells = list[float]


def held(cells: Cells, t: float, k: Sequence[float], a: float) -> float:
    """The instruction HELD."""
    if a == 0.0:
        cells[:] = _INF, _INF
        return 0.0
    if cells[0] == _INF:
        cells[0] = t
    if a != a:
        cells[1] = _INF
    elif cells[1] == _INF:
        cells[1] = t
    if not t - cells[0] >= k[0]:
        return 0.0
    return 1.0 if t - cells[1] >= k[0] else _NAN


def since(cells: Cells, t: float, k: Sequence[float], a: float, b: float) -> float:
    """The instruction SINCE."""
    sure, perhaps = (t if cell == _INF else cell for cell in cells)
    if b == 1.0:
        sure = perhaps = _INF
    else:
        if a != 1.0:
            sure = -_INF
        if b != b:
            perhaps = _INF
        elif a == 0.0:
            perhaps = -_INF
    cells[:] = sure, perhaps
    if t - sure < k[0]:
        return 1.0
    return _NAN if t - perhaps < k[0] else 0.0


def time_since(cells: Cells, t: float, k: Sequence[float], a: float) -> float:
    """The instruction TIME_SINCE."""
    if a == 1.0:
        cells[0] = t
    return _NAN if a != a else t - cells[0]


def rate(cells: Cells, t: float, k: Sequence[float], a: float) -> float:
    """The instruction RATE."""
    oldest = _push(cells, t, k, a, _former)
    began, then = cells[oldest : oldest + 2]
    return (a - then) / (t - began) if t - began >= k[0] else _NAN


def delay(cells: Cells, t: float, k: Sequence[float], a: float) -> float:
    """The instruction DELAY."""
    oldest = _push(cells, t, k, a, _former)
    return cells[oldest + 1] if t - cells[oldest] >= k[0] else _NAN


def lowest(cells: Cells, t: float, k: Sequence[float], a: float) -> float:
    """The instruction LOWEST."""
    oldest = _push(cells, t, k, a, _worst)
    margins = [cells[at + 1] for at in _pairs(cells, k)]
    return _worst(*margins) if t - cells[oldest] >= k[0] else _worst(k[2], *margins)


def since_margin(cells: Cells, t: float, k: Sequence[float], a: float, b: float) -> float:
    """The instruction SINCE_MARGIN."""
    _drop(cells, t, k)
    for at in _pairs(cells, k):
        cells[at + 1] = _worst(cells[at + 1], a)
    _push(cells, t, k, b, _best)
    return _best(-_INF, *(cells[at + 1] for at in _pairs(cells, k)))


def _worst(*margins: float) -> float:
    """Margins joined by `and`, as the instruction WORST folds them."""
    known = [margin for margin in margins if margin == margin]
    least = min(known, default=_NAN)
    return least if len(known) == len(margins) or least < 0.0 else _NAN


def _best(*margins: float) -> float:
    return -_worst(*(-margin for margin in margins))


def _former(old: float, new: float) -> float:
    return old


def _pairs(cells: Cells, k: Sequence[float]) -> list[int]:
    """Indices of the pairs of a ring buffer, the oldest first."""
    head, count, capacity = int(cells[0]), int(cells[1]), int(k[3])
    return [2 + 2 * ((head + i) % capacity) for i in range(count)]


def _drop(cells: Cells, t: float, k: Sequence[float]) -> None:
    """Drop the pairs that have left the window."""
    head, count, capacity = int(cells[0]), int(cells[1]), int(k[3])
    while count >= 2 and t - cells[2 + 2 * ((head + 1) % capacity)] >= k[0]:
        head, count = (head + 1) % capacity, count - 1
    cells[:2] = head, count


def _push(cells: Cells, t: float, k: Sequence[float], value: float, merge: Callable[[float, float], float]) -> int:
    """Add a sample to a ring buffer; returns the index of the oldest pair."""
    _drop(cells, t, k)
    pairs = _pairs(cells, k)
    if pairs and t - cells[pairs[-1]] < k[1]:
        cells[pairs[-1] + 1] = merge(cells[pairs[-1] + 1], value)
        return pairs[0]
    new = 2 + 2 * ((int(cells[0]) + len(pairs)) % int(k[3]))
    cells[new : new + 2] = t, value
    cells[1] += 1.0
    return pairs[0] if pairs else new
