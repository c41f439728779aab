"""Threaded mode on wall time: a block that hangs or ends is found by the heartbeat, and the wheels stop at once.

Limits are many times what is promised, so that a busy machine passes too.
"""

import subprocess
import sys
import threading
import time

import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel

from rocs_bt.base.errors import DeviceError
from rocs_bt.event import ActuatorCommanded, BlockFailed, MotionHeld, RuleChanged
from rocs_bt.interfaces.action import AtomicAction, Progress
from rocs_bt.monitor import RangeMonitor
from rocs_bt.testing.faults import DeadSensor, HangingActuator, HangingSensor, break_actuator, break_sensor

from ..waiting import GUARD, until

pytestmark = pytest.mark.usefixtures("awake")

AT = 1.2  # [s] when it happens: the robot drives by then
SOON = 1.0  # [s] by when the robot must be held; promised are 0.15 s, and 0.3 s for the plan
LONG = SOON + 1.5  # [s] by when the block has failed; promised is 1 s more
NAP = 2.5  # [s] by the run's clock, which may stand still meanwhile


def sleep(clock):
    end = clock.now() + NAP
    while (remaining := end - clock.now()) > 0.0:
        time.sleep(remaining)


def burn(clock):
    end = clock.now() + NAP
    while clock.now() < end:
        sum(i * i for i in range(100))


class Once(Behaviour):
    """A leaf that does something for a while when its time has come, once."""

    def __init__(self, mission, what):
        super().__init__("Once")
        self.mission, self.what, self.began = mission, what, None

    def update(self):
        if self.began is None and self.mission.clock.now() >= AT:
            self.began = self.mission.clock.now()
            self.what(self.mission.clock)
        return Status.RUNNING


class Doze(AtomicAction):
    """An action that drives, and falls asleep when its time has come, or later while a reflex acts."""

    began = AT

    def act(self, body):
        if body.clock.now() >= AT:
            Doze.began = body.clock.now()
            sleep(body.clock)
        body.motion.command([0.3, 0.3])
        return Progress.RUNNING


def beside(what):
    def build(mission):
        leaves = [mission.act("GoTo", goal="goal"), Once(mission, what)]
        return Parallel("both", ParallelPolicy.SuccessOnAll(synchronise=False), leaves)

    return build


def nothing_left(before):
    """Wait until no thread is there but those that were there before the run."""
    until(lambda: not set(threading.enumerate()) - before)


def check(run, block, before, began=AT):
    """What holds for each of them."""
    (failed,) = run.of(BlockFailed)
    assert (failed.block, failed.kind) == (block, "hung")
    assert began < min(held.t for held in run.of(MotionHeld)) < began + SOON
    assert began + 1.0 < failed.t < began + LONG
    assert run.driven == [False]
    assert run.agent.outcome == "error"
    assert f"block 'R2/{block}' hung" in run.agent.reason
    after = [e for e in run.of(ActuatorCommanded) if e.t > failed.t]
    assert not any(any(e.values) for e in after)
    with pytest.raises(DeviceError, match="shut"):
        run.stage.actuators["R2"]["wheels"].command([0.3, 0.3])
    nothing_left(before)
    assert run.coast() < 0.02


@pytest.fixture
def before():
    """The threads and the switch interval before a run; afterwards they must be the same."""
    interval, threads = sys.getswitchinterval(), set(threading.enumerate())
    yield threads
    assert sys.getswitchinterval() == interval


@pytest.fixture
def release():
    """Lets go of whoever hangs for ever, so that no thread outlives its test."""
    event = threading.Event()
    yield event
    event.set()


@pytest.mark.parametrize("what", [sleep, burn], ids=["sleeps", "burns"])
def test_a_leaf_that_does_not_return(what, broken, before):
    run = broken(mode="threaded", missions={"R2": beside(what)})
    check(run, "plan", before)


def test_an_action_that_sleeps(broken, before):
    run = broken(mode="threaded", missions={"R2": lambda mission: mission.act("Doze")})
    check(run, "execute", before, Doze.began)


def test_an_interpret_that_sleeps(broken, before, monkeypatch):
    sound, stages = RangeMonitor.interpret, []

    def interpret(self, readings):
        if stages and stages[0].clock.now() >= AT:
            sleep(stages[0].clock)
        return sound(self, readings)

    monkeypatch.setattr(RangeMonitor, "interpret", interpret)
    check(broken(stages.append, mode="threaded"), "monitor range", before)


def test_a_sensor_that_hangs_for_ever(broken, before, release):
    run = broken(lambda stage: break_sensor(stage, "encoders", HangingSensor, at=AT, release=release), mode="threaded")
    release.set()
    check(run, "monitor wheels", before)


def test_an_actuator_that_hangs_for_ever(broken, before, release):
    run = broken(
        lambda stage: break_actuator(stage, "wheels", HangingActuator, at=AT, release=release), mode="threaded"
    )
    assert not any(any(m.target) for m in run.stage.world._motors["R2"])
    release.set()  # the command goes on to the device, which must stay where it is
    check(run, "execute", before)


def test_dead_sensors_are_met_with_the_reflex(broken, before):
    def prepare(stage):
        for name in list(stage.sensors["R2"]):
            break_sensor(stage, name, DeadSensor, at=AT)

    run = broken(prepare, mode="threaded", duration=3.0)
    assert run.touched == []
    assert [e for e in run.of(RuleChanged) if e.phase == "fired" and e.rule.endswith("Blind") and e.t < AT + SOON]
    assert run.agent.outcome == "timeout"
    assert not any(any(m.target) for m in run.stage.world._motors["R2"])
    nothing_left(before)


def test_the_process_ends_while_a_device_hangs(tmp_path):
    code = (
        "import sys\n"
        "from rocs_bt import run\n"
        "from rocs_bt.testing.faults import HangingActuator, HangingSensor, break_actuator, break_sensor\n"
        "def prepare(stage):\n"
        "    break_actuator(stage, 'wheels', HangingActuator, at=0.5)\n"
        "    break_sensor(stage, 'sonar', HangingSensor, at=0.5)\n"
        "result = run('exp1', mode='threaded', out=sys.argv[1], prepare=prepare, duration=10.0)\n"
        "print(result.outcomes['R2'])\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path)], capture_output=True, text=True, timeout=GUARD, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "error"
    assert done.stderr == ""
    assert (tmp_path / "report.html").is_file()
