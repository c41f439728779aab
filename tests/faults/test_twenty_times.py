"""Each fault twenty times in threaded mode, at each part of a control period: how soon the wheels are neutral.

python -m pytest --real-time -m soak tests/faults/test_twenty_times.py -rP
"""

import threading
import time

import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from rocs_bt.monitor import RangeMonitor
from rocs_bt.testing.faults import DeadSensor, RaisingActuator, RaisingSensor, break_actuator, break_sensor

from . import test_content as content

SOON = 0.35  # [s] from the fault to neutral
COUNT = 20


class Log:
    """Stands before the wheels' device, and notes when they are neutral [s]."""

    def __init__(self, device, clock):
        self.device, self.clock, self.neutrals = device, clock, []
        self.name, self.size = device.name, device.size

    def command(self, values):
        self.device.command(values)
        if not any(values):
            self.neutrals.append(self.clock.now())

    def neutral(self):
        self.device.neutral()
        self.neutrals.append(self.clock.now())

    def __getattr__(self, name):
        return getattr(self.device, name)


class Naps(Behaviour):
    """A leaf that hangs once, or ends its thread."""

    began = None  # [s]

    def __init__(self, clock, at, how):
        super().__init__("naps")
        self.clock, self.at, self.how, self.over = clock, at, how, False

    def update(self):
        if not self.over and self.clock.now() >= self.at:
            self.over, Naps.began = True, self.clock.now()
            if self.how == "ends":
                raise KeyboardInterrupt  # no boundary of content catches it: the thread is gone
            time.sleep(1.0)
        return Status.RUNNING


def mission_of(what):
    def fault(at, stages, monkeypatch):
        content.TIMES[0] = content.Times(at)
        make = content.MISSIONS[what][2]

        def build(mission):
            return make(mission, content.TIMES[0])

        build.__module__ = content.__name__  # whose actions the mission has
        return None, {"missions": {"R2": build}, "rules": ()}

    return fault


def sensor(kind):
    def fault(at, stages, monkeypatch):
        return lambda stage: break_sensor(stage, "sonar", kind, at=at), {}

    return fault


def monitor(at, stages, monkeypatch):
    sound = RangeMonitor.interpret

    def rotten(self, readings):
        if stages[-1].clock.now() >= at:
            raise content.Rotten("a worm")
        return sound(self, readings)

    monkeypatch.setattr(RangeMonitor, "interpret", rotten)
    return None, {}


def actuator(at, stages, monkeypatch):
    return lambda stage: break_actuator(stage, "wheels", RaisingActuator, at=at), {"rules": ()}


def reflex(model):
    def fault(at, stages, monkeypatch):
        monkeypatch.setattr(content, "AT", at)
        content.TIMES[0] = content.Times(at, on=True)

        def build(mission):
            mission.knowledge.reactive_models.append(model())
            return mission.act("GoTo", goal="goal")

        build.__module__ = content.__name__
        return None, {"missions": {"R2": build}, "rules": ()}

    return fault


def block(how):
    def fault(at, stages, monkeypatch):
        monkeypatch.setattr(threading, "excepthook", lambda args: None)
        make = content.beside(lambda mission, _: Naps(mission.clock, at, how))
        return None, {"missions": {"R2": lambda mission: make(mission, None)}, "rules": ()}

    return fault


FAULTS = {
    **{f"{what} raises": mission_of(what) for what in content.MISSIONS},
    "sensor raises": sensor(RaisingSensor),
    "sensor ends": sensor(DeadSensor),
    "monitor raises": monitor,
    "reflex action raises": reflex(lambda: content.Whim("Rot", True)),
    "reactive model raises": reflex(lambda: content.Unsound(content.unsound)),
    "actuator raises": actuator,
    "block hangs": block("hangs"),
    "block ends": block("ends"),
}


@pytest.mark.soak
@pytest.mark.parametrize("what", FAULTS)
def test_twenty_times(what, broken, monkeypatch):
    took = []
    for count in range(COUNT):
        at, stages, logs, Naps.began = content.AT + count * 0.0025, [], [], None
        prepare, kwargs = FAULTS[what](at, stages, monkeypatch)

        def begin(stage, prepare=prepare, stages=stages, logs=logs):
            stages.append(stage)
            stage.actuators["R2"]["wheels"].wrap(lambda d: logs.append(Log(d, stage.clock)) or logs[-1])
            if prepare is not None:
                prepare(stage)

        broken(begin, mode="threaded", duration=at + 0.8, **kwargs)
        monkeypatch.undo()
        since = Naps.began or at  # the plan is asked ten times a second
        took.append(next((t - since for t in logs[0].neutrals if t >= since), float("inf")))
    took.sort()
    print(f"{what}: neutral after {took[0]:.3f} to {took[-1]:.3f} s, median {took[COUNT // 2]:.3f} s")
    assert took[-1] <= SOON
