"""Range of an expression over the bounds of its signals, by interval arithmetic.

Source: R. E. Moore, "Interval Analysis", 1966. A range contains all values that the expression can have. It may be too
wide, because two reads of one signal are treated as independent.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from ...expression import Node, evaluate

Range = tuple[float, float]
ANY: Range = (-math.inf, math.inf)


def range_of(node: Node, bounds: Callable[[int], Range]) -> Range:
    """Minimum and maximum of an expression; for an expression with a group of values, over the whole group."""
    match node.op:
        case "number":
            return float(node.value), float(node.value)
        case "read":
            return _hull([bounds(i) for i in range(node.start, node.stop)])
        case "vector":
            return _hull([(float(arg.value), float(arg.value)) for arg in node.args])
        case "time_since":
            return 0.0, math.inf
        case "count":
            return 0.0, float(max(1, node.args[0].kind.size))
        case "argmin":
            return 0.0, float(max(1, node.args[0].kind.size) - 1)
        case "if":
            return _hull([range_of(arg, bounds) for arg in node.args[1:]])
        case "dot":
            return _dot(node, bounds)
    if node.constant and not node.kind.size and not node.kind.boolean:
        value = evaluate(node, ())
        return ANY if value is None else (float(value), float(value))
    ranges = [range_of(arg, bounds) for arg in node.args if not arg.kind.boolean]
    found = _RULES[node.op](*_spread(node, ranges)) if node.op in _RULES else ANY
    return ANY if any(map(math.isnan, found)) else found


def _spread(node: Node, ranges: list[Range]) -> list[Range]:
    """Operands for the interval rule of an operator.

    Sums and means get the range of their group once for each value. `min_valid` gets the range of its group only, not
    that of its second operand, a count.
    """
    if node.op in ("sum", "mean"):
        return ranges * max(1, node.args[0].kind.size)
    return ranges[:1] if node.op == "min_valid" else ranges


def _hull(ranges: list[Range]) -> Range:
    return min(low for low, _ in ranges), max(high for _, high in ranges)


def _dot(node: Node, bounds: Callable[[int], Range]) -> Range:
    group = range_of(node.args[0], bounds)
    return _plus(*[_times(group, (float(arg.value), float(arg.value))) for arg in node.args[1].args])


def _plus(*ranges: Range) -> Range:
    low, high = 0.0, 0.0
    for a, b in ranges:
        low, high = low + a, high + b
    return low, high


def _times(a: Range, b: Range) -> Range:
    ends = [x * y for x in a for y in b]
    return ANY if any(map(math.isnan, ends)) else (min(ends), max(ends))


def _over(a: Range, b: Range) -> Range:
    if b[0] <= 0.0 <= b[1]:
        return ANY
    ends = [x / y for x in a for y in b]
    return ANY if any(map(math.isnan, ends)) else (min(ends), max(ends))


def _size(a: Range) -> Range:
    low = 0.0 if a[0] <= 0.0 <= a[1] else min(abs(a[0]), abs(a[1]))
    return low, max(abs(a[0]), abs(a[1]))


def _clip(a: Range, low: Range, high: Range) -> Range:
    inner = max(a[0], low[0]), max(a[1], low[1])
    return min(inner[0], high[0]), min(inner[1], high[1])


def _mean(*ranges: Range) -> Range:
    low, high = _plus(*ranges)
    return low / len(ranges), high / len(ranges)


def _hypot(a: Range, b: Range) -> Range:
    (a_low, a_high), (b_low, b_high) = _size(a), _size(b)
    return max(a_low, b_low), a_high + b_high


_RULES: Mapping[str, Callable[..., Range]] = {
    "neg": lambda a: (-a[1], -a[0]),
    "+": _plus,
    "-": lambda a, b: (a[0] - b[1], a[1] - b[0]),
    "*": _times,
    "/": _over,
    "sum": _plus,
    "mean": _mean,
    "min": lambda *ranges: (min(a for a, _ in ranges), min(b for _, b in ranges)),
    "max": lambda *ranges: (max(a for a, _ in ranges), max(b for _, b in ranges)),
    "min_valid": lambda a: a,
    "abs": _size,
    "clip": _clip,
    "hypot": _hypot,
    "sign": lambda a: (-1.0 if a[0] < 0.0 else float(a[0] > 0.0), 1.0 if a[1] > 0.0 else -float(a[1] < 0.0)),
    "side": lambda a: (-1.0 if a[0] < 0.0 else 1.0, 1.0 if a[1] >= 0.0 else -1.0),
    "sqrt": lambda a: (math.sqrt(max(a[0], 0.0)), math.sqrt(max(a[1], 0.0))),
    "wrap_angle": lambda a: (-math.pi, math.pi),
    "atan2": lambda a, b: (-math.pi, math.pi),
}
