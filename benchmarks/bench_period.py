"""Length of a control period: Python calls of the engine, and the files that they are in.

The median period of each experiment in lockstep, without a recording. Calls of numpy and of the standard library do not
count. A period begins with Execute of the first agent, so EXP3 counts the work of both agents.
"""

from __future__ import annotations

import statistics
import sys
from collections.abc import Iterator
from pathlib import Path
from types import FrameType
from typing import Any

from row import Row, size

import rocs_bt
from rocs_bt.execute import Execute

ENGINE = str(Path(rocs_bt.__file__).parent)
SCENARIOS = {"exp1": (120, 25), "exp3": (None, None)}  # targets of one agent's period: calls, files
DURATION = size(10.0, 1.0)  # [s] simulated


class Counter:
    """Profile function that counts the engine's calls, a period at a time."""

    def __init__(self) -> None:
        self.periods: list[tuple[int, int]] = []
        self._calls, self._files, self._first = 0, set[str](), None

    def __call__(self, frame: FrameType, event: str, argument: Any) -> None:
        code = frame.f_code
        if event != "call" or not code.co_filename.startswith(ENGINE):
            return
        if code is Execute.run.__code__:
            execute = frame.f_locals["self"]
            self._first = self._first or execute
            if execute is self._first:
                self.periods.append((self._calls, len(self._files)))
                self._calls, self._files = 0, set()
        self._calls += 1
        self._files.add(code.co_filename)


def run() -> Iterator[Row]:
    """The rows of this benchmark."""
    for name, targets in SCENARIOS.items():
        counter = Counter()
        sys.setprofile(counter)
        try:
            rocs_bt.run(name, duration=DURATION)
        finally:
            sys.setprofile(None)
        periods = counter.periods[2:]  # the first contains the set-up
        for what, values, target in zip(("calls", "files"), zip(*periods, strict=True), targets, strict=True):
            median = statistics.median(values)
            budget = "" if target is None else f"<= {target}"
            yield Row(
                f"{name}, {what} in the median control period",
                median,
                what,
                budget=budget,
                holds=None if target is None else median <= target,
            )
