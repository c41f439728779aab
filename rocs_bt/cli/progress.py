"""Progress of commands that take long: a bar on a terminal, elsewhere a line now and then."""

from __future__ import annotations

import sys
from types import TracebackType
from typing import Any

from ..base.clock import WallClock
from .terminal import discard_if_closed, echo, safe

_PATIENCE = 1.0  # [s] before the bar is shown
_INTERVAL = 60.0  # [s] between two lines where there is no terminal


class ProgressBar:
    """Progress on stderr: a bar after one second on a terminal, else a line a minute.

    The commands call it with the amount of work done so far:

        with ProgressBar("exp1", total=60.0) as progress:
            run(..., progress=progress)

    Args:
        what: Description of the work.
        total: Total amount of work.
        unit: Unit of the total and of the amount done.
    """

    def __init__(self, what: str, total: float, unit: str = "s simulated") -> None:
        self._what = what
        self._total = total
        self._unit = unit
        self._clock = WallClock()
        self._terminal = sys.stderr.isatty()
        self._next_line = _INTERVAL
        self._bar: Any = None
        self._task: Any = None

    def __enter__(self) -> ProgressBar:
        return self

    def __call__(self, done: float) -> None:
        """Show that the amount `done` of the total is finished."""
        if not self._terminal:
            self._print_line(done)
            return
        if self._bar is None and self._clock.now() < _PATIENCE:
            return
        with discard_if_closed():
            if self._bar is None:
                self._start()
            self._bar.update(self._task, completed=min(done, self._total))

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            with discard_if_closed():
                self._bar.stop()

    def _print_line(self, done: float) -> None:
        if (now := self._clock.now()) < self._next_line:
            return
        self._next_line = now + _INTERVAL
        share = f"{min(done, self._total):.0f} of at most {self._total:.0f} {self._unit}"
        echo(f"{self._what}: {share} after {now:.0f} s", err=True)

    def _start(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
        from rich.progress import Progress as Bar

        digits = 1 if self._unit.startswith("s ") else 0
        count = TextColumn(f"{{task.completed:.{digits}f}} of at most {{task.total:.0f}} {self._unit}")
        left = TimeRemainingColumn()
        self._bar = Bar(
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            count,
            TimeElapsedColumn(),
            TextColumn("left"),
            left,
            console=Console(stderr=True),
            transient=True,
        )
        self._bar.start()
        self._task = self._bar.add_task(safe(self._what), total=self._total)
