"""A user's own driver, monitor and action that raise in a run, through `rocs-bt run`: each is told at its line."""

import json

import pytest

CODE = """\
from dataclasses import dataclass

from rocs_bt import AtomicAction, Monitor, Progress, Signal
from rocs_bt.devices.mujoco import MujocoActuator, MujocoSensor
from rocs_bt.plan import Mission
from rocs_bt.base.units import LENGTH


class Beacon(MujocoSensor):
    def sample(self) -> list[float]:
        {sample}
        return [1.0]


class Hear(Monitor):
    def signals(self):
        return [Signal("beacon", 1, (LENGTH,), (0.0, 100.0), self.max_age)]

    def interpret(self, readings):
        {interpret}
        return {{"beacon": readings["radio"].values}}


class Wheels(MujocoActuator):
    size = 2

    def set_up(self):
        self.motors = self.world.motors(self.robot, ("left_motor", "right_motor"), 30.0)

    def command(self, values):
        {command}
        self.world.drive(self.motors, [v / 0.0975 for v in values])

    def neutral(self):
        self.world.drive(self.motors, [0.0, 0.0])

    def before_step(self, t):
        {loop}

    def measured(self):
        return [0.0975 * s for s in self.world.motor_speeds(self.motors)]
"""

TABLES = """
[[sensor]]
name = "radio"
driver = "own.py:Beacon"
signal = "beacon"
monitor = "own.py:Hear"
"""


@pytest.fixture
def own(project):
    """Gives the robot of a new project a sensor, a monitor and an actuator of its own, one of which raises."""

    def own(**raising):
        places = {"sample": "pass", "interpret": "pass", "command": "pass", "loop": "pass"} | raising
        folder = project / "robots" / "rover"
        (folder / "own.py").write_text(CODE.format(**places))
        file = folder / "robot.toml"
        before, _, after = file.read_text().partition('driver = "velocity"\n')
        velocity = ("motors", "wheel_radius", "max_acceleration")
        kept = [line for line in after.splitlines() if not line.startswith(velocity)]
        file.write_text("\n".join([before + 'driver = "own.py:Wheels"', *kept]) + "\n" + TABLES)
        lines = (folder / "own.py").read_text().splitlines()
        return next((i for i, line in enumerate(lines, 1) if "1 / 0" in line), 0)

    return own


def summary(project):
    return json.loads((project / "runs/first-1/summary.json").read_text())["agents"]["R1"]


def test_without_a_defect_the_robot_reaches_its_goal(own, project, rocs_bt):
    own()
    assert rocs_bt("run", "first", "--no-report").code == 0
    assert summary(project)["exceptions"] == {}


@pytest.mark.parametrize(
    ("method", "kind", "name", "clock"),
    [
        ("sample", "sensor", "radio", "self.world.clock"),
        ("interpret", "monitor", "radio", "self.knowledge.clock"),
    ],
)
def test_a_sensor_or_monitor_that_raises_does_not_end_the_run(method, kind, name, clock, own, project, rocs_bt):
    line = own(**{method: f"{clock}.now() > 1.0 and 1 / 0"})
    told = rocs_bt("run", "first", "--no-report")
    assert told.code == 0
    raised = f"{kind} '{name}' raised ZeroDivisionError: division by zero (own.py:{line})"
    assert f"fault at 1.05 s: {raised}; its signals are invalid; it is read again in the next period" in told.out
    assert summary(project)["exceptions"] == {f"{kind} {name}": 1}


@pytest.mark.parametrize(
    "where", [{"command": "self.world.clock.now() > 1.0 and 1 / 0"}, {"loop": "t > 1.0 and 1 / 0"}]
)
def test_an_actuator_that_raises_ends_the_run_with_exit_code_1(where, own, project, rocs_bt):
    line = own(**where)
    told = rocs_bt("run", "first", "--no-report")
    assert told.code == 1
    what = f"actuator 'R1/wheels' raised: ZeroDivisionError: division by zero (own.py:{line})"
    assert f"R1 error (first, seed 1): {what}\n" in told.out
    assert (summary(project)["failed_block"], summary(project)["failed_owner"]) == ("wheels", "content")
    assert summary(project)["reason"] == what


OWN_ACTION = '''
from rocs_bt import MacroAction, Mission
from rocs_bt.actions import SetWheelSpeed
from rocs_bt.base.units import PositiveMetresPerSecond


class Nudge(MacroAction):
    """Yields an action of the engine with a parameter that it cannot use."""

    def decompose(self, body):
        yield SetWheelSpeed(speeds=[0.1, 0.1], duration=0.2)
        {middle}

    def part(self):
        yield SetWheelSpeed(speeds=["0.6 m/s", "fast"])  # here


def build(mission: Mission, *, first: str, second: str, cruise: PositiveMetresPerSecond = 0.4):
    return mission.act("Nudge")


build.actions = [Nudge]
'''


@pytest.mark.parametrize(
    "middle",
    ["yield from self.part()", 'yield SetWheelSpeed(speeds=["0.6 m/s", "fast"])  # here'],
    ids=["part", "whole"],
)
def test_an_exception_of_an_engine_action_names_the_line_that_yielded_it(middle, project, rocs_bt):
    file = project / "planners/missions/patrol.py"
    file.write_text(OWN_ACTION.format(middle=middle))
    line = next(i for i, each in enumerate(file.read_text().splitlines(), 1) if each.endswith("# here"))
    told = rocs_bt("run", "first", "--no-report")
    assert told.code == 1
    words = "action 'SetWheelSpeed' raised ValueError: could not convert string to float: '0.6 m/s'"
    assert f"{words} (patrol.py:{line}); brakes and replans (1 of 3 within 10 s)" in told.out
