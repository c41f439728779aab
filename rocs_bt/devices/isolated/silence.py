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
the longest silence of a process that is late [s]."""


class Silence:
    """Supervision of the answers of a process, counted in ticks.

    Of a pause between two ticks only a little counts, so that a machine or a main process that is held up does not make
    the process look hung. Nor does time count in which the threads of the process waited for a processor: the process
    is late then, up to `HUNG`.

    Args:
        max_age: Age of the last command at which the process sends the device to neutral [s].
        process: ID of the process.
        patient: Whether every silence up to `HUNG` is lateness, as another way to the device exists.
    """

    def __init__(self, max_age: float, process: int, *, patient: bool = False) -> None:
        self.late = False  # silent for longer than it may, but not hung yet
        self._patient = patient
        self._limit = max_age + GRACE
        self._rest_limit = 0.5 * max_age
        self._process = process
        self._silent = 0.0  # [s] since the last answer, or since the first request after a rest
        self._starved = 0.0  # [s] of it in which the process waited for a processor
        self._before: float | None = None  # [s] that it had waited for a processor at the last tick
        self._ready: dict[str, float] = {}  # threads that were ready at the last tick
        self._rest = 0.0  # [s] since no request waits
        self._waiting = 0.0  # [s] since requests wait without a pause

    def after(self, pause: float, *, progress: bool, waiting: bool) -> str:
        """Count a tick; returns the reason why the process counts as hung, or an empty text.

        Args:
            pause: Time since the last tick [s].
            progress: Whether the process has answered in it.
            waiting: Whether it has not yet answered the newest request.
        """
        counted = min(pause, 2 * TICK)
        starved = min(self._starvation(pause), counted)
        self._waiting = self._waiting + counted - starved if waiting else 0.0
        self._rest = 0.0 if waiting else self._rest + counted
        if progress or self._rest > self._rest_limit:  # commands have paused: the next one has the whole time
            self._silent = self._starved = 0.0
        if not progress:
            self._silent, self._starved = self._silent + counted, self._starved + starved
        most = max(HUNG, self._limit)
        self.late = self._silent > self._limit
        if not self._patient and self._silent - self._starved > self._limit:
            return f"has not answered for {self._limit:.3g} s"
        if self._silent > most:
            return f"has not answered for {most:.3g} s"
        return f"has not taken a command for {most:.3g} s" if self._waiting > most else ""

    def _starvation(self, pause: float) -> float:
        """Time since the last tick for which threads of the process waited for a processor [s]."""
        if not self._waiting:  # as nearly always: a command is answered within a tick, and nothing is read
            self._before, self._ready = None, {}
            return 0.0
        before, now = self._before, waited_for_processor(self._process)
        ready, self._ready = self._ready, ready_threads(self._process)
        self._before = now
        ended = 0.0 if before is None else max(now - before, 0.0)
        lasting = max((pause - (ran - ready[name]) for name, ran in self._ready.items() if name in ready), default=0.0)
        return max(ended, lasting)


def waited_for_processor(process: int) -> float:
    """Time for which all threads of a process were ready to run, but had no processor, before they ran [s].

    The system adds a wait when it has ended; of one that lasts, `ready_threads` tells. The time is 0 on systems that do
    not tell. A thread that sleeps, was stopped, or computes waits for none.
    """
    total = 0
    with suppress(OSError):
        for thread in pathlib.Path(f"/proc/{process}/task").iterdir():
            with suppress(OSError, ValueError, IndexError):  # the thread has ended
                total += int((thread / "schedstat").read_text().split()[1])
    return 1e-9 * total


def ready_threads(process: int) -> dict[str, float]:
    """Time on a processor of each thread of a process that runs or is ready to run [s], by its ID."""
    found = {}
    with suppress(OSError):
        for thread in pathlib.Path(f"/proc/{process}/task").iterdir():
            with suppress(OSError, ValueError, IndexError):  # the thread has ended
                if (thread / "stat").read_text().rpartition(")")[2].split()[0] == "R":
                    found[thread.name] = 1e-9 * int((thread / "schedstat").read_text().split()[0])
    return found
