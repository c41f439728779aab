"""Numpy evaluator of programs: the reference of the kernel, its replacement without a compiler, and values in series.

It computes many rows (snapshots) at once, and of each row all instructions of one kind and depth at once, so that a
single row of a hundred rules costs tens of numpy calls, not hundreds.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from .operators import INSTRUCTIONS, Form, Operator
from .program import Program, depths, operands

Numbers = NDArray[np.float64]
_CHUNK = 512  # rows at once: the registers of a hundred rules stay in the processor's cache


class Rows:
    """Evaluator of one program."""

    def __init__(self, program: Program) -> None:
        self._program = program
        rows = sorted(zip(depths(program), program.code.tolist(), strict=True), key=lambda row: (row[0], _kind(row[1])))
        self._batches = [
            _Batch(INSTRUCTIONS[kind[0]], [code for _, code in batch], program)
            for (_, kind), batch in groupby(rows, key=lambda row: (row[0], _kind(row[1])))
        ]

    def __call__(self, x: Numbers, t: Numbers, cells: Numbers) -> Numbers:
        """Registers of all rows, shape (registers, n).

        Args:
            x: Snapshots, SI units, shape (n, size).
            t: Their times [s], shape (n,).
            cells: State of the temporal operators, updated in place: shape (1, C) if the rows follow each other in
                time, (n, C) if each has its own state.
        """
        r = np.empty((len(self._program.registers), len(t)))
        r[:] = self._program.registers[:, np.newaxis]
        with np.errstate(all="ignore"):
            for batch in self._batches:
                batch.run(r, x, t, cells)
        return r

    def chunks(self, x: Numbers, t: Numbers, cells: Numbers) -> Iterator[tuple[slice, Numbers]]:
        """Rows that follow each other in time, in parts: slices of the rows, and their registers."""
        for start in range(0, len(t), _CHUNK):
            part = slice(start, start + _CHUNK)
            yield part, self(x[part], t[part], cells)


def _kind(code: list[int]) -> tuple[int, int]:
    """What instructions of one batch have in common: the operation, and the size of the groups that it reduces."""
    return code[0], code[1] if INSTRUCTIONS[code[0]].form is Form.GROUP else 0


class _Batch:
    """Instructions of one depth and kind."""

    def __init__(self, operator: Operator, codes: list[list[int]], program: Program) -> None:
        self._operator, self._codes = operator, codes
        self._constants = [program.registers[code[5] :][:4].tolist() for code in codes]
        groups = [operands(code) for code in codes]
        if operator.form is Form.EACH:
            self._dst = np.array([code[2] + i for code in codes for i in range(code[1])])
            self._from = [np.concatenate([group[i] for group in groups]) for i in range(operator.operands)]
        else:
            self._dst = np.array([code[2] for code in codes])
            self._from = [np.array([group[i] for group in groups]) for i in range(operator.operands)]
        self._loads = np.array([code[3] + i for code in codes for i in range(code[1])])

    def run(self, r: Numbers, x: Numbers, t: Numbers, cells: Numbers) -> None:
        operator = self._operator
        if operator.numpy is None:
            r[self._dst] = x[:, self._loads].T
        elif operator.form in (Form.CELLS, Form.RING):
            self._remember(r, t, cells)
        else:
            r[self._dst] = operator.numpy(*(r[at] for at in self._from))

    def _remember(self, r: Numbers, t: Numbers, cells: Numbers) -> None:
        function = self._operator.numpy
        assert function is not None
        for (_, _, dst, *_, cell), k, at in zip(
            self._codes, self._constants, zip(*self._from, strict=True), strict=True
        ):
            args = zip(*(r[i].ravel().tolist() for i in at), strict=True)
            width = self._operator.cells or 2 + 2 * int(k[3])
            if len(cells) == 1:
                state = cells[0, cell : cell + width].tolist()
                r[dst] = [function(state, time, k, *values) for time, values in zip(t.tolist(), args, strict=True)]
                cells[0, cell : cell + width] = state
            else:
                for lane, (time, values) in enumerate(zip(t.tolist(), args, strict=True)):
                    state = cells[lane, cell : cell + width].tolist()
                    r[dst, lane] = function(state, time, k, *values)
                    cells[lane, cell : cell + width] = state
