"""Wall time that stands still while the machine does, for tests of threads on a machine that is taken away at times.

A virtual machine may lose its processors for most of a second. To a robot that is a hang, and it is told as one; to a
test of something else it is nothing. A witness thread wakes often; of a gap between two of its turns only a little
more than it slept counts. Whatever belongs to the test shares one processor, so that a gap is a gap for all of it.

The price: threads under test run in turns, never at once, and who keeps the interpreter to himself for long stops this
time too. So `make soak` runs them once more with `pytest --real-time`: at once, by the wall clock itself.

`python tests/awake.py FILE ...` runs a file, or a folder's `__main__.py`, on such a time.
"""

from __future__ import annotations

import math
import os
import runpy
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

TURN = 0.005  # [s] between two turns of the witness
MOST = 0.006  # [s] that a gap between two turns may count


@contextmanager
def one_processor() -> Iterator[None]:
    """Threads and processes that are started in here share one processor, where the system has a way to say so."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    before, worker = os.sched_getaffinity(0), os.environ.get("PYTEST_XDIST_WORKER", "gw0")
    os.sched_setaffinity(0, {sorted(before)[int(worker[2:]) % len(before)]})
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


class Awake:
    """While its context is open `monotonic` is such a time [s]; afterwards it goes on as the wall clock does.

    It has the name of the standard library's function, so that it can stand in for the module `time` of a clock.

    Args:
        wall: The wall clock [s].
    """

    def __init__(self, wall: Callable[[], float] = time.monotonic) -> None:
        self._wall = wall
        self._stop = threading.Event()
        self._lock = threading.Lock()
        self._seen, self._counted, self._most = wall(), 0.0, MOST
        self._thread = threading.Thread(target=self._watch, name="witness", daemon=True)

    def __enter__(self) -> Awake:
        self._thread.start()
        return self

    def __exit__(self, *exc: object) -> None:
        self._stop.set()
        self._thread.join()
        self._most = math.inf

    def monotonic(self) -> float:
        """Time awake [s]."""
        with self._lock:
            return self._counted + min(self._wall() - self._seen, self._most)

    def turn(self) -> None:
        """The witness's turn: count the time since its last one, as far as it was awake."""
        with self._lock:
            now = self._wall()
            self._counted += min(now - self._seen, MOST)
            self._seen = now

    def _watch(self) -> None:
        while not self._stop.wait(TURN):
            self.turn()


if __name__ == "__main__":
    from rocs_bt.base import clock

    del sys.argv[0]
    with one_processor(), Awake() as clock.time:
        runpy.run_path(sys.argv[0], run_name="__main__")
