"""Heartbeat: supervisor of the threads of an agent's blocks in threaded mode; these threads supervise it, too."""

from __future__ import annotations

import threading
from collections.abc import Sequence

from ..clock import WallClock
from .agent import Agent
from .worker import PATIENCE, Ticker, Worker


class Heartbeat:
    """Thread that checks once per control period that no worker thread has ended or hangs.

    Each worker calls `check` before each of its cycles. If the heartbeat itself has ended or hangs, the first worker
    that calls `check` stops the wheels and reports the failure.

    Args:
        agent: Agent of the supervised workers.
        clock: Clock of the agent.
        phase: Offset of the first beat from the start of a control period [s].
        stop: Event that is set at the end of the run and ends the supervision.

    Attributes:
        workers: Supervised workers.
    """

    def __init__(self, agent: Agent, clock: WallClock, phase: float, stop: threading.Event) -> None:
        self.workers: Sequence[Worker] = ()
        self._agent = agent
        self._clock = clock
        self._stop = stop
        self._period = agent.rates.control.period
        self._ticker = Ticker(clock, self._period, stop, phase)
        self._missed = 0
        self._missed_at = 0.0
        self._thread = threading.Thread(target=self._run, name=f"{agent.name}/heartbeat", daemon=True)

    def start(self) -> None:
        """Start the thread, after the threads of the workers were started."""
        self._thread.start()

    def join(self) -> None:
        """Wait up to 1 s for the thread to end after the run."""
        self._thread.join(timeout=1.0)

    def check(self) -> None:
        """Stop the agent if the heartbeat's thread has ended or hangs; called by each worker before a cycle.

        Missed periods are counted, and not seconds: if the whole process gets no CPU time, the workers do not run
        either, and no failure must be reported.
        """
        if self._thread.ident is None or self._stop.is_set():
            return
        if not self._thread.is_alive():
            self._agent.fail("heartbeat", "ended", "its thread has ended")
        elif (now := self._clock.now()) >= self._missed_at + self._period:
            self._missed, self._missed_at = self._missed + 1, now
            if self._missed > PATIENCE:
                self._agent.fail("heartbeat", "hung", f"it has missed {PATIENCE} control periods")

    def _run(self) -> None:
        self._agent.guarded("heartbeat", self._beat)

    def _beat(self) -> None:
        while self._ticker.wait() and self._agent.going:
            for worker in self.workers:
                if (block := worker.hangs()) is not None:
                    self._agent.fail(block, "hung", worker.overdue)
                elif not worker.thread.is_alive() and not self._stop.is_set() and self._agent.going:
                    self._agent.fail(worker.name, "ended", "its thread has ended")
            self._missed, self._missed_at = 0, self._clock.now()
