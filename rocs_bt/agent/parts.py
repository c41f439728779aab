"""Parts that an agent is built from: its robot's devices, its rates, its runtime and its blocks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..analyze import Analyze
from ..catalog import RobotSpec
from ..clock import Clock, Rate, SimulatedClock
from ..device import Sensor
from ..event import EventSink
from ..execute import Execute
from ..monitor import Monitor
from ..pipeline import Pipeline
from ..plan import Plan
from ..reactive import ReflexArc
from ..safety import SafetyGate


@dataclass(frozen=True)
class RobotDevices:
    """A robot's table and its devices, one for each sensor and actuator of the table.

    Attributes:
        robot: The robot.toml.
        sensors: Sensors by name.
        actuators: Actuators behind their limits, by name.
        sensor_rates: Rates of the sensors in control periods, by name.
    """

    robot: RobotSpec
    sensors: Mapping[str, Sensor]
    actuators: Mapping[str, SafetyGate]
    sensor_rates: Mapping[str, Rate]


@dataclass(frozen=True)
class Rates:
    """Rates of the blocks in control periods.

    Attributes:
        control: Reflexes, Execute and the follower; the base of all others.
        plan: Plan.
    """

    control: Rate
    plan: Rate


@dataclass(frozen=True)
class Runtime:
    """What all blocks of an agent share while it runs.

    Attributes:
        clock: Time.
        sink: Takes the events.
        timer: Measures solve times of the follower, and the planning time of a planner whose latency is measured [s];
            None measures nothing.
        rng: Makes the random stream of a purpose, for the mission.
    """

    clock: Clock
    sink: EventSink
    timer: Callable[[], float] | None = None
    rng: Callable[[str], np.random.Generator] = lambda purpose: np.random.default_rng(0)

    @property
    def planning_timer(self) -> Callable[[], float]:
        """Measures planning time [s]; on wall time planning takes its time anyway, so nothing is measured."""
        timed = self.timer is not None and isinstance(self.clock, SimulatedClock)
        return self.timer if timed and self.timer is not None else lambda: 0.0


@dataclass(frozen=True)
class Blocks:
    """The blocks of an agent.

    Attributes:
        monitors: M, in the order of robot.toml.
        analyzes: A, in the order of robot.toml.
        plan: P.
        execute: E.
        arc: The reflex arc over all ReactiveModels.
        pipeline: The queue between them.
    """

    monitors: Sequence[Monitor]
    analyzes: Sequence[Analyze]
    plan: Plan
    execute: Execute
    arc: ReflexArc
    pipeline: Pipeline
