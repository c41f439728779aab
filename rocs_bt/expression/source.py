"""Source text of an expression without aliases, so that it can be read where only the signals are known."""

from __future__ import annotations

import math

from .environment import Environment
from .node import Node
from .operators import FUNCTIONS

_INFIX = frozenset("+-*/")


def source(node: Node, environment: Environment) -> str:
    """Text that `parse` reads as an equal node: aliases are expanded, numbers are in SI units."""
    if node.op == "read":
        return _read(node, environment)
    if node.op == "number":
        return _number(float(node.value), str(node.kind.dimension))
    if node.op == "truth":
        return str(bool(node.value))
    parts = [source(arg, environment) for arg in node.args]
    if node.op == "neg":
        return f"(-{parts[0]})"
    if node.op == "compare":
        rest = (f" {sign} {part}" for sign, part in zip(node.signs, parts[1:], strict=True))
        return f"({parts[0]}{''.join(rest)})"
    if node.op in _INFIX or node.op in ("and", "or"):
        return f"({f' {node.op} '.join(parts)})"
    if node.op == "not":
        return f"(not {parts[0]})"
    if node.op == "if":
        return f"({parts[1]} if {parts[0]} else {parts[2]})"
    if node.op == "vector":
        return f"[{', '.join(parts)}]"
    if node.op in FUNCTIONS and FUNCTIONS[node.op].window:
        parts.append(_number(float(node.value), "s"))
    return f"{node.op}({', '.join(parts)})"


def _read(node: Node, environment: Environment) -> str:
    name, first = max(((n, at) for n, at in environment.offsets.items() if at <= node.start), key=lambda item: item[1])
    size = environment.signals[name].size
    low, high = node.start - first, node.stop - first
    if size == 1 or (node.kind.size == size and high - low == size):
        return name
    return f"{name}[{low}:{high}]" if node.kind.size else f"{name}[{low}]"


def _number(value: float, unit: str) -> str:
    text = "inf" if math.isinf(value) else repr(abs(value))
    written = text if unit == "1" else f"{text} {unit}"
    return f"(-{written})" if value < 0.0 else written
