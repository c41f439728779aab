"""Scenarios: everything that one names, put together as a run would, but for the running."""

from __future__ import annotations

from collections.abc import Iterable

from ..actions import action_table
from ..agent import Mind
from ..catalog import AgentSpec, Catalog, Entry, ScenarioSpec
from ..errors import Fault, InputError
from ..expression import Environment
from ..plan import mission_actions, mission_arguments
from ..reactive import check_rules
from .feasible import check_feasible
from .mission import built_faults
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
    if catalog.code or not any(catalog.load_robot(name).code for name in scenario.robots):
        yield from check_feasible(scenario, catalog)


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
    built = paper_agent(robot, catalog.load_class, Mind(build=idle, places=places))
    environment = Environment.of(built.knowledge.signals)
    build = catalog.load_mission(agent.mission) if catalog.code else None
    actions = action_table(*(mission_actions(build) if build else ()))
    for name in agent.rules:
        yield from check_rules(catalog.find("rules", name).path, environment, actions)
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
