"""Threads of an agent's blocks: worker, periodic timer, and switch interval of the Python interpreter."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ..base.clock import WallClock
from .agent import Agent

SWITCH_INTERVAL = 0.0005
"""Switch interval of the interpreter [s], after which a busy thread yields to others; Python's default is 5 ms."""

PATIENCE = 3
"""Number of periods within which it is detected that a block has ended or is late."""


@dataclass(frozen=True)
class Step:
    """Step of a worker's cycle."""

    block: str
    run: Callable[[], None]


class Worker:
    """Thread that runs a block in cycles until `wait` returns False, or the agent has failed or was stopped.

    Args:
        agent: Agent of the blocks.
        name: Name of the thread's block, for messages.
        steps: Steps of one cycle.
        wait: Function that sleeps until the next cycle; it returns False to end the thread.
        period: Normal maximum duration of a cycle [s].
        beat: Interval between calls of `late` [s].
        optional: Whether the block is a monitor of optional sensors only.
        check_heartbeat: Function that is called before each cycle, and that fails the agent if the heartbeat has ended.

    Attributes:
        patience: Duration of a cycle after which it counts as late [s].
        thread: Thread of the worker; a daemon, so that a hanging block does not keep the process alive.
    """

    def __init__(
        self,
        agent: Agent,
        name: str,
        steps: Sequence[Step],
        wait: Callable[[], bool],
        *,
        period: float,
        beat: float,
        optional: bool = False,
        check_heartbeat: Callable[[], None] = lambda: None,
    ) -> None:
        self.name = name
        self.optional = optional
        self.patience = PATIENCE * period
        self.thread = threading.Thread(target=self._run, name=f"{agent.name}/{name}", daemon=True)
        self._agent = agent
        self._steps = tuple(steps)
        self._wait = wait
        self._check_heartbeat = check_heartbeat
        self._limit = max(round(self.patience / beat), 1)
        self._turns = 0
        self._doing: str | None = None
        self._seen = -1
        self._beats = 0

    def late(self) -> str | None:
        """Name of the block that is late, or None. The heartbeat calls this once per beat.

        Beats are counted, and not seconds: if the whole process gets no CPU time, the heartbeat does not run either,
        and no failure must be reported.
        """
        doing, turns = self._doing, self._turns
        self._beats = self._beats + 1 if doing is not None and turns == self._seen else 0
        self._seen = turns
        return doing if self._beats >= self._limit else None

    @property
    def overdue(self) -> str:
        """Text of the reason why a block counts as late."""
        return f"one cycle has not ended after {PATIENCE} periods of {self.patience / PATIENCE:.3g} s"

    def _run(self) -> None:
        while self._wait() and self._agent.going:
            self._check_heartbeat()
            for step in self._steps:
                self._doing = step.block
                self._agent.guarded(step.block, step.run)
            self._doing = None
            self._turns += 1


class Ticker:
    """Periodic timer that skips missed deadlines instead of catching up in a burst.

    Args:
        clock: Clock of the deadlines.
        period: Time between two deadlines [s].
        stop: Event that ends the timer.
        phase: Time of the first deadline [s].

    Attributes:
        count: Index of the last deadline, from 0; -1 before the first.
    """

    def __init__(self, clock: WallClock, period: float, stop: threading.Event, phase: float = 0.0) -> None:
        self.period = period
        self.count = -1
        self._phase = phase
        self._clock = clock
        self._stop = stop

    def wait(self) -> bool:
        """Sleep until the next deadline; False if the timer was stopped."""
        self.count = max(self.count + 1, int((self._clock.now() - self._phase) / self.period))
        return self._clock.wait_until(self.count * self.period + self._phase, self._stop)


class FastSwitching:
    """Setter of a short switch interval of the interpreter while at least one threaded runner is active.

    The switch interval is global to the process: the first runner sets it, the last one restores it.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._runners = 0
        self._before = 0.0

    def enter(self) -> None:
        """Register a runner; the first one shortens the interval."""
        with self._lock:
            if self._runners == 0:
                self._before = sys.getswitchinterval()
                sys.setswitchinterval(SWITCH_INTERVAL)
            self._runners += 1

    def leave(self) -> None:
        """Unregister a runner; the last one restores the interval."""
        with self._lock:
            self._runners -= 1
            if self._runners == 0:
                sys.setswitchinterval(self._before)


FAST_SWITCHING = FastSwitching()
