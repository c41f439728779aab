"""An agent without physics: a robot.toml's wiring on mock devices."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from ..agent import Agent, Controller, Rates, RobotDevices, Runtime, build_agent, robot_drive
from ..agent.wiring import LoadClass
from ..catalog import RobotSpec, load_class
from ..clock import Clock, Rate
from ..device import Sensor
from ..drivers.mock import MockRobot, MockWorld, make_actuator, make_sensor
from ..event import EventSink
from ..geometry import Pose2
from ..knowledge import Knowledge
from ..knowledge.share import Sharing
from ..safety import SafetyGate


@dataclass
class MockStage:
    """What stands behind a mock agent; change it before the agent is built, or while it runs.

    Attributes:
        clock: Time; whoever runs the agent moves it on.
        world: Walls and round things.
        robot: The robot, which does at once what it is told.
        sensors: By name.
        actuators: Behind their limits, by name; their watchdogs are checked whenever the world moves on.
    """

    clock: Clock
    world: MockWorld
    robot: MockRobot
    sensors: dict[str, Sensor]
    actuators: dict[str, SafetyGate]


def mock_stage(
    spec: RobotSpec,
    clock: Clock,
    pose: Pose2 | None = None,
    *,
    period: float = 0.05,
    sink: EventSink | None = None,
    agent: str = "",
) -> MockStage:
    """Mock devices for everything in a robot.toml.

    Sites of range sensors look out from the robot's origin, evenly spread over the circle, to the left first; a scanner
    looks ahead.

    Args:
        spec: The robot; its drivers must be ones that have a mock.
        clock: Time.
        pose: Where it starts; the origin when left out.
        period: Control period [s].
        sink: Receives the events of the safety gates.
        agent: Name of the agent, for these events.

    Raises:
        InputError: A driver has no mock, or does not take its parameters.
    """
    world, drive = MockWorld(clock), robot_drive(spec.drive)
    mounts = {
        site: Pose2(0.0, 0.0, math.tau * i / len(sites))
        for s in spec.sensors
        if isinstance(sites := s.parameters.get("sites"), (list, tuple))
        for i, site in enumerate(sites)
    }
    mounts |= {s.parameters["site"]: Pose2(0.0, 0.0, 0.0) for s in spec.sensors if "site" in s.parameters}
    robot = MockRobot(world, drive, pose or Pose2(0.0, 0.0, 0.0), mounts)
    sensors: dict[str, Sensor] = {s.name: make_sensor(robot, s.name, s.driver, s.parameters) for s in spec.sensors}
    actuators = {
        a.name: a.guard(make_actuator(robot, a.name, a.driver, a.parameters), clock, period, sink, agent)
        for a in spec.actuators
    }
    robot.gates.extend(actuators.values())
    return MockStage(clock, world, robot, sensors, actuators)


def mock_agent(
    spec: RobotSpec,
    mind: Controller,
    runtime: Runtime,
    *,
    name: str = "R1",
    rates: Rates | None = None,
    prepare: Callable[[MockStage], None] = lambda stage: None,
    load: LoadClass = load_class,
    share: Callable[[Knowledge], Sharing] | None = None,
) -> tuple[Agent, MockStage]:
    """An agent on mock devices.

    Args:
        spec: Its robot.
        mind: Its mission, rules and knowledge at the start.
        runtime: Its clock, a `SimulatedClock` whose step is the control period or a `WallClock`, and its sink.
        name: The agent's name.
        rates: Rates of its blocks; control at 20 Hz and plan at 10 Hz by default.
        prepare: Called with the mock devices before the agent is built; may replace them.
        load: Loads a class that robot.toml names as `file.py:Class`.
        share: Makes it share what it knows.

    Raises:
        InputError: Something does not fit together.
    """
    rates = rates or mock_rates()
    period = rates.control.period
    stage = mock_stage(spec, runtime.clock, period=period, sink=runtime.sink, agent=name)
    prepare(stage)
    sensor_rates = {
        s.name: Rate.dividing(s.rate or 1.0 / period, period, f"the rate of sensor '{s.name}'") for s in spec.sensors
    }
    devices = RobotDevices(spec, stage.sensors, stage.actuators, sensor_rates)
    return build_agent(name, devices, mind, rates, runtime, load_class=load, share=share), stage


def mock_rates(control: float = 20.0, plan: float = 10.0) -> Rates:
    """Rates of an agent's blocks: control and plan [Hz]."""
    period = 1.0 / control
    return Rates(control=Rate(1, period), plan=Rate.dividing(plan, period, "the plan's rate"))
