"""Agent on mock devices: the wiring of a robot.toml on a flat world without physics."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TypeVar

from ..agent import Agent, AgentRuntime, Controller, Rates, RobotDevices, build_agent
from ..agent.wiring import LoadClass
from ..base.clock import Clock, Rate
from ..base.errors import DeviceError, InputError
from ..base.geometry import Pose2
from ..catalog import ActuatorSpec, RobotSpec, SensorSpec, load_class
from ..devices.simulated import MailboxSensor, SimulatedActuator, SimulatedSensor, Velocity
from ..devices.simulated.flat import FlatRobot, FlatWorld
from ..event import EventSink
from ..interfaces.device import Reading, Sensor
from ..interfaces.safety_gate import SafetyGate
from ..interfaces.service import Service
from ..knowledge import Knowledge

D = TypeVar("D", SimulatedSensor, SimulatedActuator)


class MockSensor(Sensor):
    """Sensor with readings that a test can replace.

    Attributes:
        values: Values of all readings, SI units; None for those of the device.
        broken: Reason of a simulated failure; None while the sensor works.

    Args:
        device: Sensor on a flat world.
    """

    def __init__(self, device: SimulatedSensor) -> None:
        super().__init__(device.name)
        self.device = device
        self.values: Iterable[float] | None = None
        self.broken: str | None = None

    def read(self) -> Reading:
        if self.broken is not None:
            raise DeviceError(f"sensor '{self.name}' has no reading: {self.broken}.")
        return self.device.read() if self.values is None else Reading(self.device.world.stamp, list(self.values))


@dataclass
class MockDevices:
    """Mock devices of an agent; may be changed before the agent is built and while it runs.

    Attributes:
        clock: Clock of the devices, which the agent's runner advances.
        world: Flat world with walls and round obstacles.
        robot: Robot on it, which executes commands without delay.
        sensors: Sensors by name, each a `MockSensor`, except mailboxes.
        actuators: Safety gates of the actuators, by name; their watchdogs are checked when the world advances.
    """

    clock: Clock
    world: FlatWorld
    robot: FlatRobot
    sensors: dict[str, Sensor]
    actuators: dict[str, SafetyGate]


def mock_devices(
    spec: RobotSpec,
    clock: Clock,
    *,
    period: float = 0.05,
    sink: EventSink | None = None,
    agent: str = "",
) -> MockDevices:
    """Build mock devices for all sensors and actuators of a robot.toml.

    The sites of range sensors are spread evenly over a circle around the robot's origin, counterclockwise from the
    front; a scanner faces forward.

    Args:
        spec: The robot; its drivers must be shipped ones.
        clock: Clock of the devices.
        period: Control period [s].
        sink: Receiver of the safety gates' events.
        agent: Name of the agent in these events.

    Raises:
        InputError: A driver is not a shipped one of the simulation.
    """
    world, locomotion = FlatWorld(clock), spec.locomotion
    devices = [_shipped(s, SimulatedSensor) for s in spec.sensors]
    motion = [_shipped(a, SimulatedActuator) for a in spec.actuators]  # type: ignore[type-abstract]  # is not called
    mounts = dict[str, Pose2]()
    for sites in (each.mounted_at() for each in devices):
        mounts |= {site: Pose2(0.0, 0.0, math.tau * i / len(sites)) for i, site in enumerate(sites)}
    wheels = [each for each in motion if isinstance(each, Velocity)]
    motors = {name: factor for each in wheels for name, factor in zip(each.motors, each.factors, strict=True)}
    robot = FlatRobot(world, locomotion, Pose2(0.0, 0.0, 0.0), mounts, motors, name=agent)
    bound = [each.bind(s.name, world, robot.name) for s, each in zip(spec.sensors, devices, strict=True)]
    sensors: dict[str, Sensor] = {s.name: s if isinstance(s, MailboxSensor) else MockSensor(s) for s in bound}
    actuators = {
        a.name: a.guard(each.bind(a.name, world, robot.name), clock, period, sink, agent)
        for a, each in zip(spec.actuators, motion, strict=True)
    }
    robot.gates.extend(actuators.values())
    return MockDevices(clock, world, robot, sensors, actuators)


def _shipped(device: SensorSpec | ActuatorSpec, kind: type[D]) -> D:
    if isinstance(device.parameters, kind):
        return device.parameters
    raise InputError(f"the driver '{device.driver}' of '{device.name}' has no mock.")


def mock_agent(
    spec: RobotSpec,
    controller: Controller,
    runtime: AgentRuntime,
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
