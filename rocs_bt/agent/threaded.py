"""Threaded: the same blocks on wall time, a thread each, as in the paper's 5.2 (docs/architecture.md).

A thread for every Monitor, Analyze, Plan and Execute. The reflex arc runs on the thread of the monitor whose sample
wakes it, and a HIGH submission wakes Execute; nothing is polled. A heartbeat notices a thread that ended, or that
hangs, within three of its block's periods; the threads notice the heartbeat's own death.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial

from ..analyze import Analyze
from ..clock import WallClock
from ..knowledge.share import Sharing
from ..monitor import Monitor
from .agent import Agent
from .heartbeat import Heartbeat
from .worker import PACE, Step, Ticker, Worker

_UNWATCHED = 1.5  # control periods without a sample, after which the reflexes are evaluated without one
_SHARED = 0.2  # [s] that a turn of sharing may normally take
_REST = 4.0  # times as long as its last turn took sharing rests: whoever floods it gets a fifth of a processor


class ThreadedRunner:
    """Runs one agent's blocks in threads; a context manager. Leaving it ends the threads, and stops the agent.

    Args:
        agent: Built on a `WallClock`.
        clock: That clock.

    Attributes:
        workers: The blocks' threads.
    """

    def __init__(self, agent: Agent, clock: WallClock) -> None:
        self.agent = agent
        self._clock = clock
        self._period = agent.rates.control.period
        self._stop = threading.Event()
        # Spread over the period, so that blocks do not wait for each other's turn at the interpreter.
        self._spread = self._period / (len(agent.monitors) + 2)
        self._act_at = self._period - self._spread
        self._plan_at = self._plan_called_at = self._rested_at = 0.0
        self._heartbeat = Heartbeat(agent, clock, self._period - 0.5 * self._spread, self._stop)
        self._heartbeat.workers = self.workers = self._build()

    def __enter__(self) -> ThreadedRunner:
        PACE.enter()
        for worker in self.workers:
            worker.thread.start()
        self._heartbeat.start()
        return self

    def __exit__(self, *exc: object) -> None:
        self.agent.brake()  # before waiting for any thread
        self._stop.set()
        self.agent.pipeline.wake()
        self.agent.plan.inbox.wake()
        if self.agent.sharing is not None:
            self.agent.sharing.awake.set()
        for analyze in self.agent.analyzes:
            analyze.inbox.wake()
        for worker in self.workers:  # one that hangs is left behind: it is a daemon, and ends when its turn does
            worker.thread.join(timeout=worker.patience)
        self._heartbeat.join()
        self.agent.stop()
        PACE.leave()

    def _build(self) -> list[Worker]:
        agent, period = self.agent, self._period
        workers = [self._sensing(monitor, i * self._spread) for i, monitor in enumerate(agent.monitors)]
        workers.append(self._worker("reflexes", period, self._wait_unwatched, Step("reflexes", self._react)))
        workers += [self._analysing(analyze) for analyze in agent.analyzes]
        plan, execute = Step("plan", self._at(agent.decide)), Step("execute", self._at(agent.execute.run))
        workers.append(self._worker("plan", agent.rates.plan.every * period, self._wait_plan, plan))
        workers.append(self._worker("execute", period, self._wait_execute, execute))
        if agent.sharing is not None:
            share = Step("sharing", partial(self._share, agent.sharing))
            workers.append(self._worker("sharing", _SHARED, partial(self._wait_share, agent.sharing), share))
        return workers

    def _sensing(self, monitor: Monitor, phase: float) -> Worker:
        ticker = Ticker(self._clock, self._period * monitor.rate.every, self._stop, phase)
        name = f"monitor {monitor.name}"

        def sense() -> None:
            monitor.run(self._clock.now(), ticker.count * monitor.rate.every)

        return self._worker(name, ticker.period, ticker.wait, Step(name, sense), Step("reflexes", self._react))

    def _analysing(self, analyze: Analyze) -> Worker:
        name = f"analyze {analyze.name}"
        return self._worker(name, self._period, partial(self._wait_sample, analyze), Step(name, self._at(analyze.run)))

    def _worker(self, name: str, period: float, wait: Callable[[], bool], *steps: Step) -> Worker:
        return Worker(
            self.agent, name, steps, wait, period=period, beat=self._period, check_heartbeat=self._heartbeat.check
        )

    def _at(self, turn: Callable[[float], None]) -> Callable[[], None]:
        return lambda: turn(self._clock.now())

    def _react(self) -> None:
        self.agent.react(self._clock.now())

    def _wait_unwatched(self) -> bool:
        """Wait until no monitor has evaluated the reflexes for a while: they must see that their signals are stale."""
        patience, since = _UNWATCHED * self._period, self._clock.now()
        while True:
            if not self._clock.wait_until(max(since, self.agent.reacted) + patience, self._stop):
                return False
            if self._clock.now() >= self.agent.reacted + patience:
                return True

    def _wait_sample(self, analyze: Analyze) -> bool:
        analyze.inbox.wait(threading.TIMEOUT_MAX, self._stop.is_set)
        return not self._stop.is_set()

    def _wait_plan(self) -> bool:
        """Wait until the plan is due or called; like in lockstep, it runs at most once a control period."""
        plan, now = self.agent.plan, self._clock.now
        if not self._clock.wait_until(self._plan_called_at + self._period, self._stop):
            return False
        if (remaining := self._plan_at - now()) > 0.0:
            plan.inbox.wait(remaining, lambda: self._stop.is_set() or plan.called)
        self._plan_called_at = now()
        self._plan_at = self._plan_called_at + self.agent.rates.plan.every * self._period
        return not self._stop.is_set()

    def _wait_execute(self) -> bool:
        """Wait until the control period is over, or something else than what Execute serves is on top."""
        pipeline, now = self.agent.pipeline, self._clock.now
        while pipeline.wait(max(self._act_at - now(), 0.0)):
            if self._stop.is_set():
                return False
            if pipeline.top() is not self.agent.execute.running:
                self._act_at = now() + self._period  # the phase starts anew, so that nothing is acted twice in a period
                return True
        late = now() > self._act_at + self._period
        self._act_at = (now() if late else self._act_at) + self._period
        return not self._stop.is_set()

    def _wait_share(self, sharing: Sharing) -> bool:
        """Wait until there is something to share, or the period is over; not more often than is allowed."""
        sharing.awake.wait(self._period)
        return self._clock.wait_until(max(sharing.due_at, self._rested_at), self._stop)

    def _share(self, sharing: Sharing) -> None:
        begun = self._clock.now()
        sharing.run(begun)
        ended = self._clock.now()
        self._rested_at = ended + min(_REST * (ended - begun), _SHARED)
