"""Stub agents: all blocks of a robot, built and wired, with stub devices.

Rules and missions are checked against the signals, places and actions of a stub agent, without a simulation.
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
        raise DeviceError(f"the sensor '{self.name}' is a stub")


class _NoActuator(Actuator):
    def command(self, values: Sequence[float]) -> None:
        raise DeviceError(f"the actuator '{self.name}' is a stub")

    def neutral(self) -> None:
        pass


class _Idle(Plan):
    def run(self, t: float) -> None:
        self.changes()


def idle(mission: Mission) -> Plan:
    """Mission that does nothing."""
    return _Idle(mission.name, **mission.parts)


def stub_agent(
    robot: RobotSpec,
    load_class: Callable[[Path, str], type],
    controller: Controller | None = None,
    name: str = "R1",
) -> Agent:
    """Build an agent with stub devices, for checks only.

    Args:
        robot: The robot.
        load_class: Loads a class that robot.toml names as `file.py:Class`.
        controller: Mission, rules and initial knowledge; an idle mission by default.
        name: Agent's name.

    Raises:
        InputError: The robot, the mission or a place is invalid.
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
    return build_agent(name, devices, controller or Controller(build=idle), rates, runtime, load_class=load_class)
