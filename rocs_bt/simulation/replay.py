"""Replay: the recorded sensors to the same mind, which must reach the same decisions (docs/architecture.md)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace as replace_fault

from ..agent import RobotDevices, Runtime
from ..catalog import Catalog, RobotSpec, ScenarioSpec, command_size
from ..clock import SimulatedClock
from ..device import Sensor
from ..drivers.replay import ReplayActuator, ReplayMailbox, replay_sensors
from ..errors import InputError, RecordingError, UnknownName, unknown
from ..event import AgentStopped, CommandExpired, Event, EventSink, ListSink, RulesReplaced
from ..record import WORLD_EVENTS, Divergence, Recording, RunHeader, compare
from .build_agents import build_agents
from .fact_schedule import fact_schedules
from .memory import recall
from .options import Build

_NOT_THE_MINDS: tuple[type[Event], ...] = (*WORLD_EVENTS, CommandExpired, RulesReplaced)


def replay(
    recording: Recording,
    catalog: Catalog | None = None,
    *,
    agent: str | None = None,
    missions: Mapping[str, Build] | None = None,
) -> Divergence | None:
    """Feed a recording's sensors to the minds of its scenario, and compare what they do with what was recorded.

    Args:
        recording: Of a lockstep run; one that was cut off is compared as far as it goes.
        catalog: Where the scenario is found; the project around the current folder by default.
        agent: Compare this agent alone.
        missions: By agent, the mission's `build` that was played instead of the scenario's.

    Returns:
        The first difference; None when every decision is the same, byte for byte but for wall-time fields.

    Raises:
        RecordingError: The run was threaded, or the content is not the one that was recorded.
        InputError: The scenario is not found, or does not load.
    """
    header = recording.header
    if header.mode != "lockstep":
        raise RecordingError(
            f"'{recording.path}' was recorded in {header.mode} mode, whose decisions depend on wall time and do not "
            "repeat. Record it in lockstep mode, or ask it with --why."
        )
    names = [a.name for a in header.agents]
    if agent is not None and agent not in names:
        raise InputError(unknown("agent", agent, names, "The run"))
    recorded = list(recording.events())
    if changed := [e for e in recorded if isinstance(e, RulesReplaced) and e.accepted]:
        raise RecordingError(
            f"the rules '{changed[0].rules}' were replaced at {changed[0].t:.2f} s, while '{recording.path}' was "
            "recorded, so it cannot be repeated. Record it without --watch-rules, or ask it with --why."
        )
    catalog = catalog or Catalog.here()
    scenario = _scenario(header.scenario, catalog)
    if catalog.digest(scenario) != header.content_hash:
        raise RecordingError(
            f"the content of '{header.scenario}' has changed since '{recording.path}' was recorded (content_hash "
            f"{header.content_hash[:12]}). Check out the version that was recorded, or run the scenario again."
        )
    if measured := [a.name for a in scenario.agents if a.latency is None]:
        raise RecordingError(
            f"the latency of {measured[0]}'s planner was measured while '{recording.path}' was recorded, so it cannot "
            'be repeated. Declare it, as latency = "0.05 s", or ask it with --why.'
        )
    recorded = [e for e in recorded if not isinstance(e, _NOT_THE_MINDS)]
    found = _decide(scenario, catalog, header, recorded, missions)
    if agent is not None:
        recorded, found = ([e for e in events if e.agent == agent] for events in (recorded, found))
    return compare(recorded, found, cut_off=not recording.complete)


def _scenario(name: str, catalog: Catalog) -> ScenarioSpec:
    try:
        catalog.find("scenario", name)
    except UnknownName as error:
        hint = "Replay a run in the folder of the project that it was recorded in."
        raise UnknownName(*(replace_fault(f, hint=f"{f.hint} {hint}") for f in error.faults)) from error
    return catalog.load_scenario(name)


def _decide(
    scenario: ScenarioSpec,
    catalog: Catalog,
    header: RunHeader,
    recorded: Sequence[Event],
    missions: Mapping[str, Build] | None,
) -> list[Event]:
    """What the scenario's minds do when their sensors say what they said."""
    control, sink = scenario.rate.control_rate, ListSink()
    clock = SimulatedClock(scenario.rate.physics)
    devices = {
        a.name: _devices(scenario, catalog.load_robot(a.robot), a.name, recorded, clock, sink) for a in scenario.agents
    }
    minds = build_agents(scenario, catalog, devices, Runtime(clock, sink), seed=header.seed, missions=missions)
    recall(header.recalled, minds)
    news = fact_schedules(scenario, minds)
    stops = {e.agent: e for e in recorded if isinstance(e, AgentStopped)}
    last = round(recorded[-1].t / control.period) if recorded else -1
    for count in range(last + 1):
        for mind in minds:
            if (stop := stops.get(mind.name)) and count >= round(stop.t / control.period):
                mind.stop(stop.by)
        for mind in minds:
            if not mind.stopped:
                mind.step(count)
        for told in news:
            told.step(clock.now())
        clock.advance(control.every)
    return sink.events


def _devices(
    scenario: ScenarioSpec,
    robot: RobotSpec,
    agent: str,
    recorded: Sequence[Event],
    clock: SimulatedClock,
    sink: EventSink,
) -> RobotDevices:
    """The devices of one agent: sensors that give what was recorded, actuators that move nothing."""
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
