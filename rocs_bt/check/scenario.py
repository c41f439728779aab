"""Check of scenarios: builds all referenced content as for a run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace

from ..actions import action_table
from ..agent.build import thresholds
from ..catalog import AgentSpec, Catalog, Entry, ScenarioSpec, robot_locomotion
from ..errors import Fault, InputError
from ..expression import Environment
from ..files import read_text
from ..plan import mission_actions
from ..reactive import Rule, load_rules, rule_misfits
from ..reactive.analysis import analyse_fit
from ..record import TRUTH
from ..running import requirement_faults
from ..running.options import Build
from ..running.share import share_faults
from ..simulation import on_hardware
from ..trees.examine import blocking_faults
from .feasible import check_feasible
from .mission_use import idle_controller, mission_faults, words_in
from .protection import unprotected
from .rules import examined, inactive_faults
from .stub_agent import stub_agent

Missions = Mapping[str, Build]
NO_MISSIONS: Missions = {}


def check_scenario_file(entry: Entry, catalog: Catalog, missions: Missions = NO_MISSIONS) -> Iterable[Fault]:
    """Check the file of a scenario, and the scenario; see `scenario_faults`."""
    # Read with code allowed: reading runs no code, and most checks do not either.
    reader = catalog if catalog.code else Catalog(catalog.project)
    return scenario_faults(reader.load_scenario(str(entry.path)), catalog, missions)


def scenario_faults(scenario: ScenarioSpec, catalog: Catalog, missions: Missions = NO_MISSIONS) -> Iterator[Fault]:
    """Check a scenario: its agents' missions and rules, and whether its goals can be reached.

    A scenario without other errors is set up as for a run, so that everything that a run refuses is an error here too.

    Args:
        scenario: The scenario.
        catalog: Source of the content.
        missions: Mission functions that replace the scenario's, by agent. They are not called: only the run does.
    """
    found = []
    for fault in _faults(scenario, catalog, missions):
        found.append(fault)
        yield fault
    robots = [catalog.load_robot(name) for name in scenario.robots]
    # Not simulated: robots with code that may not run, and robots with drivers for hardware.
    code = catalog.code or not any(robot.code for robot in robots)
    if code and all(fault.warning for fault in found) and not any(on_hardware(catalog, robot) for robot in robots):
        yield from check_feasible(scenario, catalog, missions)


def _faults(scenario: ScenarioSpec, catalog: Catalog, missions: Missions) -> Iterator[Fault]:
    """Faults that are found without a simulated world."""
    for agent in scenario.agents:
        try:
            build = missions.get(agent.name)
            own = agent if build is None else replace(agent, mission="", parameters={})
            yield from _agent_faults(scenario, own, catalog, build)
        except InputError as error:
            yield from error.at(scenario.file, agent.line).faults
    yield from share_faults(scenario, catalog.load_schema())
    yield from _late_pushes(scenario)
    yield from _slow_sensors(scenario, catalog)


_SLOW = 0.2  # [s] interval of readings above which reflexes and path following are late: that of the watchdog


def _slow_sensors(scenario: ScenarioSpec, catalog: Catalog) -> Iterator[Fault]:
    """Warn of a common sensor rate with which the robots drive too far from one reading to the next."""
    hz = scenario.rate.sensors
    if hz is None or 1.0 / hz <= _SLOW:
        return
    for name in dict.fromkeys(agent.robot for agent in scenario.agents):
        locomotion = robot_locomotion(catalog.load_robot(name).locomotion)
        speed = max(locomotion.axis_limits(axis).max_speed for axis in locomotion.axes if axis != "wz")
        message = (
            f"at {hz:g} Hz, {name} drives up to {speed / hz:.2g} m from one reading of its sensors to the next: "
            "reflexes are late, and it may never reach its goal."
        )
        hint = f"Use at least {1.0 / _SLOW:g} Hz, better the {scenario.rate.control:g} Hz of the control."
        yield Fault(message, scenario.file, scenario.rate.line, hint=hint, warning=True)


def _late_pushes(scenario: ScenarioSpec) -> Iterable[Fault]:
    """Warnings about pushes that do not happen, or may not happen, because the run ends before them."""
    end = scenario.duration
    for push in scenario.pushes:
        if push.at >= end or push.until > end:
            when = f"at {push.at:g} s" if push.at >= end else f"from {push.at:g} s to {push.until:g} s"
            what = "does not happen" if push.at >= end else "may not happen"
            message = f"the push of {push.robot} {when} {what}: the run ends at {end:g} s."
            hint = "Push earlier, or increase the scenario's duration."
            yield Fault(message, scenario.file, push.line, hint=hint, warning=True)


def _agent_faults(scenario: ScenarioSpec, agent: AgentSpec, catalog: Catalog, build: Build | None) -> Iterable[Fault]:
    robot = catalog.load_robot(agent.robot)
    if robot.code and not catalog.code:
        return
    built = stub_agent(robot, catalog.load_class, idle_controller(scenario, agent, catalog), agent.name)
    environment = Environment.of(built.knowledge.signals, robot.values)
    if build is None and catalog.code:
        build = catalog.load_mission(agent.mission, agent.nodes)
    actions = action_table(*(mission_actions(build) if build else ()))
    modes = words_in(catalog.find("mission", agent.mission).path) if agent.mission else None
    period = scenario.rate.control_rate.period
    found: list[Rule] = []
    for name in agent.rules:
        file = catalog.find("rules", name).path
        own = thresholds(robot, file)
        yield from examined(file, robot, environment, actions, catalog)
        with suppress(InputError):  # reported already
            rules = load_rules(file, environment, actions, overrides=own)
            yield from analyse_fit(rules.rules, environment, period, modes)
            yield from inactive_faults(rules, robot.name, catalog)
            yield from rule_misfits(rules.rules, actions, built.knowledge)
            found += rules.rules
    if on_hardware(catalog, robot):
        yield from (fault.at(scenario.file, agent.line) for fault in unprotected(built, robot, found))
    signals = built.knowledge.signals
    known = Environment.packed([*(signals.spec(name) for name in signals.names), *TRUTH])
    yield from requirement_faults(scenario, agent.name, known)
    for entry in catalog.content_of_controller(agent):
        if entry.path.suffix == ".py":
            yield from blocking_faults(read_text(entry.path), entry.path)
    if build is not None and agent.mission:
        yield from mission_faults(scenario, agent, catalog, built)
