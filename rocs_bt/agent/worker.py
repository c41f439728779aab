"""What threads are made of: a worker that runs a block's turns, its timer, and the pace of the interpreter."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ..clock import WallClock
from .agent import Agent

SWITCH_INTERVAL = 0.0005
"""[s] How long a thread that burns Python may keep the interpreter from the others; the default is 5 ms."""

PATIENCE = 3
"""Periods within which a block that ended or hangs is noticed."""


@dataclass(frozen=True)
class Step:
    """A part of a worker's turn, and the block that answers for it."""

    block: str
    run: Callable[[], None]


class Worker:
    """A thread that runs turns until it is told to end, or its agent failed or was stopped.

    Args:
        agent: Whose blocks these are.
        name: The thread's block, for messages.
        steps: One turn.
        wait: Sleeps until the next turn; False ends the thread.
        period: How long a turn may normally take [s].
        beat: How often `hangs` is asked [s].
        check_heartbeat: Called before each turn; fails the agent if the heartbeat has ended.

    Attributes:
        name: The thread's block.
        patience: How long a turn may take before it counts as hung [s].
        thread: The thread; a daemon, as a block that hangs for ever must not keep the process from ending.
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
        check_heartbeat: Callable[[], None] = lambda: None,
    ) -> None:
        self.name = name
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

    def hangs(self) -> str | None:
        """The block that hangs; None while all is well. Asked once a beat.

        Beats are counted and not seconds: when the whole process gets no processor the heart does not beat either,
        and nobody is blamed.
        """
        doing, turns = self._doing, self._turns
        self._beats = self._beats + 1 if doing is not None and turns == self._seen else 0
        self._seen = turns
        return doing if self._beats >= self._limit else None

    @property
    def overdue(self) -> str:
        """Why `hangs` says so, in words."""
        return f"one turn has not ended after {PATIENCE} periods of {self.patience / PATIENCE:.3g} s"

    def _run(self) -> None:
        while self._wait() and self._agent.going:
            self._check_heartbeat()
            for step in self._steps:
                self._doing = step.block
                self._agent.guarded(step.block, step.run)
            self._doing = None
            self._turns += 1


class Ticker:
    """A periodic deadline that skips what it missed instead of catching up in a burst.

    Args:
        clock: Time.
        period: Between two deadlines [s].
        stop: Ends it.
        phase: The first deadline [s].

    Attributes:
        period: Between two deadlines [s].
        count: How many deadlines came before the last one.
    """

    def __init__(self, clock: WallClock, period: float, stop: threading.Event, phase: float = 0.0) -> None:
        self.period = period
        self.count = -1
        self._phase = phase
        self._clock = clock
        self._stop = stop

    def wait(self) -> bool:
        """Sleep until the next deadline; False when it was stopped."""
        self.count = max(self.count + 1, int((self._clock.now() - self._phase) / self.period))
        return self._clock.wait_until(self.count * self.period + self._phase, self._stop)


class Pace:
    """Lets threads hand the interpreter over often while any runner of the process wants that.

    The switch interval is one number for the whole process: the first runner sets it, the last one puts it back.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._runners = 0
        self._before = 0.0

    def enter(self) -> None:
        """One more runner."""
        with self._lock:
            if self._runners == 0:
                self._before = sys.getswitchinterval()
                sys.setswitchinterval(SWITCH_INTERVAL)
            self._runners += 1

    def leave(self) -> None:
        """One runner less."""
        with self._lock:
            self._runners -= 1
            if self._runners == 0:
                sys.setswitchinterval(self._before)


PACE = Pace()
