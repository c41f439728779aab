"""Stub agents: all blocks of a robot, built and wired, on devices without a world.

Rules and missions that no scenario uses are checked against the signals, places and actions of a stub agent.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ..agent import Agent, AgentRuntime, Controller, Rates, build_agent
from ..base.clock import SimulatedClock
from ..base.errors import Fault
from ..catalog import RateSpec, RobotSpec
from ..declare import replaced
from ..event import NullSink
from ..plan import Plan
from ..running.build_agents import worldless_devices


def stub_agent(
    robot: RobotSpec,
    load_class: Callable[[Path, str], type],
    controller: Controller | None = None,
    faults: list[Fault] | None = None,
) -> Agent:
    """Build an agent without a world, for checks only; by default its mission does nothing.

    Raises:
        InputError: The robot, the mission or a place is invalid.
    """
    rate = RateSpec()
    clock, rates = SimulatedClock(rate.control_rate.period), Rates(rate.control_rate, rate.plan_rate)
    devices = worldless_devices(robot, replaced(rate, sensors=rate.control), clock)
    runtime, controller = AgentRuntime(clock, NullSink()), controller or Controller(build=Plan.idle)
    return build_agent("R1", devices, controller, rates, runtime, load_class=load_class, faults=faults)
