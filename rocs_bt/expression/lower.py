"""Compiler from typed trees to a register program (`Program`); common subexpressions are computed only once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from .node import TEMPORAL_OPS, Node
from .operators import CODES, COMPARISONS, INSTRUCTIONS, SIGNS, Form
from .program import TOLERANCE, Program, ring_shape


def lower(nodes: Sequence[Node], also: Sequence[Node] = (), margins: int = 0) -> Program:
    """Compile expressions to one register program.

    Args:
        nodes: Expressions, without the operator `within`.
        also: Expressions evaluated outside the program; the program updates only their temporal operators.
        margins: Number of expressions, from the first of `nodes` on, with computed robustness margins; each must have a
            single truth value.
    """
    return _Lowering([*nodes, *also]).program(nodes, also, margins)


class _Lowering:
    def __init__(self, nodes: Sequence[Node]) -> None:
        indices = sorted({i for node in nodes for i in node.reads()})
        self._register_of = {index: register for register, index in enumerate(indices)}
        self._initial = [math.nan] * len(indices)
        self._constants: dict[tuple[object, ...], int] = {}
        self._code: list[tuple[int, ...]] = []
        self._texts: list[str] = []
        self._cells: list[float] = []
        self._known: dict[tuple[object, ...], int] = {}
        self._done: dict[int, int] = {}
        self._margins: dict[tuple[int, bool], int] = {}
        self._temporal: dict[Node, int] = {}
        self._reads = _runs(indices)
        for start, stop in self._reads:
            dst, n = self._register_of[start], stop - start
            self._code.append((CODES["load"], n, dst, start, 0, 0, 1, 0))
            self._texts.append("")

    def program(self, nodes: Sequence[Node], also: Sequence[Node], margins: int) -> Program:
        roots = [self.node(node) for node in nodes]
        for node in also:
            if node.temporal:
                for part in node.walk():
                    if part.op in TEMPORAL_OPS:
                        self.node(part)
        found = [self.margin(node, mixed_units(node)) for node in nodes[:margins]]
        return Program(
            code=np.array(self._code, np.int32).reshape(-1, 8),
            registers=np.array(self._initial, float),
            cells=np.array(self._cells, float),
            roots=np.array(roots, np.int32),
            margins=np.array(found + [-1] * (len(nodes) - margins), np.int32),
            temporal=self._temporal,
            texts=tuple(self._texts),
            reads=self._reads,
        )

    def node(self, node: Node) -> int:
        """First register of the value of an expression."""
        key = id(node)
        if key not in self._done:
            self._done[key] = self._lowered(node)
        return self._done[key]

    def _lowered(self, node: Node) -> int:
        match node.op:
            case "number" | "truth":
                return self._constant(float(node.value))
            case "vector":
                return self._constant(tuple(float(arg.value) for arg in node.args))
            case "read":
                return self._register_of[node.start]
            case "and" | "or":
                return self._chain(node.op, [self.node(a) for a in node.args], node)
            case "compare":
                return self._compare(node)
            case "if":
                test, then, other = (self.node(arg) for arg in node.args)
                wide = (node.args[1].kind.size > 0) | (node.args[2].kind.size > 0) << 1
                return self._emit("select", node, then, other, test, wide=wide)
        if node.op in TEMPORAL_OPS:
            register = self._remember(node)
            self._temporal[node] = register
            return register
        if node.op == "mean" or INSTRUCTIONS[CODES[SIGNS.get(node.op, node.op)]].form is Form.GROUP:
            return self._reduce(node)
        args = [self.node(arg) for arg in node.args]
        wide = sum((arg.kind.size > 0) << i for i, arg in enumerate(node.args))
        a, b, c = (*args, 0, 0)[:3]
        return self._emit(SIGNS.get(node.op, node.op), node, a, b, c, wide=wide)

    def _chain(self, op: str, registers: Sequence[int], node: Node, n: int = 0) -> int:
        register = registers[0]
        for other in registers[1:]:
            register = self._emit(op, node, register, other, wide=3 if n else 0, n=n)
        return register

    def _compare(self, node: Node) -> int:
        found = []
        for sign, (left, right) in zip(node.signs, pairwise(node.args), strict=True):
            if sign in (">", ">="):
                left, right = right, left
            wide, size = _wide(left, right), max(left.kind.size, right.kind.size)
            register = self._emit(COMPARISONS[sign], node, self.node(left), self.node(right), wide=wide, n=size)
            found.append((register, size))
        return self._joined("and", node, found)

    def _joined(self, op: str, node: Node, found: Sequence[tuple[int, int]]) -> int:
        """Combine the comparisons of a chain such as `a < b < c`; returns the register of the result."""
        (register, size), *others = found
        for other, more in others:
            register = self._emit(op, node, register, other, wide=(size > 0) | (more > 0) << 1, n=max(size, more))
            size = max(size, more)
        return register

    def _reduce(self, node: Node) -> int:
        args = [(self.node(arg), arg.kind.size) for arg in node.args]
        first, size = args[0]
        if node.op in ("min", "max"):
            parts = [self._emit(node.op, arg, r, n=n) if n else r for (r, n), arg in zip(args, node.args, strict=True)]
            return self._chain(f"{node.op}2", parts, node)
        if node.op in ("sum", "mean", "any", "all") and not size:
            return first
        if node.op == "mean":
            total = self._emit("sum", node, first, n=size)
            return self._emit("div", node, total, self._constant(float(size)))
        return self._emit(node.op, node, first, args[-1][0] if len(args) > 1 else 0, n=size)

    def _remember(self, node: Node) -> int:
        """Register of the value of a temporal operator; `once(a)` is computed as `not held(not a)`."""
        args = [self.node(arg) for arg in node.args]
        if node.op == "once":
            held = self._temporal_code("held", node, [self._emit("not", node, args[0])], -math.inf)
            return self._emit("not", node, held)
        return self._temporal_code(node.op, node, args, math.inf if node.op == "held" else -math.inf)

    def _temporal_code(self, op: str, node: Node, args: Sequence[int], before: float = math.nan) -> int:
        """Append a temporal instruction; `before` is the value before the first sample."""
        window, row = float(node.value), INSTRUCTIONS[CODES[op]]
        width, capacity = ring_shape(window)
        constants = self._constant((window - TOLERANCE, width - TOLERANCE, before, float(capacity)))
        cells = [before] * row.cells or [0.0] * (2 + 2 * capacity)
        return self._emit(op, node, args[0], args[-1] if row.operands > 1 else 0, constants, cells=cells)

    def margin(self, node: Node, mixed: bool) -> int:
        """First register of the robustness margin of an expression, which is positive if the expression is true.

        If `mixed`, margins of comparisons are normalised, because their units differ.
        """
        key = (id(node), mixed)
        if key not in self._margins:
            self._margins[key] = self._margin(node, mixed)
        return self._margins[key]

    def _margin(self, node: Node, mixed: bool) -> int:
        def of(arg: Node) -> int:
            return self.margin(arg, mixed)

        def neg(register: int) -> int:
            return self._emit("neg", node, register)

        match node.op:
            case "truth":
                return self._constant(math.inf if node.value else -math.inf)
            case "not":
                return self._emit("neg", node, of(node.args[0]), wide=node.kind.size > 0)
            case "and" | "or":
                return self._chain("worst" if node.op == "and" else "best", [of(arg) for arg in node.args], node)
            case "if":
                test, then, other = (of(arg) for arg in node.args)
                one, both = (2, 3) if node.kind.size else (0, 0)
                yes = self._emit("worst", node, test, then, wide=one)
                no = self._emit("worst", node, neg(test), other, wide=one)
                best = self._emit("best", node, yes, no, wide=both)
                # NaN if the condition is invalid, even if the branches have the same margin.
                return self._emit("select", node, best, best, self.node(node.args[0]), wide=both)
            case "any" | "all":
                group = node.args[0]
                op = "best_of" if node.op == "any" else "worst_of"
                return self._emit(op, node, of(group), n=group.kind.size) if group.kind.size else of(group)
            case "held":
                return self._temporal_code("lowest", node, [of(node.args[0])], before=-math.inf)
            case "once":
                lowest = self._temporal_code("lowest", node, [neg(of(node.args[0]))], before=math.inf)
                return neg(lowest)
            case "since":
                return self._temporal_code("since_margin", node, [of(arg) for arg in node.args])
            case "delay":
                return self._temporal_code("delay", node, [of(node.args[0])])
        return self._gaps(node, self._constant(margin_scale(node) if mixed else 1.0))

    def _gaps(self, node: Node, scale: int) -> int:
        """Register of the robustness margin of a comparison."""
        found = []
        for sign, (left, right) in zip(node.signs, pairwise(node.args), strict=True):
            if sign in (">", ">="):
                left, right = right, left
            size, wide = max(left.kind.size, right.kind.size), _wide(left, right)
            a, b = self.node(left), self.node(right)
            gap = self._emit("gap", node, a, b, scale, wide=wide, n=size)
            if sign in ("==", "!="):
                back = self._emit("gap", node, b, a, scale, wide=_wide(right, left), n=size)
                gap = self._emit("worst", node, gap, back, wide=3 if size else 0, n=size)
            if sign == "!=":
                gap = self._emit("neg", node, gap, wide=size > 0, n=size)
            found.append((gap, size))
        return self._joined("worst", node, found)

    def _constant(self, value: float | tuple[float, ...]) -> int:
        values = value if isinstance(value, tuple) else (value,)
        key = tuple(map(repr, values))
        if key not in self._constants:
            self._constants[key] = len(self._initial)
            self._initial.extend(values)
        return self._constants[key]

    def _emit(
        self,
        op: str,
        node: Node,
        a: int,
        b: int = 0,
        c: int = 0,
        wide: int = 0,
        n: int | None = None,
        cells: list[float] | None = None,
    ) -> int:
        """Append an instruction, unless an equal one exists; returns the register of the result."""
        n = max(1, node.kind.size if n is None else n)
        key = (op, n, a, b, c, wide)
        if key in self._known:
            return self._known[key]
        dst, size = len(self._initial), n if INSTRUCTIONS[CODES[op]].form is Form.EACH else 1
        self._known[key] = dst
        cell = 0
        if cells is not None:
            cell = len(self._cells)
            self._cells.extend(cells)
        self._code.append((CODES[op], n, dst, a, b, c, wide, cell))
        self._texts.append(node.text)
        self._initial.extend([math.nan] * size)
        return dst


def _wide(left: Node, right: Node) -> int:
    return (left.kind.size > 0) | (right.kind.size > 0) << 1


def _runs(indices: Sequence[int]) -> tuple[tuple[int, int], ...]:
    found: list[tuple[int, int]] = []
    for i in indices:
        if found and found[-1][1] == i:
            found[-1] = (found[-1][0], i + 1)
        else:
            found.append((i, i + 1))
    return tuple(found)


def mixed_units(node: Node) -> bool:
    """Whether the comparisons in an expression have different units, so that their margins must be normalised."""
    return len({part.args[0].kind.dimension for part in node.walk() if part.op == "compare"}) > 1


def margin_scale(node: Node) -> float:
    """Divisor that normalises the margin of a comparison, if an expression mixes units.

    The divisor is the smallest finite range of values of the signals that the comparison reads, or 1 SI unit.
    """
    wanted = node.args[0].kind.dimension
    spans = [part.span for part in node.walk() if part.op == "read" and part.kind.dimension == wanted]
    return min((span for span in spans if 0.0 < span < math.inf), default=1.0)
