"""Threaded mode: the blocks of an agent on wall time, one thread each (paper, 5.2; docs/architecture.md).

Every monitor and analyser, Plan and Execute have a thread each. The reflex arc runs in the thread of the monitor that
supplied its trigger sample, and an action with HIGH priority wakes Execute, so nothing is polled. A heartbeat detects a
thread that has ended or is late, within three periods of its block; the threads detect the end of the heartbeat.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from functools import partial

from ..analyze import Analyze
from ..base.clock import WallClock
from ..interfaces.service import Service
from ..monitor import Monitor
from .agent import Agent
from .lateness import LONGEST, Lateness, load
from .worker import FAST_SWITCHING, PATIENCE, Step, Ticker, Worker

_UNWATCHED = 1.5  # number of control periods without a sample after which the reflexes are evaluated anyway
_SHARED = 0.2  # [s] normal maximum duration of a cycle of knowledge sharing
_REST = 4.0  # pause of sharing per duration of its last cycle, so that sharing uses at most 1/5 of a CPU


class ThreadedRunner:
    """Runner of one agent's blocks in threads; a context manager that ends the threads and stops the agent on exit."""

    def __init__(self, agent: Agent, clock: WallClock) -> None:
        self.agent = agent
        self._clock = clock
        self._period = agent.rates.control.period
        self._stop = threading.Event()
        # Start times are spread over the period, so that blocks do not compete for the interpreter lock.
        self._spread = self._period / (len(agent.monitors) + 2)
        self._act_at = self._period - self._spread
        self._plan_at = self._plan_called_at = self._rested_at = 0.0
        self._heartbeat = Heartbeat(agent, clock, self._period - 0.5 * self._spread, self._stop)
        self._heartbeat.workers = self.workers = self._build()

    def __enter__(self) -> ThreadedRunner:
        self.agent.execute.prepare()
        FAST_SWITCHING.enter()
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
        for worker in self.workers:  # a thread that hangs is not waited for: it is a daemon
            worker.thread.join(timeout=worker.patience)
        self._heartbeat.join()
        self.agent.stop()
        FAST_SWITCHING.leave()

    def _build(self) -> list[Worker]:
        agent, period = self.agent, self._period
        workers = [self._sensing(monitor, i * self._spread) for i, monitor in enumerate(agent.monitors)]
        # Reflexes run on the thread of a monitor, right after its sample. This worker runs them when no sample comes,
        # because a guard may also hold for signals that have become stale.
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

        steps = Step(name, sense), Step("reflexes", self._react)
        return self._worker(name, ticker.period, ticker.wait, *steps, optional=monitor.name in self.agent.optional)

    def _analysing(self, analyze: Analyze) -> Worker:
        name = f"analyze {analyze.name}"
        return self._worker(name, self._period, partial(self._wait_sample, analyze), Step(name, self._at(analyze.run)))

    def _worker(
        self, name: str, period: float, wait: Callable[[], bool], *steps: Step, optional: bool = False
    ) -> Worker:
        check = self._heartbeat.check
        return Worker(
            self.agent, name, steps, wait, period=period, beat=self._period, optional=optional, check_heartbeat=check
        )

    def _at(self, turn: Callable[[float], None]) -> Callable[[], None]:
        return lambda: turn(self._clock.now())

    def _react(self) -> None:
        self.agent.react(self._clock.now())

    def _wait_unwatched(self) -> bool:
        """Wait until the reflexes have not been evaluated for `_UNWATCHED` periods, so that signals may be stale."""
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
        """Wait until the plan is due or called. As in lockstep mode, it runs at most once per control period."""
        plan, now = self.agent.plan, self._clock.now
        if not self._clock.wait_until(self._plan_called_at + self._period, self._stop):
            return False
        while (remaining := self._plan_at - now()) > 0.0 and not self._stop.is_set():
            patience = self._clock.wall_time(remaining)
            if plan.inbox.wait(patience, lambda: self._stop.is_set() or plan.called) or plan.called:
                break
        self._plan_called_at = now()
        self._plan_at = self._plan_called_at + self.agent.rates.plan.every * self._period
        return not self._stop.is_set()

    def _wait_execute(self) -> bool:
        """Wait for the end of the control period, or until another ticket has the highest priority."""
        pipeline, now = self.agent.pipeline, self._clock.now
        wall_time = self._clock.wall_time
        while (called := pipeline.wait(wall_time(max(self._act_at - now(), 0.0)))) or now() < self._act_at:
            if self._stop.is_set():
                return False
            if called and pipeline.top() is not self.agent.execute.running:
                self._act_at = now() + self._period  # the next period begins now: at most one action step per period
                return True
        late = now() > self._act_at + self._period
        self._act_at = (now() if late else self._act_at) + self._period
        return not self._stop.is_set()

    def _wait_share(self, sharing: Service) -> bool:
        """Wait until there is something to share or the control period is over, and the next cycle is allowed."""
        sharing.awake.wait(self._period)
        return self._clock.wait_until(max(sharing.due_at, self._rested_at), self._stop)

    def _share(self, sharing: Service) -> None:
        begun = self._clock.now()
        sharing.run(begun)
        ended = self._clock.now()
        self._rested_at = ended + min(_REST * (ended - begun), _SHARED)


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
            if not why:
                self._reported.discard(worker.name)
            elif worker.name not in self._reported:
                self._reported.add(worker.name)
                agent.report_missing(worker.name, why)
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
