"""Scenarios: everything that one names, put together as a run would, but for the running."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress

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
from .mission import built_faults, named_in
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
    """What is doubtful in the minds of a scenario's agents; what is wrong in them is told by whoever builds them."""
    doubts: list[Fault] = []
    for agent in scenario.agents:
        try:
            doubts += (fault for fault in _mind_faults(scenario, agent, catalog) if fault.warning)
        except InputError:
            continue
    return doubts


def _mind_faults(scenario: ScenarioSpec, agent: AgentSpec, catalog: Catalog) -> Iterable[Fault]:
    robot = catalog.load_robot(agent.robot)
    if robot.code and not catalog.code:
        return
    places = [p for p in scenario.places if agent.name in p.agents]
    peers = {name: tag for name, tag in scenario.tags.items() if name != agent.name}
    mind = Mind(
        build=idle, places=places, facts=scenario.facts_of(agent.name), peers=peers, schema=catalog.load_schema()
    )
    built = paper_agent(robot, catalog.load_class, mind, agent.name)
    environment = Environment.of(built.knowledge.signals)
    build = catalog.load_mission(agent.mission) if catalog.code else None
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
    for fault in built_faults(build, built, parameters):
        yield fault.at(scenario.file, line)
