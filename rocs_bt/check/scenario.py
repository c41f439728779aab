"""Scenarios: everything that one names, put together as a run would, but for the running."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace

from ..actions import action_table
from ..agent import Mind
from ..agent.build import thresholds
from ..catalog import AgentSpec, Catalog, Entry, RobotSpec, ScenarioSpec, is_reference
from ..drivers.mujoco import MujocoActuator, MujocoSensor
from ..errors import Fault, InputError
from ..expression import Environment
from ..plan import mission_actions, mission_arguments
from ..reactive import load_rules, rule_misfits
from ..reactive.analysis import examine_fit
from ..record import TRUTH
from ..simulation import requirement_faults
from ..simulation.share import share_faults
from .feasible import check_feasible
from .mission import built_faults, named_in, nodes_in
from .paper import idle, paper_agent


def check_scenario_file(entry: Entry, catalog: Catalog) -> Iterable[Fault]:
    """All that is wrong with a scenario: its file, its agents' minds, and whether its goals can be reached."""
    # Read with code allowed, as the rest can be checked without running any.
    scenario = Catalog(catalog.project).load_scenario(str(entry.path))
    for agent in scenario.agents:
        try:
            yield from _mind_faults(scenario, agent, catalog)
        except InputError as error:
            yield from error.at(scenario.file, agent.line).faults
    yield from share_faults(scenario, catalog.load_schema())
    robots = [catalog.load_robot(name) for name in scenario.robots]
    # Code that may not run cannot be simulated, and a real robot is not.
    if all(_simulated(robot, catalog) if catalog.code else not robot.code for robot in robots):
        yield from check_feasible(scenario, catalog)


def _simulated(robot: RobotSpec, catalog: Catalog) -> bool:
    """Whether a robot's own drivers are MuJoCo's, not those of hardware; wrong ones are reported with the robot."""
    for driver in [*(s.driver for s in robot.sensors), *(a.driver for a in robot.actuators)]:
        file, _, name = driver.partition(":")
        if is_reference(driver) and not issubclass(
            catalog.load_class(robot.beside(file), name), (MujocoSensor, MujocoActuator)
        ):
            return False
    return True


def mind_doubts(scenario: ScenarioSpec, catalog: Catalog) -> list[Fault]:
    """The warnings about the agents of a scenario.

    Raises:
        InputError: An agent could be built, but something is wrong with it, such as a goal that no place has.
    """
    doubts: list[Fault] = []
    for agent in scenario.agents:
        try:
            found = list(_mind_faults(scenario, agent, catalog))
            if wrong := [fault for fault in found if not fault.warning]:
                _build(scenario, agent, catalog)
        except InputError:
            continue  # raised again, with better lines, where the agent is built
        if wrong:
            raise InputError(*dict.fromkeys(wrong))
        doubts += found
    return doubts


def _mind(scenario: ScenarioSpec, agent: AgentSpec, catalog: Catalog) -> Mind:
    """What an agent knows at the start, with a mission that does nothing."""
    return Mind(
        build=idle,
        places=[p for p in scenario.places if agent.name in p.agents],
        facts=scenario.facts_of(agent.name),
        peers={name: tag for name, tag in scenario.tags.items() if name != agent.name},
        schema=catalog.load_schema(),
    )


def _build(scenario: ScenarioSpec, agent: AgentSpec, catalog: Catalog) -> None:
    """Build an agent with its mission and its rules.

    Raises:
        InputError: It cannot be built.
    """
    build = catalog.load_mission(agent.mission, agent.nodes)
    mind = replace(
        _mind(scenario, agent, catalog),
        build=build,
        mission=agent.mission,
        parameters=mission_arguments(build, agent.parameters),
        rules=[catalog.find("rules", name).path for name in agent.rules],
        actions=mission_actions(build),
    )
    paper_agent(catalog.load_robot(agent.robot), catalog.load_class, mind, agent.name)


def _mind_faults(scenario: ScenarioSpec, agent: AgentSpec, catalog: Catalog) -> Iterable[Fault]:
    robot = catalog.load_robot(agent.robot)
    if robot.code and not catalog.code:
        return
    built = paper_agent(robot, catalog.load_class, _mind(scenario, agent, catalog), agent.name)
    environment = Environment.of(built.knowledge.signals)
    build = catalog.load_mission(agent.mission, agent.nodes) if catalog.code else None
    actions = action_table(*(mission_actions(build) if build else ()))
    period, modes = scenario.rate.control_rate.period, named_in(catalog.find("mission", agent.mission).path)
    for name in agent.rules:
        file = catalog.find("rules", name).path
        own = thresholds(robot, file)
        yield from examine_fit(file, environment, actions, own, period, modes)
        with suppress(InputError):  # reported already
            yield from rule_misfits(
                load_rules(file, environment, actions, overrides=own).rules, actions, built.knowledge
            )
    signals = built.knowledge.signals
    known = Environment.packed([*(signals.spec(name) for name in signals.names), *TRUTH])
    yield from requirement_faults(scenario, agent.name, known)
    if build is None:
        return
    line = agent.parameters_line or agent.line
    try:
        parameters = mission_arguments(build, agent.parameters)
    except InputError as error:
        yield from error.at(scenario.file, line).faults
        return
    for fault in built_faults(build, built, parameters, _later(scenario, agent, robot, catalog)):
        yield fault.at(scenario.file, line)


def _later(scenario: ScenarioSpec, agent: AgentSpec, robot: RobotSpec, catalog: Catalog) -> set[str] | None:
    """Nodes that an agent may come to know during the run; None where that cannot be told.

    Other robots and a robot's own blocks may name nodes as they like, and so does TrackObjects.
    """
    if scenario.share is not None or robot.code or any(spec.cls == "TrackObjects" for spec in robot.analyzers):
        return None
    mission = catalog.find("mission", agent.mission)
    python = catalog.python_of(mission, agent.parameters.values())
    told = {fact.node for fact in scenario.facts_of(agent.name)}
    return told | nodes_in([mission.path, *(entry.path for entry in python)])
