"""Which values of a program can never be invalid, so that generated Python need not look."""

from __future__ import annotations

import math

from .program import REDUCTIONS, Op, Program, operands

_ALWAYS = {
    Op.NEG, Op.ABS, Op.SIGN, Op.SIDE, Op.HYPOT, Op.ATAN2, Op.MIN2, Op.MAX2, Op.CLIP, Op.SELECT, Op.LT, Op.LE, Op.EQ,
    Op.NE, Op.NOT, Op.AND, Op.OR, Op.MIN, Op.MAX, Op.ARGMIN, Op.ANY, Op.ALL, Op.COUNT, Op.MIN_VALID,
}  # fmt: skip
_SMALL = {Op.SIGN, Op.SIDE, Op.ATAN2, Op.ARGMIN, Op.COUNT, Op.WRAP}


class Sure:
    """What is known of the registers, first to last.

    Args:
        program: The program.
        fast: Whether the snapshots have no NaN.
    """

    def __init__(self, program: Program, fast: bool) -> None:
        registers = program.registers.tolist()
        constant = program.constant.tolist()
        self._valid = [known and not math.isnan(v) for known, v in zip(constant, registers, strict=True)]
        self._finite = [known and math.isfinite(v) for known, v in zip(constant, registers, strict=True)]
        self._nonzero = [finite and v != 0.0 for finite, v in zip(self._finite, registers, strict=True)]
        for op, n, dst, a, b, c, wide, _ in program.code.tolist():
            self._learn(Op(op), n, dst, a, b, c, wide, fast)

    def valid(self, register: int, n: int) -> bool:
        """Whether n registers from this one on are never invalid."""
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
        """Whether valid operands give a number."""
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
