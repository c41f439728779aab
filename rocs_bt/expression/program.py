"""Program: expressions compiled to one flat register program, in which common subexpressions are computed once.

**Registers.** A program computes an array `r` of float64. It begins as a copy of `Program.registers`, which contains
the constants; every other register is written by exactly one instruction, before it is read. A truth value is 1.0 or
0.0; NaN is *invalid*, for numbers and truth values. All instructions run in order at every step. There are no jumps,
because three-valued logic needs none (`False and invalid` is False in either order).

**Instructions.** Each row of `code` (int32, 8 columns) is one instruction: `op, n, dst, a, b, c, wide, cell`. A value
by value operation does `r[dst + i] = f(A, B, C)` for i in 0 .. n-1, where A is `r[a + i]` if bit 0 of `wide` is set and
`r[a]` if not; B and C likewise by bits 1 and 2. A reduction reads `r[a .. a+n-1]` and writes `r[dst]`. Unused operands
are 0. Every operation gives NaN if a required operand is NaN; the exceptions are listed below. Of equal values, minima
and maxima keep the first.

====================  ==========================================================================================
LOAD                  r[dst + i] = x[a + i], i in 0 .. n-1: the snapshot; the first instructions of a program
NEG ABS SIGN SIDE     -A; |A|; -1, 0 or 1; 1 where A >= 0, else -1
SQRT WRAP_ANGLE       root, NaN of A < 0; IEEE remainder by 2 pi, -pi becoming pi, NaN of an infinite A
ADD SUB MUL DIV       A + B ...; A / B is NaN where B == 0
HYPOT ATAN2           the C library's
MIN2 MAX2             B if B < A else A; B if B > A else A; NaN if either is
CLIP                  m = B if B > A else A, then C if C < m else m; NaN if any is
SELECT                A if C is 1, B if C is 0, NaN if C is NaN (the value not chosen may be invalid)
LT LE EQ NE           1.0 or 0.0; NaN if either is
NOT                   1 - A
AND OR                three-valued: 0 if either is 0, else NaN if either is, else 1; OR likewise
MIN MAX ARGMIN        of the n values; NaN if any is; ARGMIN is the first index, from 0
SUM                   ((r[a] + r[a+1]) + r[a+2]) ..., in this order
ANY ALL               OR, AND over the n values
COUNT                 number of values that are 1; NaN if any is NaN
MIN_VALID             minimum of the values that are not NaN; NaN if fewer than r[b] are
DOT                   r[a]*r[b] + r[a+1]*r[b+1] ..., in this order, each product rounded before it is added
HELD SINCE TIME_SINCE temporal, truth in (below)
RATE DELAY            temporal, numbers or truth in
GAP                   robustness margin of A < B: 0.0 if A == B, else (B - A) / C; NaN if any is
WORST BEST            margins joined by and, by or: m = the less of those that are not NaN; NaN if either operand is
                      and not m < 0. BEST is -WORST(-A, -B)
WORST_OF BEST_OF      WORST, BEST folded over the n values, from the first to the last
LOWEST SINCE_MARGIN   temporal, margins in
====================  ==========================================================================================

**Time.** A sample's value is valid from its own time until the next sample's. A window of length T at time t is
[t - T, t], so it contains the samples newer than t - T and the one valid at t - T. Times are compared with a tolerance
of 1e-9 s, which is included in the constants. The state is an array `cells` of float64 that begins as `Program.cells`;
`cell` is the first index of an instruction's part. Temporal operations have n = 1; at `r[c]` begin four constants:
`window` = T - 1e-9, `grain` = w - 1e-9, `before`, and `capacity` (below).

- HELD(A) over cells [p, q]: p is the start of the current run of samples that are not 0, q that of samples that are 1;
  +inf if there is none. A = 1: each cell that is +inf becomes t. A = NaN: q = +inf, and p becomes t if it is +inf.
  A = 0: both +inf. Gives 0 if not t - p >= window, else 1 if t - q >= window, else NaN. The initial cells define the
  value before the first sample: +inf for `held` (false), -inf if it counts as true (`once(a)` is NOT HELD(NOT a) so).
- SINCE(A, B) over cells [d, p], both -inf at first: end of validity of the newest sample at which B was certainly (d)
  or possibly (p) 1 and since which A was certainly or possibly 1; +inf while it is valid, -inf for none. First, each
  cell that is +inf becomes t. Then if B is 1, both become +inf; else, d = -inf unless A is 1, and p = +inf if B is NaN,
  -inf if B is 0 and A is 0. Gives 1 if t - d < window, else NaN if t - p < window, else 0.
- TIME_SINCE(A) over a cell [l], -inf at first: l = t if A is 1. Gives t - l, NaN if A is NaN.

The others keep a *ring buffer*: `[head, count, t0, v0, t1, v1, ...]` for `capacity` = floor(T / w) + 3 pairs, where w
is the larger of 10 ms and T / 256; `head` is the index of the oldest pair, and the others follow modulo `capacity`. A
sample is merged into the newest pair if its time is less than `grain` after that pair's, and otherwise begins a new
pair, so a ring never overflows; at steps of w or more the pairs are the samples. At every step, in this order: *drop*
the oldest pair while there is a second one, of time s, with t - s >= window; (SINCE_MARGIN: every v = WORST(v, A));
*push* t and the value, which is merged into the newest pair's v (RATE, DELAY: v is kept; LOWEST: WORST(v, value);
SINCE_MARGIN: BEST(v, value)) or begins a pair. Then with (s, v) the oldest pair, which *covers* the window if
t - s >= window:

- DELAY(A): v if the window is covered, else NaN.
- RATE(A): (A - v) / (t - s) if covered, else NaN.
- LOWEST(A): WORST over all v from the oldest on; if not covered, `before` is included as the first value.
- SINCE_MARGIN(A, B): -inf BEST all v from the oldest on. B is the pushed value.

If t is less than the time of the last step, all cells are first reset to `Program.cells`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .node import Node
from .operators import INSTRUCTIONS, Form

TOLERANCE = 1e-9  # [s]; periods such as 0.05 s have no exact sums
GRAIN = 0.01  # [s]; minimum time resolution of a ring buffer
PAIRS = 256  # number of intervals into which a ring buffer divides a long window


@dataclass(frozen=True, eq=False)
class Program:
    """Register program of several expressions; the module describes registers, instructions and time.

    Attributes:
        code: Instructions, int32, shape (n, 8), C order.
        registers: Initial values of the registers, float64: constants, and NaN elsewhere.
        cells: Initial state of the temporal operators, float64.
        roots: Register of each expression's value, int32, in the order of the expressions.
        margins: Register of each expression's robustness margin, int32; -1 if it has none, because its value is a
            number or its margin was not requested.
        temporal: Register of each temporal operator's value. Expressions that are evaluated outside the program use it.
        texts: Source text of the expression for each instruction, one per row of `code`.
        reads: Ranges (start, stop) of the snapshot that are read, in ascending order.
    """

    code: NDArray[np.int32]
    registers: NDArray[np.float64]
    cells: NDArray[np.float64]
    roots: NDArray[np.int32]
    margins: NDArray[np.int32]
    temporal: Mapping[Node, int]
    texts: tuple[str, ...]
    reads: tuple[tuple[int, int], ...]

    def listing(self) -> list[str]:
        """Lines for people, one for each instruction: `r9 = lt r8 0.4    min(front) < near`; x is the snapshot."""
        constants = {i: f"{value:g}" for i, value in enumerate(self.registers.tolist()) if value == value}
        lines = []
        for code, text in zip(self.code.tolist(), self.texts, strict=True):
            operator, dst = INSTRUCTIONS[code[0]], _span("r", code[2], size_of(code))
            if not operator.operands:
                lines.append(f"{dst} = {_span('x', code[3], code[1])}")
                continue
            args = [_operand(registers, constants) for registers in operands(code)]
            window = f" {self.registers[code[5]] + TOLERANCE:g} s" if operator.form in (Form.CELLS, Form.RING) else ""
            lines.append(f"{f'{dst} = {operator.name} ' + ' '.join(args) + window:<40}  {' '.join(text.split())}")
        return lines


def _operand(registers: Sequence[int], constants: Mapping[int, str]) -> str:
    """Text of an operand: its constants, or the span of its registers."""
    distinct = dict.fromkeys(registers)
    if registers[0] in constants:
        return " ".join(constants[register] for register in distinct)
    return _span("r", registers[0], len(distinct))


def _span(array: str, first: int, count: int) -> str:
    return f"{array}{first}" if count == 1 else f"{array}{first}..{first + count - 1}"


def operands(code: Sequence[int]) -> list[range | list[int]]:
    """Registers of each operand of an instruction, without those with the constants of a temporal operator."""
    op, n, _, a, b, c, wide, _ = code
    row = INSTRUCTIONS[op]
    if row.form is Form.GROUP:  # the second operand of `dot` is a vector, that of `min_valid` a number
        sizes = [n, n if row.name == "dot" else 1, 1]
        return [range(r, r + size) for r, size in zip((a, b, c)[: row.operands], sizes, strict=False)]
    firsts = (a, b, c)[: row.operands]
    return [range(r, r + n) if wide >> i & 1 else [r] * n for i, r in enumerate(firsts)]


def size_of(code: Sequence[int]) -> int:
    """Number of registers that an instruction writes."""
    return code[1] if INSTRUCTIONS[code[0]].form is Form.EACH else 1


def depths(program: Program) -> list[int]:
    """Depth of each instruction: one more than the greatest of its operands'."""
    found: list[int] = []
    at = [0] * len(program.registers)
    for code in program.code.tolist():
        depth = 1 + max((at[r] for group in operands(code) for r in group), default=0)
        found.append(depth)
        at[code[2] : code[2] + size_of(code)] = [depth] * size_of(code)
    return found


def ring_shape(window: float) -> tuple[float, int]:
    """Time resolution [s] and capacity [pairs] of a ring buffer for a window [s]."""
    width = max(GRAIN, window / PAIRS)
    return width, int(window / width) + 3
