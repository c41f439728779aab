"""Reference interpreter of expressions on one snapshot; the code of `compiler` computes the same values faster.

An *invalid* number or truth value is None; a NaN in the snapshot counts as invalid. Logic is three-valued (Kleene):
`False and invalid` is False.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..base.geometry import wrap_angle
from .node import Node

Value = Any  # a float, a bool, None, or a list of such
_SIGNS: Mapping[str, Callable[[Any, Any], bool]] = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq, "!=": operator.ne,
}  # fmt: skip  # a table


def evaluate(node: Node, x: Sequence[float]) -> float | bool | None:
    """Value of an expression without temporal operators, with a single value; None if invalid.

    Args:
        node: Typed tree from `parse`.
        x: Snapshot: values of all signals, SI units.
    """
    value: float | bool | None = _value(node, x)
    if isinstance(value, list):
        raise TypeError(f"'{node.text}' gives {node.kind.words}, not a single value")
    return value


def _value(node: Node, x: Sequence[float]) -> Value:
    match node.op:
        case "number" | "truth":
            return node.value
        case "vector":
            return [arg.value for arg in node.args]
        case "read":
            return known(list(x[node.start : node.stop]) if node.kind.size else x[node.start])
    return combine(node, [_value(arg, x) for arg in node.args])


def combine(node: Node, values: Sequence[Value]) -> Value:
    """Value of an operation that is not temporal."""
    if not node.kind.size:
        return known(_single(node, values))
    rows = [[v[k] if isinstance(v, list) else v for v in values] for k in range(node.kind.size)]
    return [known(_single(node, row)) for row in rows]


def known(value: Value) -> Value:
    """Replace NaN by None, in a number or in all items of a list."""
    if isinstance(value, list):
        return [known(v) for v in value]
    return None if isinstance(value, float) and math.isnan(value) else value


def every(values: Sequence[bool | None]) -> bool | None:
    """Three-valued conjunction."""
    if any(value is False for value in values):
        return False
    return None if None in values else True


def some(values: Sequence[bool | None]) -> bool | None:
    """Three-valued disjunction."""
    if any(value is True for value in values):
        return True
    return None if None in values else False


def _single(node: Node, values: Sequence[Value]) -> Value:
    """Value of an operation on single values; only functions that reduce a group, such as `min`, get a list."""
    match node.op:
        case "and":
            return every(values)
        case "or":
            return some(values)
        case "if":
            return None if values[0] is None else values[1] if values[0] else values[2]
        case "compare":
            triples = zip(node.signs, values, values[1:], strict=False)
            return every([None if a is None or b is None else _SIGNS[sign](a, b) for sign, a, b in triples])
        case "any":
            return some(_flat(values[0]))
        case "all":
            return every(_flat(values[0]))
        case "min_valid":
            valid = [v for v in _flat(values[0]) if v is not None]
            return min(valid) if len(valid) >= values[1] else None
    if any(v is None for v in _flat(*values)):
        return None
    return _OPERATIONS[node.op](*values)


def _flat(*values: Value) -> list[Any]:
    return [v for value in values for v in (value if isinstance(value, list) else [value])]


def _sum(values: Sequence[float]) -> float:
    """Sum of values from left to right. Python's `sum` is more exact, but its result depends on the platform."""
    total = values[0]
    for value in values[1:]:
        total += value
    return total


def hypot(a: float, b: float) -> float:
    """Hypotenuse as the C library and so the kernel compute it; `math.hypot` differs in the last digit."""
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
