"""Generator of readable Python source from a Program.

The code is executed by `exec`, so it contains only numbers and names of registers and helpers; user text appears only
in comments of one line. The snapshot is a list (`ndarray.tolist()`), because a guard on an array takes two to three
times as long.

The code has two variants. In the *careful* one, every operation checks for invalid values. The *fast* one is for
snapshots without NaN: operations that then always have a valid result are plain Python, such as `a < b and c`, and
only the others check.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from .program import REDUCTIONS, RINGS, TEMPORAL, Op, Program, operands
from .python_helpers import HELPERS

_ALWAYS = {
    Op.NEG, Op.ABS, Op.SIGN, Op.SIDE, Op.HYPOT, Op.ATAN2, Op.MIN2, Op.MAX2, Op.CLIP, Op.SELECT, Op.LT, Op.LE, Op.EQ,
    Op.NE, Op.NOT, Op.AND, Op.OR, Op.MIN, Op.MAX, Op.ARGMIN, Op.ANY, Op.ALL, Op.COUNT, Op.MIN_VALID,
}  # fmt: skip  # a table
_SMALL = {Op.SIGN, Op.SIDE, Op.ATAN2, Op.ARGMIN, Op.COUNT, Op.WRAP}


class Validity:
    """Static analysis that finds registers that are never invalid; `fast` assumes snapshots without NaN."""

    def __init__(self, program: Program, fast: bool) -> None:
        registers = program.registers.tolist()
        constant = program.constant.tolist()
        self._valid = [known and not math.isnan(v) for known, v in zip(constant, registers, strict=True)]
        self._finite = [known and math.isfinite(v) for known, v in zip(constant, registers, strict=True)]
        self._nonzero = [finite and v != 0.0 for finite, v in zip(self._finite, registers, strict=True)]
        for op, n, dst, a, b, c, wide, _ in program.code.tolist():
            self._learn(Op(op), n, dst, a, b, c, wide, fast)

    def valid(self, register: int, n: int) -> bool:
        """Whether n consecutive registers, from `register` on, are never invalid."""
        return all(self._valid[register : register + n])

    def _learn(self, op: Op, n: int, dst: int, a: int, b: int, c: int, wide: int, fast: bool) -> None:
        if op is Op.LOAD:
            self._valid[dst : dst + n] = [fast] * n
            return
        sizes = [n if wide >> i & 1 else 1 for i in range(3)]
        registers = operands(op, a, b, c)
        size = n
        if op in REDUCTIONS:
            sizes, size = [n, 1, 1], 1
        args = list(zip(registers, sizes, strict=False))
        valid = all(self.valid(r, s) for r, s in args)
        finite = [all(self._finite[r : r + s]) for r, s in args]
        nonzero = [all(self._nonzero[r : r + s]) for r, s in args]
        known = valid and self._gives_numbers(op, finite, nonzero)
        self._valid[dst : dst + size] = [known] * size
        bounded = op in _SMALL or (op is Op.CLIP and finite[1] and finite[2]) or (op is Op.NEG and finite[0])
        bounded = bounded or (op in (Op.MIN, Op.MAX, Op.MIN2, Op.MAX2, Op.ABS, Op.MIN_VALID) and all(finite))
        self._finite[dst : dst + size] = [known and bounded] * size
        self._nonzero[dst : dst + size] = [known and op is Op.SIDE] * size

    @staticmethod
    def _gives_numbers(op: Op, finite: list[bool], nonzero: list[bool]) -> bool:
        """Whether the result of an instruction is valid for all valid operands."""
        match op:
            case Op.ADD | Op.SUB:
                return any(finite)
            case Op.MUL:
                return all(finite) or any(nonzero)
            case Op.DIV:
                return nonzero[1]
            case Op.WRAP | Op.SUM:
                return all(finite)
        return op in _ALWAYS


_FEW = 4  # up to this many values, x[0] + x[1] ... is faster than a sum over a slice
_DEEP = 12  # maximum nesting on one line: for readability, and because Python's parser has a limit
_CALLS = {
    Op.SIGN: "sign", Op.SIDE: "side", Op.SQRT: "root", Op.WRAP: "angle", Op.DIV: "divide", Op.HYPOT: "length",
    Op.CLIP: "clip", Op.LT: "lt", Op.LE: "le", Op.EQ: "eq", Op.NE: "ne", Op.NOT: "negate", Op.AND: "both",
    Op.OR: "either", Op.MIN: "least", Op.MAX: "greatest", Op.ARGMIN: "argmin", Op.SUM: "total", Op.ANY: "some",
    Op.ALL: "every", Op.COUNT: "count", Op.MIN_VALID: "min_valid", Op.DOT: "dot", Op.HELD: "held", Op.SINCE: "since",
    Op.AGO: "ago", Op.RATE: "rate", Op.DELAY: "delay", Op.GAP: "gap", Op.WORST: "worst", Op.BEST: "best",
    Op.WORST_OF: "worst_of", Op.BEST_OF: "best_of", Op.LOWEST: "lowest", Op.SINCE_MARGIN: "since_margin",
    Op.ATAN2: "atan2", Op.ABS: "abs",
}  # fmt: skip  # a table
_SIGNS = {Op.ADD: "+", Op.SUB: "-", Op.MUL: "*", Op.DIV: "/", Op.LT: "<", Op.LE: "<=", Op.EQ: "==", Op.NE: "!="}
_PLAIN_CALLS = {Op.MIN: "min", Op.MAX: "max", Op.ANY: "any", Op.ALL: "all", Op.MIN2: "min", Op.MAX2: "max"}


class PythonCode:
    """Generator of the Python source of a program, in the careful or the fast variant (see the module).

    `used` lists each register once for each use.
    """

    def __init__(self, program: Program, used: Sequence[int], fast: bool) -> None:
        self._program = program
        self._registers = program.registers.tolist()
        self._truth = program.truth.tolist()
        self._constant = program.constant.tolist()
        self._code = program.code.tolist()
        self._sure = Validity(program, fast)
        self._source_of: dict[int, str] = {}
        self._depth: dict[int, int] = {}
        self._groups = {row[2] for row in self._code if row[6] and row[0] not in REDUCTIONS}
        self._loads = {dst + i: a + i for op, n, dst, a, *_ in self._code if op == Op.LOAD for i in range(n)}
        self._kept = set(program.temporal.values())
        self._uses = self._count(used)
        self.lines: list[str] = []
        for row, text in zip(self._code, program.texts, strict=True):
            if row[0] != Op.LOAD:
                self._write(row, text)

    def value(self, register: int, n: int = 0) -> str:
        """Python expression for the value of a register, or the list of n of them, for code after `lines`."""
        return self._operand(register, max(n, 1), n > 0)

    def sure(self, register: int) -> bool:
        """Whether the value of a register is never invalid."""
        return self._sure.valid(register, 1)

    def _count(self, used: Sequence[int]) -> dict[int, int]:
        uses: dict[int, int] = {}
        for register in used:
            uses[register] = uses.get(register, 0) + 1
        for op, _, _, a, b, c, *_ in self._code:
            for register in operands(op, a, b, c):
                uses[register] = uses.get(register, 0) + 1
        return uses

    def _write(self, row: Sequence[int], text: str) -> None:
        op, n, dst, a, b, c, wide, cell = row
        if not self._uses.get(dst) and dst not in self._kept and op not in TEMPORAL:
            return
        source = self._operation(Op(op), n, dst, a, b, c, wide, cell)
        depth = 1 + max((self._depth.get(r, 0) for r in operands(op, a, b, c)), default=0)
        if self._uses.get(dst, 0) != 1 or dst in self._kept or op in TEMPORAL or depth > _DEEP:
            comment = f"  # {' '.join(text.split())}" if text else ""
            self.lines.append(f"v{dst} = {source}{comment}")
            source, depth = f"v{dst}", 0
        self._source_of[dst], self._depth[dst] = source, depth

    def _operand(self, register: int, n: int, wide: bool) -> str:
        if register in self._loads:
            at = self._loads[register]
            return f"x[{at}:{at + n}]" if wide else f"x[{at}]"
        if self._constant[register]:
            values = [_literal(v, self._truth[register]) for v in self._registers[register : register + n]]
            return f"[{', '.join(values)}]" if wide else values[0]
        return self._source_of[register]

    def _operation(self, op: Op, n: int, dst: int, a: int, b: int, c: int, wide: int, cell: int) -> str:
        if op in TEMPORAL:
            return self._temporal(op, dst, a, b, c, cell)
        if op in REDUCTIONS:
            return self._reduction(op, n, a, b)
        group = wide != 0
        registers = operands(op, a, b, c)
        sure = all(self._sure.valid(r, n if wide >> i & 1 else 1) for i, r in enumerate(registers))
        result = self._sure.valid(dst, n)
        if not group:
            return self._one(op, [self._operand(r, 1, False) for r in registers], sure, result, self._truth[dst])
        return self._each(op, n, dst, registers, wide, sure, result)

    def _each(self, op: Op, n: int, dst: int, registers: Sequence[int], wide: int, sure: bool, result: bool) -> str:
        """Source of a value-by-value operation; operands with a single value are computed once."""
        names = "abc"[: len(registers)]
        groups = [(name, r) for i, (name, r) in enumerate(zip(names, registers, strict=True)) if wide >> i & 1]
        once = "".join(
            f" for {name} in ({self._operand(r, 1, False)},)"
            for i, (name, r) in enumerate(zip(names, registers, strict=True))
            if not wide >> i & 1
        )
        sources = [self._operand(r, n, True) for _, r in groups]
        walked = sources[0] if len(groups) == 1 else f"zip({', '.join(sources)})"
        walk = f" for {', '.join(name for name, _ in groups)} in {walked}"
        return f"[{self._one(op, list(names), sure, result, self._truth[dst])}{once}{walk}]"

    def _one(self, op: Op, args: Sequence[str], sure: bool, result: bool, truth: bool) -> str:
        """Source of an operation on single values; `sure`: no operand is invalid, `result`: nor is the result."""
        match op:
            case Op.ADD | Op.SUB | Op.MUL:
                return f"({args[0]} {_SIGNS[op]} {args[1]})"
            case Op.NEG:
                return f"(-{args[0]})"
            case Op.ABS:
                return f"abs({args[0]})"
            case Op.ATAN2:
                return f"atan2({', '.join(args)})"
            case Op.MIN2 | Op.MAX2:
                return f"{_PLAIN_CALLS[op]}({', '.join(args)})" if sure else self._careful_pair(op, args)
            case Op.SELECT if sure or result:
                return f"({args[0]} if {args[2]} else {args[1]})"
            case Op.SELECT:
                return f"choose_{'truth' if truth else 'number'}({args[2]}, {args[0]}, {args[1]})"
            case Op.DIV if result:
                return f"({args[0]} / {args[1]})"
        if sure:
            match op:
                case Op.LT | Op.LE | Op.EQ | Op.NE:
                    return f"({args[0]} {_SIGNS[op]} {args[1]})"
                case Op.AND | Op.OR:
                    return f"({args[0]} {op.name.lower()} {args[1]})"
                case Op.NOT:
                    return f"(not {args[0]})"
                case Op.CLIP:
                    return f"min(max({args[0]}, {args[1]}), {args[2]})"
                case Op.SIDE:
                    return f"(1.0 if {args[0]} >= 0.0 else -1.0)"
        return f"{_CALLS[op]}({', '.join(args)})"

    def _careful_pair(self, op: Op, args: Sequence[str]) -> str:
        return f"{'least' if op is Op.MIN2 else 'greatest'}([{', '.join(args)}])"

    def _reduction(self, op: Op, n: int, a: int, b: int) -> str:
        group = self._operand(a, n, True)
        if a in self._source_of and a not in self._groups:
            group = f"[{group}]"
        sure = self._sure.valid(a, n)
        if op is Op.MIN_VALID:
            return f"min({group})" if sure else f"min_valid({group}, {int(self._registers[b])})"
        if op is Op.DOT:
            return f"dot({group}, {self._operand(b, n, True)})"
        if op is Op.COUNT and sure:
            return f"float(sum({group}))"
        return f"{_PLAIN_CALLS[op] if sure and op in _PLAIN_CALLS else _CALLS[op]}({group})"

    def _temporal(self, op: Op, dst: int, a: int, b: int, c: int, cell: int) -> str:
        constants = self._registers[c : c + 4]
        args = ["cells", str(cell), self._operand(a, 1, False)]
        if op in (Op.SINCE, Op.SINCE_MARGIN):
            args.append(self._operand(b, 1, False))
        args.append("t")
        if op is not Op.AGO:
            args.append(repr(constants[0]))
        if op in RINGS:
            args.append(repr(constants[1]))
            args += [_literal(constants[2], False)] if op is Op.LOWEST else []
            args.append(str(int(constants[3])))
        name = "delay_truth" if op is Op.DELAY and self._truth[dst] else _CALLS[op]
        return f"{name}({', '.join(args)})"


def sum_code(program: Program) -> str:
    """Source of the sum of all values that a program reads. The sum is NaN if any value is NaN."""
    short = [range(a, b) if b - a <= _FEW else () for a, b in program.reads]
    terms = [[f"x[{i}]" for i in r] or [f"sum(x[{a}:{b}])"] for r, (a, b) in zip(short, program.reads, strict=True)]
    return " + ".join(term for group in terms for term in group)


def define(source: str, name: str, extra: Mapping[str, Any] | None = None) -> Callable[..., Any]:
    """Execute generated source and return one of its functions.

    Args:
        source: Generated source.
        name: Name of the function.
        extra: Objects that the source uses in addition to the helpers, by name.
    """
    names = {**HELPERS, **(extra or {})}
    exec(compile(source, "<generated>", "exec"), names)  # contains no user text: see the module's docstring
    function: Callable[..., Any] = names[name]
    return function


def _literal(value: float, truth: bool) -> str:
    if math.isnan(value):
        return "None" if truth else "nan"
    if truth:
        return str(bool(value))
    return (
        "inf" if value == math.inf else "(-inf)" if value == -math.inf else f"({value!r})" if value < 0 else repr(value)
    )
