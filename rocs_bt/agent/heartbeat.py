"""The heartbeat of threaded mode: watches the threads of an agent's blocks, and is watched by them."""

from __future__ import annotations

import threading
from collections.abc import Sequence

from ..clock import WallClock
from .agent import Agent
from .worker import PATIENCE, Ticker, Worker


class Heartbeat:
    """Checks once a control period that no worker has ended or hangs; a thread of its own.

    Its own death must not go unnoticed: every worker calls `check` before a turn, so the first worker whose turn comes
    stops the wheels and reports it.

    Args:
        agent: The agent whose workers it watches.
        clock: The agent's clock.
        phase: First beat, counted from the start of a control period [s].
        stop: Set at the end of the run: after it no thread is missed.

    Attributes:
        workers: The watched workers.
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
        """Start the thread. The workers' threads must run already."""
        self._thread.start()

    def join(self) -> None:
        """Wait for the thread's end after the run; not for ever."""
        self._thread.join(timeout=1.0)

    def check(self) -> None:
        """Stop the agent if the heartbeat's thread has ended or hangs; called by each worker before a turn.

        Like the heartbeat itself it counts periods and not seconds: when the whole process gets no processor, the
        workers have no turns either, and nothing is blamed.
        """
        if self._thread.ident is None or self._stop.is_set():
            return
        if not self._thread.is_alive():
            self._agent.fail("heartbeat", "ended", "its thread is gone")
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
                    self._agent.fail(worker.name, "ended", "its thread is gone")
            self._missed, self._missed_at = 0, self._clock.now()
