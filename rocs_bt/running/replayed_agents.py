"""Agents without a world: their sensors replay a recording, and their actuators have no effect."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..agent import Agent, RobotDevices, Runtime
from ..catalog import Catalog, RobotSpec, ScenarioSpec, command_size
from ..clock import SimulatedClock
from ..device import Sensor
from ..drivers.replay import ReplayActuator, ReplayMailbox, replay_sensors
from ..event import Event, EventSink
from .build_agents import build_agents
from .options import Build


def replayed_agents(
    scenario: ScenarioSpec,
    catalog: Catalog,
    recorded: Sequence[Event],
    clock: SimulatedClock,
    sink: EventSink,
    *,
    seed: int,
    missions: Mapping[str, Build] | None = None,
) -> list[Agent]:
    """Build the agents of a scenario on recorded sensor data.

    Args:
        scenario: The scenario.
        catalog: Source of the content.
        recorded: Events of a recording, in order of time.
        clock: Clock of the agents.
        sink: Sink for the events of the agents.
        seed: Seed of the missions' random streams.
        missions: Mission functions that replace the scenario's, by agent.

    Raises:
        InputError: The content is invalid.
    """
    devices = {
        a.name: _devices(scenario, catalog.load_robot(a.robot), a.name, recorded, clock, sink) for a in scenario.agents
    }
    return build_agents(scenario, catalog, devices, Runtime(clock, sink), seed=seed, missions=missions)


def _devices(
    scenario: ScenarioSpec,
    robot: RobotSpec,
    agent: str,
    recorded: Sequence[Event],
    clock: SimulatedClock,
    sink: EventSink,
) -> RobotDevices:
    """Devices of one agent: sensors that replay their recorded readings, actuators without effect."""
    sensors: dict[str, Sensor] = {
        **replay_sensors(recorded, agent, [s.name for s in robot.sensors], clock),
        **{s.name: ReplayMailbox(s.name, clock) for s in robot.sensors if s.driver == "mailbox"},
    }
    period = scenario.rate.control_rate.period
    actuators = {
        a.name: a.guard(ReplayActuator(a.name, command_size(robot, a), clock), clock, period, sink, agent)
        for a in robot.actuators
    }
    rates = {s.name: scenario.rate.sensor_rate(s.rate, s.name) for s in robot.sensors}
    return RobotDevices(robot, sensors, actuators, rates)
