"""Heartbeat: supervisor of the threads of an agent's blocks in threaded mode; these threads supervise it, too."""

from __future__ import annotations

import threading
from collections.abc import Sequence

from ..base.clock import WallClock
from .agent import Agent
from .lateness import LONGEST, Lateness, load
from .worker import PATIENCE, Ticker, Worker


class Heartbeat:
    """Thread that checks once per control period that no worker thread has ended or is late.

    A block that is late stops the robot until its cycle has ended. If it is late too often or for too long, it has
    failed. A monitor of optional sensors only is reported, but stops nothing.

    Each worker calls `check` before each of its cycles. If the heartbeat itself is late or has ended, the first worker
    that calls `check` stops the wheels and reports it.

    Args:
        agent: Agent of the supervised workers.
        clock: Clock of the agent.
        phase: Offset of the first beat from the start of a control period [s].
        stop: Event that is set at the end of the run and ends the supervision.
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
        self._held = False  # whether the robot is held because the heartbeat is late
        self._lateness: dict[str, Lateness] = {}
        self._reported: set[str] = set()  # optional blocks that are late or have ended
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
            if self._missed * self._period > PATIENCE * self._period + LONGEST:
                self._agent.fail("heartbeat", "hung", f"it was late for more than {LONGEST:g} s")
            elif self._missed > PATIENCE and not self._held:
                self._held = True
                self._agent.hold(_notice("heartbeat"), "heartbeat")

    def _run(self) -> None:
        self._agent.guarded("heartbeat", self._beat)

    def _beat(self) -> None:
        while self._ticker.wait() and self._agent.going:
            for worker in self.workers:
                self._watch(worker)
            if self._held:
                self._held = False
                self._agent.resume("heartbeat", "the heartbeat, on time again")
            self._missed, self._missed_at = 0, self._clock.now()

    def _watch(self, worker: Worker) -> None:
        """Check one worker: whether its thread lives, and whether its cycle ends in time."""
        block, agent = worker.late(), self._agent
        ended = block is None and not worker.thread.is_alive() and not self._stop.is_set() and agent.going
        why = "its thread has ended" if ended else f"{worker.overdue}{load()}" if block is not None else ""
        if worker.optional and block in (None, worker.name):
            if why and worker.name not in self._reported:
                agent.report_missing(worker.name, why)
            (self._reported.add if why else self._reported.discard)(worker.name)
            block = None  # late, but it stops nothing
        elif ended:
            agent.fail(worker.name, "ended", why)
            return
        lateness = self._lateness.setdefault(worker.name, Lateness(self._period))
        before = lateness.late
        if failed := lateness.after(block is not None, self._clock.now()):
            agent.fail(block or worker.name, "hung", f"{failed}: {why}")
        elif block is not None and not before:
            agent.hold(_notice(block), f"late {worker.name}")
        elif block is None and before:
            agent.resume(f"late {worker.name}", f"{worker.name}, on time again")


def _notice(block: str) -> str:
    """Reason of a hold."""
    return f"{block} is late{load()}"
