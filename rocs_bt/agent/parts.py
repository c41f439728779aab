"""Parts of an agent: devices, rates, runtime and blocks."""

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
    """Specification of a robot and its devices, one per sensor and actuator of the specification.

    Attributes:
        robot: Content of robot.toml.
        sensors: Sensors by name.
        actuators: Safety gates of the actuators, by name.
        sensor_rates: Rates of the sensors in control periods, by sensor name.
    """

    robot: RobotSpec
    sensors: Mapping[str, Sensor]
    actuators: Mapping[str, SafetyGate]
    sensor_rates: Mapping[str, Rate]


@dataclass(frozen=True)
class Rates:
    """Rates of the blocks in control periods.

    Attributes:
        control: Control rate: reflexes, Execute and the follower. All other rates are divisions of it.
        plan: Rate of Plan.
    """

    control: Rate
    plan: Rate


@dataclass(frozen=True)
class Runtime:
    """Services that the blocks of an agent share.

    Attributes:
        clock: Clock of the run.
        sink: Sink for all events.
        timer: Timer [s] for the follower's solve times and for planners with measured latency; None disables both.
        rng: Factory of the mission's random streams, by purpose.
    """

    clock: Clock
    sink: EventSink
    timer: Callable[[], float] | None = None
    rng: Callable[[str], np.random.Generator] = lambda purpose: np.random.default_rng(0)

    @property
    def planning_timer(self) -> Callable[[], float]:
        """Timer that measures planning time [s]; constant 0 on wall time, where planning causes its own delay."""
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
