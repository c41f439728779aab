"""Expressions as generated Python functions: the same values as the interpreter, sixteen to forty times faster.

Only numbers, indices and names of this file's helpers go into the generated source, nothing that a person wrote. The
snapshot is a plain list (`ndarray.tolist()`): a guard on an array takes two to three times as long. Validity is one
sum of what is read (NaN survives a sum); only where that is NaN each value is looked at.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..geometry import wrap_angle
from .environment import Environment
from .interpreter import Invalid
from .node import Node
from .parser import parse

Snapshot = NDArray[np.float64] | Sequence[float]


@dataclass(frozen=True)
class Expression:
    """A compiled expression.

    Attributes:
        node: Its typed tree.
        function: Its value for a snapshot given as a list; None where it is invalid.
    """

    node: Node
    function: Callable[[Sequence[float]], float | bool | None]

    @property
    def text(self) -> str:
        """How it was written."""
        return self.node.text

    def __call__(self, x: Snapshot, t: float = 0.0) -> float | bool | None:
        """The value; None where it is invalid, because a value it names is NaN or its own is not a number.

        Args:
            x: The snapshot, (size,) in SI units.
            t: The snapshot's time [s]; today's language holds nothing that asks for it.
        """
        return self.function(x.tolist() if isinstance(x, np.ndarray) else x)


def compile_expression(text: str, environment: Environment) -> Expression:
    """Parse and compile an expression of a single value.

    Raises:
        InputError: As `parse`.
    """
    return compile_node(parse(text, environment))


def compile_node(node: Node) -> Expression:
    """Compile a typed tree of a single value."""
    lines = ["def expression(x):"]
    if reads := node.reads():
        ranges = _ranges(reads)
        lines += [f"    s = {_sum_code(ranges)}", f"    if s != s and ({_nan_code(ranges)}):", "        return None"]
    code = _code(node)
    if any(name in code for name in ("number(", "divide(", "root(", "angle(", "min_valid(")):
        lines += ["    try:", f"        return {code}", "    except Invalid:", "        return None"]
    else:
        lines += [f"    return {code}"]
    return Expression(node, define("\n".join(lines), "expression"))


def define(source: str, name: str, extra: Mapping[str, Any] | None = None) -> Callable[..., Any]:
    """The function of that name in generated source; `extra` are names it may use beside the helpers."""
    names = {**_HELPERS, **(extra or {})}
    exec(compile(source, "<expression>", "exec"), names)  # the source is generated: see above
    function: Callable[..., Any] = names[name]
    return function


def joint_function(nodes: Sequence[Node]) -> Callable[[Sequence[float]], tuple[float | bool | None, ...]]:
    """One function for many expressions, which computes what they share only once.

    Only shared parts that read a snapshot and can never be invalid are computed ahead, so nothing that a guard skips
    is ever needed for it. When any value read by any of them is NaN, each is evaluated alone.
    """
    alone = [compile_node(node).function for node in nodes]
    safe = [node for node in nodes if not _fallible(node)]
    shared = _shared(safe)
    names = {part: f"v{i}" for i, part in enumerate(shared)}
    reads = set().union(*(node.reads() for node in safe))
    lines = ["def joint(x):"]
    if reads:
        lines += [f"    s = {_sum_code(_ranges(reads))}", "    if s != s:", "        return careful(x)"]
    for part in shared:
        lines.append(f"    {names[part]} = {_code(part, {p: n for p, n in names.items() if p != part})}")
    values = [f"alone[{i}](x)" if _fallible(node) else _code(node, names) for i, node in enumerate(nodes)]
    lines.append(f"    return ({', '.join(values)},)")

    def careful(x: Sequence[float]) -> tuple[float | bool | None, ...]:
        return tuple([function(x) for function in alone])

    return define("\n".join(lines), "joint", {"alone": alone, "careful": careful})


def _shared(nodes: Sequence[Node]) -> list[Node]:
    """Reductions of plain reads that occur more than once, in the order in which they are met."""
    counts: dict[Node, int] = {}
    for node in nodes:
        for part in node.walk():
            if part.op in ("min", "max") and all(arg.op == "read" for arg in part.args):
                counts[part] = counts.get(part, 0) + 1
    return [part for part, count in counts.items() if count > 1]


def _fallible(node: Node) -> bool:
    return any(name in _code(node) for name in ("number(", "divide(", "root(", "angle(", "min_valid("))


def _ranges(indices: set[int]) -> list[tuple[int, int]]:
    found: list[tuple[int, int]] = []
    for i in sorted(indices):
        if found and found[-1][1] == i:
            found[-1] = (found[-1][0], i + 1)
        else:
            found.append((i, i + 1))
    return found


def _sum_code(ranges: Sequence[tuple[int, int]]) -> str:
    return " + ".join(f"x[{a}]" if b == a + 1 else f"sum(x[{a}:{b}])" for a, b in ranges)


def _nan_code(ranges: Sequence[tuple[int, int]]) -> str:
    # A sum is NaN for +inf and -inf together as well, so the values themselves decide.
    return " or ".join(f"x[{a}] != x[{a}]" if b == a + 1 else f"any([v != v for v in x[{a}:{b}]])" for a, b in ranges)


def _code(node: Node, names: Mapping[Node, str] | None = None) -> str:
    """Python source of a node; `names` has parts that are computed already."""
    if names and node in names:
        return names[node]
    args = [_code(arg, names) for arg in node.args]
    if node.op == "read":
        return f"x[{node.start}:{node.stop}]" if node.kind.size else f"x[{node.start}]"
    if node.op in ("number", "truth"):
        return "inf" if node.value == math.inf else "(-inf)" if node.value == -math.inf else f"({node.value!r})"
    if node.op == "min_valid":
        group = node.args[0]
        return f"min_valid(x[{group.start}:{group.stop}], {int(node.args[1].value)})"
    if node.kind.size and node.op != "if":
        return _each(node, args)
    return _operation(node, args)


def _each(node: Node, args: Sequence[str]) -> str:
    """The operation value by value; single values are computed once, groups are walked side by side."""
    names = [f"a{i}" for i in range(len(args))]
    once = [f"for {n} in ({a},)" for n, a, arg in zip(names, args, node.args, strict=True) if not arg.kind.size]
    groups = [(n, a) for n, a, arg in zip(names, args, node.args, strict=True) if arg.kind.size]
    if len(groups) == 1:
        walk = f"for {groups[0][0]} in {groups[0][1]}"
    else:
        walk = f"for {', '.join(n for n, _ in groups)} in zip({', '.join(a for _, a in groups)})"
    return f"[{_operation(node, names)} {' '.join([*once, walk])}]"


def _operation(node: Node, args: Sequence[str]) -> str:
    """One operation on the source of its args."""
    match node.op:
        case "neg":
            return f"(-{args[0]})"
        case "not":
            return f"(not {args[0]})"
        case "and" | "or":
            return f"({f' {node.op} '.join(args)})"
        case "if":
            return f"({args[1]} if {args[0]} else {args[2]})"
        case "compare":
            return f"({args[0]} {' '.join(f'{s} {a}' for s, a in zip(node.signs, args[1:], strict=True))})"
        case "+" | "-":
            plain = f"{args[0]} {node.op} {args[1]}"
            return f"({plain})" if any(map(_finite, node.args)) else f"number({plain})"
        case "*":
            plain = f"{args[0]} * {args[1]}"
            return f"({plain})" if any(map(_nonzero, node.args)) else f"number({plain})"
        case "/":
            return f"({args[0]} / {args[1]})" if _nonzero(node.args[1]) else f"divide({args[0]}, {args[1]})"
    return _call(node, args)


def _call(node: Node, args: Sequence[str]) -> str:
    single = not node.args[0].kind.size
    match node.op:
        case "min" | "max":
            if len(args) == 1:
                return args[0] if single else f"{node.op}({args[0]})"
            parts = [f"*{a}" if arg.kind.size else a for a, arg in zip(args, node.args, strict=True)]
            return f"{node.op}({', '.join(parts)})"
        case "sum" | "mean":
            share = f" / {node.args[0].kind.size}" if node.op == "mean" else ""
            return args[0] if single else f"number(sum({args[0]}){share})"
        case "any" | "all":
            return args[0] if single else f"{node.op}({args[0]})"
        case "count":
            return f"float({args[0]})" if single else f"float(sum({args[0]}))"
        case "clip":
            return f"min(max({args[0]}, {args[1]}), {args[2]})"
        case "side":
            return f"(1.0 if {args[0]} >= 0.0 else -1.0)"
        case "sqrt":
            return f"root({args[0]})"
        case "wrap_angle":
            return f"angle({args[0]})"
    return f"{node.op}({', '.join(args)})"


def _finite(node: Node) -> bool:
    """Whether its values are surely finite, so that adding it to another number gives a number."""
    return (node.op == "number" and math.isfinite(node.value)) or node.op in ("sign", "side", "count", "wrap_angle")


def _nonzero(node: Node) -> bool:
    """Whether it is surely finite and not zero, so that a product with it, or a division by it, gives a number."""
    return (node.op == "number" and math.isfinite(node.value) and node.value != 0.0) or node.op == "side"


def _number(value: float) -> float:
    if value != value:
        raise Invalid
    return value


def _divide(a: float, b: float) -> float:
    if b == 0.0:
        raise Invalid
    return _number(a / b)


def _root(value: float) -> float:
    if value < 0.0:
        raise Invalid
    return math.sqrt(value)


def _angle(value: float) -> float:
    if math.isinf(value):
        raise Invalid
    return wrap_angle(value)


def _sign(value: float) -> float:
    return (value > 0.0) - (value < 0.0) + 0.0


def _min_valid(group: Sequence[float], least: int) -> float:
    valid = [v for v in group if v == v]
    if len(valid) < least:
        raise Invalid
    return min(valid)


_HELPERS: Mapping[str, Any] = {
    "__builtins__": {}, "Invalid": Invalid, "abs": abs, "all": all, "angle": _angle, "any": any, "divide": _divide,
    "float": float, "hypot": math.hypot, "inf": math.inf, "max": max, "min": min, "min_valid": _min_valid,
    "number": _number, "root": _root, "sign": _sign, "sum": sum, "zip": zip,
}  # fmt: skip
