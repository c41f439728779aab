"""Threads on wall time with mock devices."""

import random
import sys
import threading
import time
from contextlib import contextmanager

import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel

from rocs_bt.agent import ThreadedRunner
from rocs_bt.agent.worker import FAST_SWITCHING, FastSwitching, Step, Ticker, Worker
from rocs_bt.base.clock import SimulatedClock, WallClock
from rocs_bt.event import ActuatorCommanded, BlockFailed, Change, ListSink, RuleChanged, TicketChanged
from rocs_bt.plan import Plan
from rocs_bt.running import SinkThread
from rocs_bt.testing.mock_agent import mock_rates

from ..waiting import until

pytestmark = pytest.mark.usefixtures("awake")

ENDS = ("SUCCEEDED", "FAILED", "CANCELLED")


def of(sink, kind, **values):
    return [e for e in list(sink.events) if isinstance(e, kind) and all(getattr(e, k) == v for k, v in values.items())]


@pytest.fixture(autouse=True)
def clean():
    """After each test there is no thread more than before, and the interpreter's pace is what it was."""
    threads, interval = set(threading.enumerate()), sys.getswitchinterval()
    yield
    until(lambda: not set(threading.enumerate()) - threads)
    assert sys.getswitchinterval() == interval


def started(make_agent, *args, **kwargs):
    clock = WallClock(running=False)
    made = make_agent(clock, *args, **kwargs)
    clock.start()
    return clock, *made


@contextmanager
def moving(stage, clock):
    """The mock world moves on meanwhile: wheels that turn while nothing changes would mean broken sensors."""
    stop = threading.Event()

    def move():
        ticker = Ticker(clock, 0.02, stop)
        while ticker.wait():
            stage.world.advance(ticker.period)

    thread = threading.Thread(target=move)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()


class Burn(Behaviour):
    """A leaf that burns 50 ms of Python in each tick."""

    def update(self):
        end = time.thread_time() + 0.05
        while time.thread_time() < end:
            sum(i * i for i in range(50))
        return Status.RUNNING


def burning(mission):
    leaves = [mission.act("GoTo", goal="goal"), Burn("Burn")]
    return Parallel("both", ParallelPolicy.SuccessOnAll(synchronise=False), leaves)


def test_no_high_action_is_lost_overtaken_or_late(make_agent):
    clock, agent, stage, sink, ahead = started(make_agent, burning)
    rng, never = random.Random(7), threading.Event()
    with moving(stage, clock), ThreadedRunner(agent, clock):
        until(lambda: of(sink, ActuatorCommanded, route="deliberative"))
        for _ in range(25):
            for distance in (rng.choice([0.15, 0.18, 0.3]), 9.0):
                ahead(distance)
                clock.wait_until(clock.now() + rng.uniform(0.01, 0.12), never)
        until(lambda: agent.arc.active is None)
        count = len(of(sink, ActuatorCommanded, route="deliberative"))
        until(lambda: len(of(sink, ActuatorCommanded, route="deliberative")) > count)  # the plan goes on
    assert agent.failure is None
    fired = [e for e in of(sink, RuleChanged) if e.phase in ("fired", "fired again")]
    assert len(fired) >= 5
    high = {}
    for e in of(sink, TicketChanged, priority="HIGH"):
        high.setdefault(e.ticket, []).append(e)
    assert len(high) == len(fired)
    for states in high.values():
        assert states[0].state == "QUEUED"
        assert states[-1].state in ENDS
        began = [e for e in states if e.state == "RUNNING"]
        # One that a stronger rule or its own release took back at once may never have run; no other waits.
        assert began or states[-1].state == "CANCELLED"
        assert all(e.t - states[0].t < 1.0 for e in began)  # promised is a period of 0.05 s
    overtaken(list(sink.events))


def overtaken(events):
    waiting, running = set(), set()
    for e in events:
        if isinstance(e, TicketChanged) and e.priority == "HIGH":
            {"QUEUED": waiting.add, "RUNNING": running.add}.get(e.state, waiting.discard)(e.ticket)
            if e.state in ENDS:
                running.discard(e.ticket)
        elif isinstance(e, TicketChanged) and e.state == "RUNNING":
            assert not waiting
        elif isinstance(e, ActuatorCommanded) and e.route == "deliberative":
            assert not running


def test_two_agents_in_one_process(make_agent):
    first, second = started(make_agent, name="R1"), started(make_agent, name="R1")
    one, two = ThreadedRunner(first[1], first[0]), ThreadedRunner(second[1], second[0])
    before = sys.getswitchinterval()
    with two:
        one.__enter__()
        first[4](0.15)
        until(lambda: of(first[3], ActuatorCommanded, route="reactive"))
        until(lambda: of(second[3], ActuatorCommanded, route="deliberative"))
    assert not of(second[3], RuleChanged, phase="fired")
    assert sys.getswitchinterval() < before  # the other one still runs
    one.__exit__()
    assert first[1].failure is second[1].failure is None


def test_a_thread_that_ends_is_noticed(make_agent, monkeypatch):
    monkeypatch.setattr(threading, "excepthook", lambda args: None)

    class Gone(KeyboardInterrupt):
        pass

    class Leaf(Behaviour):
        def update(self):
            raise Gone

    clock, agent, stage, sink, _ = started(make_agent, lambda mission: Leaf("Leaf"))
    with ThreadedRunner(agent, clock):
        until(lambda: of(sink, BlockFailed))
    (failed,) = of(sink, BlockFailed)
    assert (failed.block, failed.kind) == ("plan", "ended")
    assert stage.robot.motion == [0.0, 0.0]


def test_the_reflexes_are_evaluated_though_no_monitor_calls(make_agent):
    """Whatever happens to the monitors' samples, stale signals must be seen."""
    clock, agent, _, sink, _ = started(make_agent)
    for monitor in agent.monitors:
        monitor.run = lambda t, count: threading.Event().wait(0.12)  # slow, but not hanging
    with ThreadedRunner(agent, clock):
        until(lambda: of(sink, RuleChanged, rule="avoid_collision/Blind", phase="fired"))


def test_a_plan_that_never_reads_its_changes_does_not_spin(make_agent):
    class Deaf(Plan):
        turns = 0

        def run(self, t):
            self.turns += 1

    def build(mission):
        return Deaf("deaf", **mission.parts)

    clock, agent, *_ = started(make_agent, build)
    with ThreadedRunner(agent, clock):
        agent.plan.replan("a test")
        until(lambda: clock.now() > 1.0)
        assert agent.plan.turns <= clock.now() / 0.05 + 2


def test_a_plan_runs_at_its_own_rate(make_agent):
    class Counted(Plan):
        turns = 0

        def run(self, t):
            self.changes()
            self.turns += 1

    clock, agent, _, sink, _ = started(make_agent, lambda m: Counted("counted", **m.parts), rates=mock_rates(plan=2.0))
    with ThreadedRunner(agent, clock):
        until(lambda: agent.plan.turns >= 4)  # however busy the machine is
        calls, t = len(of(sink, Change)), clock.now()
        assert agent.plan.turns <= 2.0 * t + 1 + calls < 20.0 * t


def test_after_a_failure_threads_rest(make_agent):
    clock, agent, _, sink, _ = started(make_agent)
    with ThreadedRunner(agent, clock) as runner:
        until(lambda: of(sink, ActuatorCommanded, route="deliberative"))
        agent.fail("a test", "raised", "on purpose")
        waiting = {f"analyze {analyze.name}" for analyze in agent.analyzes}  # for a sample, which nobody reads
        until(lambda: {worker.name for worker in runner.workers if worker.thread.is_alive()} <= waiting)
        count = len(sink.events)
        agent.plan.replan("a test")
        assert len(sink.events) == count


def test_a_failed_agent_names_the_actuator_that_does_not_stop(make_agent):
    _, agent, stage, _, _ = started(make_agent)

    def neutral():
        raise OSError("the wire is cut")

    stage.actuators["wheels"]._device.neutral = neutral
    agent.fail("plan", "raised", "on purpose")
    assert "actuator 'wheels' did not stop: ActuatorError: OSError: the wire is cut" in agent.reason


def test_only_the_first_failure_counts(make_agent):
    _, agent, _, sink, _ = started(make_agent)
    threads = [threading.Thread(target=agent.fail, args=(f"block {i}", "raised", "on purpose")) for i in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    (failed,) = of(sink, BlockFailed)
    assert failed.block in agent.reason


class Slow:
    """A worker in the midst of a turn."""

    def __init__(self, make_agent):
        self.go, self.ended, agent = threading.Event(), threading.Event(), started(make_agent)[1]
        turns = iter([True, False])
        self.worker = Worker(agent, "w", [Step("slow", self.go.wait)], lambda: next(turns), period=0.1, beat=0.05)


def test_a_worker_hangs_after_three_periods_of_beats(make_agent):
    slow = Slow(make_agent)
    assert slow.worker.late() is None
    slow.worker.thread.start()
    until(lambda: slow.worker._doing == "slow")
    asked = [slow.worker.late() for _ in range(6)]
    assert asked == [None] * 5 + ["slow"]  # three periods of 0.1 s are six beats of 0.05 s
    slow.go.set()
    slow.worker.thread.join()
    assert slow.worker.late() is None


def test_a_ticker_skips_what_it_missed():
    class Still(SimulatedClock):
        """Moves to a deadline at once."""

        def wait_until(self, deadline, stop):
            self.advance(max(0, round(deadline / self.step) - self.count))
            return not stop.is_set()

    clock, stop = Still(0.001), threading.Event()
    ticker = Ticker(clock, 0.01, stop, phase=0.003)
    ticks = []
    for missed in (0.0, 0.002, 0.055, 0.0):
        clock.advance(round(missed / clock.step))
        assert ticker.wait()
        ticks.append((ticker.count, clock.count))
    assert ticks == [
        (0, 3),
        (1, 13),
        (6, 68),
        (7, 73),
    ]  # of those at 23 to 63 ms the last one, late
    stop.set()
    assert not ticker.wait()


def test_the_pace_is_put_back_by_the_last_one():
    pace, before = FastSwitching(), sys.getswitchinterval()
    pace.enter()
    pace.enter()
    pace.leave()
    assert sys.getswitchinterval() < before
    pace.leave()
    assert sys.getswitchinterval() == pytest.approx(before)
    assert FAST_SWITCHING._runners == 0


def test_events_reach_the_sink_in_order_and_all_of_them():
    target = ListSink()
    with SinkThread(target) as sink:
        for i in range(2000):
            sink.emit(i)
    assert target.events == list(range(2000))


def test_a_sink_that_raises_is_told_at_the_end():
    class Broken:
        def emit(self, event):
            raise OSError("the disk is full")

    def use():
        with SinkThread(Broken()) as sink:
            sink.emit("something")

    with pytest.raises(OSError, match="the disk is full"):
        use()
