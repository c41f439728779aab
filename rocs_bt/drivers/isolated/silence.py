"""Silence: supervision of the answers of an isolated actuator's process."""

from __future__ import annotations

import pathlib
from contextlib import suppress

TICK = 0.02
"""Interval at which the process is supervised [s]."""

GRACE = 2 * TICK
"""Time after `max_age` within which the process's own watchdog must have acted [s]."""

HUNG = 1.0
"""Time without a command performed, although the device is in neutral, after which the driver counts as hung [s]; also
the longest silence of a process that waits for a processor [s]."""


class Silence:
    """Supervision of the answers of a process, counted in ticks.

    Of a pause between two ticks only a little counts, so that a machine or a main process that is held up does not make
    the process look hung. Nor does time count in which the threads of the process waited for a processor: the process
    is late then, up to `HUNG`.

    Args:
        max_age: Age of the last command at which the process sends the device to neutral [s].
        process: ID of the process.

    Attributes:
        late: Whether the process is silent for longer than it may, but waited for a processor.
    """

    def __init__(self, max_age: float, process: int) -> None:
        self.late = False
        self._limit = max_age + GRACE
        self._rest_limit = 0.5 * max_age
        self._process = process
        self._silent = 0.0  # [s] since the last answer, or since the first request after a rest
        self._starved = 0.0  # [s] of it in which the process waited for a processor
        self._before: float | None = None  # [s] that it had waited for a processor at the last tick
        self._rest = 0.0  # [s] since no request waits
        self._waiting = 0.0  # [s] since requests wait without a pause

    def after(self, pause: float, *, progress: bool, waiting: bool) -> str:
        """Count a tick.

        Args:
            pause: Time since the last tick [s].
            progress: Whether the process has answered in it.
            waiting: Whether it has not yet answered the newest request.

        Returns:
            Reason why the process counts as hung; empty if it does not.
        """
        counted = min(pause, 2 * TICK)
        starved = min(self._starvation(), counted)
        self._waiting = self._waiting + counted - starved if waiting else 0.0
        self._rest = 0.0 if waiting else self._rest + counted
        if progress or self._rest > self._rest_limit:  # commands have paused: the next one has the whole time
            self._silent = self._starved = 0.0
        if not progress:
            self._silent, self._starved = self._silent + counted, self._starved + starved
        most = max(HUNG, self._limit)
        self.late = self._silent > self._limit
        if self._silent - self._starved > self._limit:
            return f"has not answered for {self._limit:.3g} s"
        if self._silent > most:
            return f"has not answered for {most:.3g} s"
        return f"has not taken a command for {most:.3g} s" if self._waiting > most else ""

    def _starvation(self) -> float:
        """Time since the last tick for which threads of the process waited for a processor [s]."""
        if not self._waiting:  # as nearly always: a command is answered within a tick, and nothing is read
            self._before = None
            return 0.0
        before, now = self._before, waited_for_processor(self._process)
        self._before = now
        return 0.0 if before is None else max(now - before, 0.0)


def waited_for_processor(process: int) -> float:
    """Time for which all threads of a process were ready to run, but had no processor [s].

    It is 0 on systems that do not tell. A thread that sleeps, was stopped, or computes waits for none.
    """
    total = 0
    with suppress(OSError):
        for thread in pathlib.Path(f"/proc/{process}/task").iterdir():
            with suppress(OSError, ValueError, IndexError):  # the thread has ended
                total += int((thread / "schedstat").read_text().split()[1])
    return 1e-9 * total
