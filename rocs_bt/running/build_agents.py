"""Build the agents of a scenario and connect them to its robots."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

from ..agent import Agent, AgentRuntime, Controller, Rates, RobotDevices, build_agent
from ..base.clock import Clock, Rate, SimulatedClock
from ..base.errors import Fault, InputError, collected, located_at
from ..base.registered import load, registered
from ..catalog import AgentSpec, Catalog, RateSpec, RobotSpec, ScenarioSpec, command_size, mission_values
from ..declare import Location, Open, location_of, replaced
from ..devices.replay import ReplayActuator, ReplayMailbox, replay_sensors
from ..event import Event, EventSink, NullSink
from ..interfaces.device import Sensor
from ..interfaces.service import Service
from ..knowledge import Knowledge
from ..plan import CheckOptions, Plan, mission_actions
from ..plan.mission_texts import nodes_in
from ..simulation.random_streams import stream
from .run_options import Build


def load_controller(
    scenario: ScenarioSpec, agent: AgentSpec, catalog: Catalog, build: Build | None = None
) -> Controller:
    """Controller of one agent, as declared in a scenario.

    Raises:
        InputError: An unknown name, or parameters that the mission does not take.
    """
    mission = build or catalog.load_mission(agent.mission, agent.nodes)
    parameters = mission_values(mission, agent if build is None else replaced(agent, parameters=Open()))
    return Controller(
        build=mission,
        mission=agent.mission if build is None else getattr(build, "__module__", "mission"),
        parameters=parameters,
        rules=[catalog.find("rules", name).path for name in agent.rules],
        places=[place for place in scenario.places if agent.name in place.agents],
        facts=scenario.facts_of(agent.name),
        peers={name: tag for name, tag in scenario.tags.items() if name != agent.name},
        actions=mission_actions(mission),
        latency=agent.latency,
        privileged=agent.privileged or {},
        schema=catalog.load_schema(),
    )


def build_agents(
    scenario: ScenarioSpec,
    catalog: Catalog,
    devices: Mapping[str, RobotDevices],
    runtime: AgentRuntime,
    *,
    seed: int = 0,
    missions: Mapping[str, Build] | None = None,
    faults: list[Fault] | None = None,
) -> list[Agent]:
    """Build the agents of a scenario, in its order, and connect them to their robots.

    With `faults`, the errors and warnings of a check are added to it: agents that cannot be built are then missing, and
    an agent with a faulty mission has one that does nothing. Without it, errors are raised, and missions are not
    checked.

    Raises:
        InputError: A mission, rule file or robot.toml is invalid; lists every fault of that file.
    """
    rates = Rates(control=Rate(1, scenario.rate.control_rate.period), plan=scenario.rate.plan_rate)
    agents, services = list[Agent](), dict[str, Callable[[Knowledge], Service]]()
    with collected(faults):
        services = _services_of(scenario, runtime.clock, seed)
    for agent in scenario.agents:
        own = replace(runtime, rng=partial(stream, scenario.name, seed, agent.name))
        build = (missions or {}).get(agent.name)
        with collected(faults), located_at(scenario.file, location_of(agent).line):
            if faults is None:
                controller = load_controller(scenario, agent, catalog, build)
            else:
                controller = _checked_controller(scenario, agent, catalog, build, faults)
            found = None if faults is None else list[Fault]()
            built = build_agent(
                agent.name,
                devices[agent.name],
                controller,
                rates,
                own,
                load_class=catalog.load_class,
                cached=catalog.cached,
                share=services.get(agent.name),
                faults=found,
            )
            agents.append(built)
            if faults is not None and found:
                at = location_of(agent.parameters)
                at = Location(scenario.file, location_of(agent).line, 0) if at.file is None else at
                faults += (fault.at(*at) for fault in found)
    return agents


def _services_of(scenario: ScenarioSpec, clock: Clock, seed: int) -> dict[str, Callable[[Knowledge], Service]]:
    """Factories of the services that packages add to a scenario by its tables, by agent.

    Raises:
        InputError: One cannot be loaded or made, or an agent has services of two tables.
    """
    services, tables = dict[str, Callable[[Knowledge], Service]](), dict[str, str]()
    for table in sorted(scenario.tables.keys() & registered("rocs_bt.services")):
        added = load("rocs_bt.services", table)(scenario, clock, seed)
        if twice := sorted(added.keys() & services.keys()):
            message = f"the agent '{twice[0]}' has services of two tables, [{tables[twice[0]]}] and [{table}]."
            line = location_of(scenario.tables[table]).line
            raise InputError(Fault(message, scenario.file, line, hint="Remove one, or name its agents in one only."))
        services |= added
        tables |= dict.fromkeys(added, table)
    return services


def _checked_controller(
    scenario: ScenarioSpec, agent: AgentSpec, catalog: Catalog, build: Build | None, faults: list[Fault]
) -> Controller:
    """Controller of an agent in a check, which does nothing if its mission cannot be loaded.

    A mission function that a program gives is not checked: only the run calls it.
    """
    if build is not None:
        return load_controller(scenario, agent, catalog, build)
    try:
        controller = load_controller(scenario, agent, catalog)
    except InputError as error:
        faults += error.at(scenario.file, location_of(agent).line).faults
        return load_controller(scenario, agent, catalog, Plan.idle)
    options = CheckOptions(
        robot=f"{catalog.robot_of(agent).name} ({agent.name} in {scenario.name})",
        passed={v: location_of(agent.parameters, n) for n, v in controller.parameters.items() if isinstance(v, str)},
        later=_later(scenario, agent, catalog),
    )
    return replace(controller, check_options=options)


def _later(scenario: ScenarioSpec, agent: AgentSpec, catalog: Catalog) -> set[str] | None:
    """Names of nodes that may be added to an agent's Knowledge during the run; None if they cannot be determined.

    The reason for None is that sharing, user blocks and TrackObjects may add nodes with any name.
    """
    robot = catalog.robot_of(agent)
    if scenario.tables or robot.code or any(spec.cls == "TrackObjects" for spec in robot.analyzers):
        return None
    mission = catalog.find("mission", agent.mission)
    python = catalog.python_of(mission, agent.parameters.values(), agent.nodes)
    declared = {fact.node for fact in scenario.facts_of(agent.name)}
    return declared | nodes_in([mission.path, *(entry.path for entry in python)])


def worldless_devices(
    robot: RobotSpec,
    rate: RateSpec,
    clock: Clock,
    sink: EventSink | None = None,
    agent: str = "",
    recorded: Sequence[Event] = (),
) -> RobotDevices:
    """Devices of a robot without a world: sensors with the readings of a recording, and actuators without effect."""
    sensors: dict[str, Sensor] = {
        **replay_sensors(recorded, agent, [s.name for s in robot.sensors], clock),
        **{s.name: ReplayMailbox(s.name, clock) for s in robot.sensors if s.driver == "mailbox"},
    }
    period = rate.control_rate.period
    actuators = {
        a.name: a.guard(ReplayActuator(a.name, command_size(robot, a), clock), clock, period, sink, agent)
        for a in robot.actuators
    }
    rates = {s.name: rate.sensor_rate(s.rate, s.name) for s in robot.sensors}
    return RobotDevices(robot, sensors, actuators, rates)


def worldless_agents(
    scenario: ScenarioSpec,
    catalog: Catalog,
    *,
    seed: int,
    missions: Mapping[str, Build] | None = None,
    recorded: Sequence[Event] = (),
    clock: SimulatedClock | None = None,
    sink: EventSink | None = None,
    faults: list[Fault] | None = None,
) -> list[Agent]:
    """Build the agents of a scenario on devices without a world; see `worldless_devices` and `build_agents`.

    Raises:
        InputError: The content is invalid.
    """
    clock, sink, devices = clock or SimulatedClock(scenario.rate.physics), sink or NullSink(), {}
    for agent in scenario.agents:
        with collected(faults), located_at(scenario.file, location_of(agent).line):
            robot = catalog.robot_of(agent)
            if robot.code and not catalog.code and faults is not None:
                continue
            devices[agent.name] = worldless_devices(robot, scenario.rate, clock, sink, agent.name, recorded)
    scenario = replaced(scenario, agents=tuple(agent for agent in scenario.agents if agent.name in devices))
    runtime = AgentRuntime(clock, sink)
    return build_agents(scenario, catalog, devices, runtime, seed=seed, missions=missions, faults=faults)
