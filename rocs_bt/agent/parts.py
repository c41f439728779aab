"""Data classes from which an agent is built: devices, rates, runtime services and blocks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..analyze import Analyze
from ..base.clock import Clock, Rate, SimulatedClock
from ..catalog import RobotSpec
from ..event import EventSink
from ..execute import Execute
from ..interfaces.device import Sensor
from ..interfaces.pipeline import Pipeline
from ..interfaces.safety_gate import SafetyGate
from ..monitor import Monitor
from ..plan import Plan
from ..reactive import ReflexArc


@dataclass(frozen=True)
class RobotDevices:
    """Specification of a robot, and one device for each sensor and actuator in it.

    Attributes:
        robot: Content of robot.toml.
        sensors: Sensors by name.
        actuators: Safety gates of the actuators, by name.
        sensor_rates: Rates of the sensors in control periods, by sensor name.
        services: Services of packages for the mission by name, such as the connection `ros2`; empty in simulation.
    """

    robot: RobotSpec
    sensors: Mapping[str, Sensor]
    actuators: Mapping[str, SafetyGate]
    sensor_rates: Mapping[str, Rate]
    services: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Rates:
    """Rates of the blocks of an agent.

    Attributes:
        control: Control rate, at which reflexes, Execute and the trajectory follower run. All other rates are integer
            fractions of it.
        plan: Rate of Plan, in control periods.
    """

    control: Rate
    plan: Rate


@dataclass(frozen=True)
class AgentRuntime:
    """Services that the blocks of an agent share.

    Attributes:
        clock: Clock of the run.
        sink: Sink that receives all events.
        timer: Timer [s] that measures the follower's solve times and the planning latency; None to measure neither.
        rng: Function from a purpose to a random generator of the mission.
    """

    clock: Clock
    sink: EventSink
    timer: Callable[[], float] | None = None
    rng: Callable[[str], np.random.Generator] = lambda purpose: np.random.default_rng(0)

    @property
    def planning_timer(self) -> Callable[[], float]:
        """Timer that measures planning times [s]; constant in real time, where planning itself causes the delay."""
        timed = self.timer is not None and isinstance(self.clock, SimulatedClock)
        return self.timer if timed and self.timer is not None else lambda: 0.0


@dataclass(frozen=True)
class Blocks:
    """Blocks of an agent.

    Attributes:
        monitors: M of MAPE-K, in the order of robot.toml.
        analyzes: A of MAPE-K, in the order of robot.toml.
        plan: P of MAPE-K.
        execute: E of MAPE-K.
        arc: Reflex arc over all ReactiveModels.
        pipeline: Queue of actions between Plan, the reflex arc and Execute.
    """

    monitors: Sequence[Monitor]
    analyzes: Sequence[Analyze]
    plan: Plan
    execute: Execute
    arc: ReflexArc
    pipeline: Pipeline
