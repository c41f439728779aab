"""An agent on paper: all blocks of a robot, built and wired, with devices that do not exist.

It shows what a rule file or a mission can rely on (signals, places, actions) without a world to run in.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from ..agent import Agent, Controller, Rates, RobotDevices, Runtime, build_agent
from ..catalog import RateSpec, RobotSpec, command_size
from ..clock import SimulatedClock
from ..device import Actuator, Reading, Sensor
from ..errors import DeviceError
from ..event import NullSink
from ..plan import Mission, Plan


class _NoSensor(Sensor):
    def read(self) -> Reading:
        raise DeviceError(f"the sensor '{self.name}' exists on paper only")


class _NoActuator(Actuator):
    def command(self, values: Sequence[float]) -> None:
        raise DeviceError(f"the actuator '{self.name}' exists on paper only")

    def neutral(self) -> None:
        pass


class _Idle(Plan):
    def run(self, t: float) -> None:
        self.changes()


def idle(mission: Mission) -> Plan:
    """A mission that wants nothing."""
    return _Idle(mission.name, **mission.parts)


def paper_agent(
    robot: RobotSpec,
    load_class: Callable[[Path, str], type],
    mind: Controller | None = None,
    name: str = "R1",
) -> Agent:
    """An agent of a robot, never to be run.

    Args:
        robot: The robot.
        load_class: Loads a class that robot.toml names as `file.py:Class`.
        mind: Its mission, and what it is told of the world; one that wants nothing by default.
        name: What others call it.

    Raises:
        InputError: The robot, the mission or a place is wrong.
    """
    rate = RateSpec()
    clock, rates = SimulatedClock(rate.control_rate.period), Rates(rate.control_rate, rate.plan_rate)
    devices = RobotDevices(
        robot,
        {s.name: _NoSensor(s.name) for s in robot.sensors},
        {
            a.name: a.guard(_NoActuator(a.name, command_size(robot, a)), clock, rate.control_rate.period)
            for a in robot.actuators
        },
        {s.name: RateSpec(sensors=rate.control).sensor_rate(None, s.name) for s in robot.sensors},
    )
    runtime = Runtime(clock, NullSink())
    return build_agent(name, devices, mind or Controller(build=idle), rates, runtime, load_class=load_class)
