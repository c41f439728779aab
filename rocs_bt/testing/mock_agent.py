"""Agent on mock devices: the wiring of a robot.toml without physics."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from ..agent import Agent, Controller, Rates, RobotDevices, Runtime, build_agent
from ..agent.wiring import LoadClass
from ..base.clock import Clock, Rate
from ..base.geometry import Pose2
from ..catalog import RobotSpec, load_class
from ..drivers import LidarParameters, RangeConeParameters
from ..drivers.mock import MockRobot, MockWorld, make_actuator, make_sensor
from ..event import EventSink
from ..interfaces.device import Sensor
from ..interfaces.safety import SafetyGate
from ..interfaces.service import Service
from ..knowledge import Knowledge


@dataclass
class MockDevices:
    """Mock devices of an agent; may be changed before the agent is built and while it runs.

    Attributes:
        clock: Clock of the devices, which the agent's runner advances.
        world: Mock world with walls and round obstacles.
        robot: Mock robot, which executes commands without delay.
        sensors: Sensors by name.
        actuators: Safety gates of the actuators, by name; their watchdogs are checked when the world advances.
    """

    clock: Clock
    world: MockWorld
    robot: MockRobot
    sensors: dict[str, Sensor]
    actuators: dict[str, SafetyGate]


def mock_devices(
    spec: RobotSpec,
    clock: Clock,
    pose: Pose2 | None = None,
    *,
    period: float = 0.05,
    sink: EventSink | None = None,
    agent: str = "",
) -> MockDevices:
    """Build mock devices for all sensors and actuators of a robot.toml.

    The sites of range sensors are spread evenly over a circle around the robot's origin, counterclockwise from the
    front; a scanner faces forward.

    Args:
        spec: The robot; each driver must have a mock.
        clock: Clock of the devices.
        pose: Start pose, world frame; the origin by default.
        period: Control period [s].
        sink: Receiver of the safety gates' events.
        agent: Name of the agent in these events.

    Raises:
        InputError: A driver has no mock, or does not accept its parameters.
    """
    world, locomotion = MockWorld(clock), spec.locomotion
    mounts = {
        site: Pose2(0.0, 0.0, math.tau * i / len(s.parameters.sites))
        for s in spec.sensors
        if isinstance(s.parameters, RangeConeParameters)
        for i, site in enumerate(s.parameters.sites)
    }
    lidars = [s.parameters for s in spec.sensors if isinstance(s.parameters, LidarParameters)]
    mounts |= {lidar.site: Pose2(0.0, 0.0, 0.0) for lidar in lidars}
    robot = MockRobot(world, locomotion, pose or Pose2(0.0, 0.0, 0.0), mounts)
    sensors: dict[str, Sensor] = {s.name: make_sensor(robot, s.name, s.driver, s.arguments) for s in spec.sensors}
    actuators = {
        a.name: a.guard(make_actuator(robot, a.name, a.driver, a.arguments), clock, period, sink, agent)
        for a in spec.actuators
    }
    robot.gates.extend(actuators.values())
    return MockDevices(clock, world, robot, sensors, actuators)


def mock_agent(
    spec: RobotSpec,
    controller: Controller,
    runtime: Runtime,
    *,
    name: str = "R1",
    rates: Rates | None = None,
    prepare: Callable[[MockDevices], None] = lambda mock: None,
    load: LoadClass = load_class,
    share: Callable[[Knowledge], Service] | None = None,
) -> tuple[Agent, MockDevices]:
    """Build an agent on mock devices; returns the agent and the devices.

    Args:
        spec: Robot of the agent.
        controller: Mission, rules and initial knowledge.
        runtime: Clock and event sink. The clock is a `SimulatedClock` with the control period as its step, or a
            `WallClock`.
        name: Name of the agent.
        rates: Rates of the agent's control and plan; 20 Hz and 10 Hz by default.
        prepare: Callback that may replace mock devices before the agent is built.
        load: Loader of classes that robot.toml names as `file.py:Class`.
        share: Factory of the agent's knowledge sharing; None for no sharing.

    Raises:
        InputError: Robot, controller and devices do not fit together.
    """
    rates = rates or mock_rates()
    period = rates.control.period
    mock = mock_devices(spec, runtime.clock, period=period, sink=runtime.sink, agent=name)
    prepare(mock)
    sensor_rates = {
        s.name: Rate.dividing(s.rate or 1.0 / period, period, f"the rate of sensor '{s.name}'") for s in spec.sensors
    }
    devices = RobotDevices(spec, mock.sensors, mock.actuators, sensor_rates)
    return build_agent(name, devices, controller, rates, runtime, load_class=load, share=share), mock


def mock_rates(control: float = 20.0, plan: float = 10.0) -> Rates:
    """Rates of an agent's control and plan, both given in Hz; control must be a multiple of plan."""
    period = 1.0 / control
    return Rates(control=Rate(1, period), plan=Rate.dividing(plan, period, "the plan's rate"))
