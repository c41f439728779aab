"""The meaning of the language, written as plainly as possible: the reference for every faster evaluator.

- A NaN among the values that an expression names makes it *invalid*, on whichever branch they stand: it is then
  neither true nor false, and has no number. Only the group of `min_valid` may hold some.
- What has no value is invalid too: x / 0, inf - inf, 0 * inf, inf / inf, sqrt of a negative number, the angle of inf.
- `and`, `or`, `if` and chains of comparisons stop as Python's do, so a guarded division is never computed.
- +inf is a number: a range without an echo is farther than every threshold.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..geometry import wrap_angle
from .node import Node

Value = float | bool | list[float] | list[bool]
_SIGNS: Mapping[str, Callable[[Any, Any], bool]] = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq, "!=": operator.ne,
}  # fmt: skip


class Invalid(Exception):
    """An expression has no value."""


def evaluate(node: Node, x: Sequence[float]) -> float | bool | None:
    """The value of an expression of a single value; None where it is invalid.

    Args:
        node: From `parse`.
        x: The snapshot, all signals one after the other.
    """
    if any(math.isnan(x[i]) for i in node.reads()):
        return None
    try:
        value = _value(node, x)
    except Invalid:
        return None
    if isinstance(value, list):
        raise TypeError(f"'{node.text}' gives {node.kind.words}, not a single value")
    return value


def _value(node: Node, x: Sequence[float]) -> Value:
    if node.op in ("number", "truth"):
        return node.value
    if node.op == "read":
        return list(x[node.start : node.stop]) if node.kind.size else x[node.start]
    if node.op == "and":
        return all(_value(arg, x) for arg in node.args)
    if node.op == "or":
        return any(_value(arg, x) for arg in node.args)
    if node.op == "if":
        test, then, other = node.args
        return _value(then if _value(test, x) else other, x)
    if node.op == "compare" and not node.kind.size:
        return _chain(node, x)
    if node.op == "min_valid":
        return _min_valid(x[node.args[0].start : node.args[0].stop], node.args[1].value)
    values = [_value(arg, x) for arg in node.args]
    if node.kind.size:
        rows = [[v[i] if isinstance(v, list) else v for v in values] for i in range(node.kind.size)]
        return [_single(node, row) for row in rows]
    return _single(node, values)


def _chain(node: Node, x: Sequence[float]) -> bool:
    left = _value(node.args[0], x)
    for sign, arg in zip(node.signs, node.args[1:], strict=True):
        right = _value(arg, x)
        if not _SIGNS[sign](left, right):
            return False
        left = right
    return True


def _single(node: Node, values: Sequence[Value]) -> float | bool:
    """One operation on values that are known; groups have been taken apart, but for the functions that reduce them."""
    if node.op == "compare":
        pairs = zip(node.signs, values, values[1:], strict=False)
        return all(_SIGNS[sign](a, b) for sign, a, b in pairs)
    result = _OPERATIONS[node.op](*values)
    if math.isnan(result):
        raise Invalid
    return result


def _divide(a: float, b: float) -> float:
    if b == 0.0:
        raise Invalid
    return a / b


def _flat(*values: float | list[float]) -> list[float]:
    return [v for value in values for v in (value if isinstance(value, list) else [value])]


def _root(a: float) -> float:
    if a < 0.0:
        raise Invalid
    return math.sqrt(a)


def _angle(a: float) -> float:
    if math.isinf(a):
        raise Invalid
    return wrap_angle(a)


def _min_valid(group: Sequence[float], least: float) -> float:
    valid = [v for v in group if not math.isnan(v)]
    if len(valid) < least:
        raise Invalid
    return min(valid)


_OPERATIONS: Mapping[str, Callable[..., float | bool]] = {
    "neg": lambda a: -a,
    "not": lambda a: not a,
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": _divide,
    "min": lambda *groups: min(_flat(*groups)),
    "max": lambda *groups: max(_flat(*groups)),
    "sum": lambda group: float(sum(_flat(group))),
    "mean": lambda group: sum(_flat(group)) / len(_flat(group)),
    "any": lambda group: any(_flat(group)),
    "all": lambda group: all(_flat(group)),
    "count": lambda group: float(sum(_flat(group))),
    "abs": lambda a: abs(a),
    "clip": lambda a, low, high: min(max(a, low), high),
    "hypot": lambda a, b: math.hypot(a, b),
    "sign": lambda a: float((a > 0.0) - (a < 0.0)),
    "side": lambda a: 1.0 if a >= 0.0 else -1.0,
    "sqrt": _root,
    "wrap_angle": _angle,
}
