"""An actuator whose driver raises: neutral first, then the run ends as an error, whatever commanded it."""

import contextlib

import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from rocs_bt.event import BlockFailed, ContentRaised
from rocs_bt.interfaces.action import AtomicAction, Progress
from rocs_bt.testing.faults import FaultyActuator, RaisingActuator, RefusingActuator, break_actuator

AT = 1.0  # [s]

DETAIL = {
    RaisingActuator: "RuntimeError: the driver of 'wheels' has a defect (faults.py:",
    RefusingActuator: "actuator 'wheels' does not answer.",
}


class Swallows(AtomicAction):
    """Drives, and catches whatever the wheels raise."""

    def act(self, body):
        with contextlib.suppress(Exception):  # the fault that is tested
            body.motion.command([0.2, 0.2])
        return Progress.RUNNING


class Wraps(AtomicAction):
    """Drives, and raises something of its own where the wheels raise."""

    def act(self, body):
        try:
            body.motion.command([0.2, 0.2])
        except Exception as error:  # the fault that is tested
            raise ValueError("no wheels") from error
        return Progress.RUNNING


class Drives(Behaviour):
    """A leaf that commands the wheels itself."""

    def __init__(self, gate):
        super().__init__("drives")
        self.gate = gate

    def update(self):
        self.gate.command([0.2, 0.2])
        return Status.RUNNING


def check(run, fault):
    (failed,) = run.of(BlockFailed)
    assert (failed.block, failed.kind, failed.owner) == ("wheels", "raised", "content")
    assert failed.detail.startswith(DETAIL[fault])
    assert AT <= failed.t < AT + 0.1
    assert run.driven == [False]
    assert run.agent.outcome == "error"
    assert run.agent.reason.startswith(f"actuator 'R2/wheels' raised: {DETAIL[fault]}")
    assert (run.agent.failed_block, run.agent.failed_owner) == ("wheels", "content")
    assert not run.of(ContentRaised)
    assert run.coast() < 0.02


@pytest.mark.parametrize("fault", DETAIL)
@pytest.mark.parametrize("action", ["Swallows", "Wraps", "SetWheelSpeed"])
def test_whatever_the_action_catches(action, fault, broken):
    parameters = {"speeds": [0.2, 0.2]} if action == "SetWheelSpeed" else {}
    run = broken(
        lambda stage: break_actuator(stage, "wheels", fault, at=AT),
        missions={"R2": lambda mission: mission.act(action, **parameters)},
        rules=(),
    )
    check(run, fault)


@pytest.mark.parametrize("fault", DETAIL)
def test_though_a_leaf_commands_it(fault, broken):
    stages = []

    def prepare(stage):
        stages.append(stage)
        break_actuator(stage, "wheels", fault, at=AT)

    def build(mission):
        return Drives(stages[0].actuators["R2"]["wheels"])

    check(broken(prepare, missions={"R2": build}, rules=()), fault)


@pytest.mark.parametrize("fault", DETAIL)
def test_while_a_reflex_drives(fault, broken):
    run = broken(lambda stage: break_actuator(stage, "wheels", fault, at=2.0), seed=3)
    (failed,) = run.of(BlockFailed)
    assert (failed.block, failed.owner) == ("wheels", "content")
    assert run.agent.outcome == "error"


class NeverNeutral(FaultyActuator):
    """An actuator that takes no command any more and does not go to neutral either."""

    def broken(self, values):
        raise RuntimeError("no command")

    def neutral(self):
        if self._clock.now() >= AT:
            raise RuntimeError("no neutral")
        self.actuator.neutral()


def test_one_that_does_not_go_to_neutral_is_told_so(broken):
    run = broken(lambda stage: break_actuator(stage, "wheels", NeverNeutral, at=AT))
    (failed,) = run.of(BlockFailed)
    assert (failed.block, failed.owner) == ("wheels", "content")
    assert "RuntimeError: no command" in failed.detail
    assert "and actuator 'wheels' did not stop: " in failed.detail
    assert "no neutral" in failed.detail
    assert run.agent.outcome == "error"


class Silent(FaultyActuator):
    """An actuator that takes commands and does not go to neutral."""

    def broken(self, values):
        self.actuator.command(values)

    def neutral(self):
        if self._clock.now() >= AT:
            raise RuntimeError("no neutral")
        self.actuator.neutral()


@pytest.mark.parametrize("duration", [2.0, 20.0], ids=["timeout", "success"])
def test_one_that_fails_when_it_is_stopped_at_the_end_is_an_error(duration, broken):
    run = broken(lambda stage: break_actuator(stage, "wheels", Silent), rules=(), duration=duration)
    (failed,) = run.of(BlockFailed)
    assert (failed.block, failed.owner, run.agent.outcome) == ("wheels", "content", "error")
    assert "no neutral" in run.agent.reason


def test_a_watchdog_whose_device_does_not_go_to_neutral_is_an_actuator_that_failed(broken):
    stages = []

    def prepare(stage):
        stages.append(stage)
        break_actuator(stage, "wheels", Silent)

    def build(mission):
        return Once(mission.clock, stages[0].actuators["R2"]["wheels"])

    run = broken(prepare, missions={"R2": build}, rules=())
    (failed,) = run.of(BlockFailed)
    assert (failed.block, failed.owner, run.agent.outcome) == ("wheels", "content", "error")
    assert AT + 0.2 <= failed.t < AT + 0.3


class Once(Behaviour):
    """A leaf that commands once; the watchdog ends it."""

    def __init__(self, clock, gate):
        super().__init__("once")
        self.clock, self.gate, self.done = clock, gate, False

    def update(self):
        if self.clock.now() >= AT and not self.done:
            self.done = True
            self.gate.command([0.2, 0.2])
        return Status.RUNNING
