"""Threaded: the same blocks on wall time, a thread each, as in the paper's 5.2 (DESIGN 5).

A thread for every Monitor, Analyze, Plan and Execute. The reflex arc runs on the thread of the monitor whose sample
wakes it, and a HIGH submission wakes Execute; nothing is polled. A heartbeat notices a thread that ended, or hangs
in one turn for more than three of its periods.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from functools import partial

from ..analyze import Analyze
from ..clock import WallClock
from ..monitor import Monitor
from .agent import Agent

SWITCH_INTERVAL = 0.0005
"""[s] How long a thread that burns Python may keep the interpreter from the others; the default is 5 ms."""

_PATIENCE = 3  # periods that one turn may take before the block counts as hung


class Worker:
    """One block's thread.

    Args:
        agent: Whose block it is.
        block: Its name, for messages.
        period: How long a turn may normally take [s].
        wait: Sleeps until the next turn; False ends the thread.
        turn: One turn of the block.
    """

    def __init__(
        self, agent: Agent, block: str, period: float, wait: Callable[[], bool], turn: Callable[[], None]
    ) -> None:
        self.block = block
        self.period = period
        self.turns = 0
        self.busy = False
        self._agent = agent
        self._wait = wait
        self._turn = turn
        # A daemon: a block that hangs for ever must not keep the process from ending.
        self.thread = threading.Thread(target=self._run, name=f"{agent.name}/{block}", daemon=True)

    def _run(self) -> None:
        while self._wait():
            self.busy = True
            self._agent.guarded(self.block, self._turn)
            self.busy = False
            self.turns += 1


class ThreadedRunner:
    """Runs one agent's blocks in threads; a context manager.

    Args:
        agent: Built on a `WallClock`.
        clock: That clock.
    """

    def __init__(self, agent: Agent, clock: WallClock) -> None:
        self.agent = agent
        self._clock = clock
        self._stop = threading.Event()
        self.workers = self._build()
        self._heart = threading.Thread(target=self._beat, name=f"{agent.name}/heartbeat", daemon=True)
        self._switch_interval = sys.getswitchinterval()

    def __enter__(self) -> ThreadedRunner:
        sys.setswitchinterval(SWITCH_INTERVAL)
        for worker in self.workers:
            worker.thread.start()
        self._heart.start()
        return self

    def __exit__(self, *exc: object) -> None:
        self._stop.set()
        self.agent.pipeline.wake()
        self.agent.plan.inbox.wake()
        for analyze in self.agent.analyzes:
            analyze.inbox.wake()
        for worker in self.workers:
            worker.thread.join(timeout=_PATIENCE * worker.period)
        self._heart.join(timeout=1.0)
        self.agent.stop()
        sys.setswitchinterval(self._switch_interval)

    def _build(self) -> list[Worker]:
        agent, control = self.agent, self.agent.rates.control.period
        workers = []
        for monitor in agent.monitors:
            ticker = _Ticker(self._clock, control * monitor.rate.every, self._stop)

            turn = partial(self._sense, monitor, ticker)
            workers.append(Worker(agent, f"monitor {monitor.name}", ticker.period, ticker.wait, turn))
        for analyze in agent.analyzes:
            wait, turn = partial(self._wait_sample, analyze, control), partial(self._analyze, analyze)
            workers.append(Worker(agent, f"analyze {analyze.name}", control, wait, turn))
        plan_period = control * agent.rates.plan.every
        workers.append(Worker(agent, "plan", plan_period, self._wait_plan(plan_period), self._plan))
        workers.append(Worker(agent, "execute", control, self._wait_execute(control), self._execute))
        return workers

    def _sense(self, monitor: Monitor, ticker: _Ticker) -> None:
        monitor.run(self._clock.now(), ticker.count * monitor.rate.every)
        self.agent.react(self._clock.now())

    def _wait_sample(self, analyze: Analyze, period: float) -> bool:
        analyze.inbox.wait(period, self._stop.is_set)
        return not self._stop.is_set()

    def _analyze(self, analyze: Analyze) -> None:
        analyze.run(self._clock.now())

    def _plan(self) -> None:
        self.agent.plan.run(self._clock.now())

    def _execute(self) -> None:
        self.agent.execute.run(self._clock.now())

    def _wait_plan(self, period: float) -> Callable[[], bool]:
        deadline = [0.0]

        def wait() -> bool:
            remaining = deadline[0] - self._clock.now()
            if remaining > 0.0:
                self.agent.plan.inbox.wait(remaining, lambda: self._stop.is_set() or self.agent.plan.called)
            deadline[0] = self._clock.now() + period
            return not self._stop.is_set()

        return wait

    def _wait_execute(self, period: float) -> Callable[[], bool]:
        deadline = [0.0]

        def wait() -> bool:
            now = self._clock.now()
            urgent = self.agent.pipeline.wait(max(deadline[0] - now, 0.0))
            # After an urgent turn the phase starts anew, so that no action is acted twice in one period.
            now = self._clock.now()
            deadline[0] = now + period if urgent or now > deadline[0] + period else deadline[0] + period
            return not self._stop.is_set()

        return wait

    def _beat(self) -> None:
        """Count, in its own beats, for how long each block has been in the same turn.

        Beats and not seconds: when the whole process gets no processor, the heart does not beat either, and nobody
        is blamed.
        """
        seen: dict[str, tuple[int, int]] = {}
        period = self.agent.rates.control.period
        ticker = _Ticker(self._clock, period, self._stop)
        while ticker.wait():
            for worker in self.workers:
                turns, beats = seen.get(worker.block, (-1, 0))
                same = worker.busy and worker.turns == turns
                seen[worker.block] = (worker.turns, beats + 1 if same else 0)
                if same and (beats + 1) * period > _PATIENCE * worker.period:
                    self.agent.fail(worker.block, "hung", f"one turn took more than {_PATIENCE} periods")
                elif not worker.thread.is_alive() and not self._stop.is_set():
                    self.agent.fail(worker.block, "ended", "its thread is gone")


class _Ticker:
    """A periodic deadline that skips what it missed instead of catching up in a burst."""

    def __init__(self, clock: WallClock, period: float, stop: threading.Event) -> None:
        self.period = period
        self.count = -1
        self._clock = clock
        self._stop = stop

    def wait(self) -> bool:
        self.count = max(self.count + 1, int(self._clock.now() / self.period))
        return self._clock.wait_until(self.count * self.period, self._stop)
