"""Check of missions: in the scenarios that use them, with their robots; else for any robot that fits."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

from ..agent import Controller
from ..base.errors import Fault, InputError
from ..base.files import read_text, same_file
from ..catalog import TREES, AgentSpec, Catalog, Entry, ScenarioSpec, functions_in
from ..declare import replaced
from ..expression import NO_NAME
from ..plan import CheckOptions, mission_actions, mission_parameters
from ..running.build_agents import worldless_agents
from ..trees.examine import blocking_faults
from .stub_agent import stub_agent
from .xml_mission import MissionOptions, check_xml, declared_dialect

DEFAULT = MissionOptions()


def check_mission_file(entry: Entry, catalog: Catalog, options: MissionOptions = DEFAULT) -> Iterable[Fault]:
    """Check a mission in the scenarios that use it; else with its default parameters, if it requires none."""
    python = entry.path.suffix not in TREES
    if python:
        if "build" not in functions_in(entry.path):
            hint = "Write: def build(mission: Mission): ..."
            yield Fault("the mission has no function 'build'.", entry.path, hint=hint)
            return
        yield from blocking_faults(read_text(entry.path), entry.path)
        if not catalog.code:
            return
    if users := [] if options.given else list(_users(entry, catalog)):
        for scenario, agent in users:
            judged = catalog.code and scenario.file.resolve() in options.scenarios  # by the check of the scenario
            if not judged:
                yield from _in_use(entry, scenario, agent, catalog, options)
    elif not python:
        yield from _tree_alone(entry, catalog, options)
    else:
        build = catalog.load_mission(str(entry.path))
        if not any(p.required for p in mission_parameters(build).values()):
            yield from _alone(build, catalog, {})


def _users(entry: Entry, catalog: Catalog) -> Iterator[tuple[ScenarioSpec, AgentSpec]]:
    """Agents that use a mission in scenarios of the same project, with robots and missions that may be loaded."""
    root = catalog.root_of(entry.path)
    for found in catalog.list("scenario"):
        if catalog.root_of(found.path) != root:
            continue  # a shipped scenario means the shipped mission of this name
        try:
            scenario = catalog.read_scenario(str(found.path))
            agents = [a for a in scenario.agents if same_file(catalog.find("mission", a.mission).path, entry.path)]
            for agent in agents:
                code = catalog.robot_of(agent).code or catalog.python_of(entry, dialect=agent.nodes)
                if catalog.code or not code:
                    yield scenario, agent
        except InputError:
            continue  # reported by the check of the scenario


def _tree_alone(entry: Entry, catalog: Catalog, options: MissionOptions) -> Iterator[Fault]:
    dialect = options.dialect or declared_dialect(entry, catalog)
    options = replace(options, dialect=dialect)
    if refused := [] if catalog.code else catalog.python_of(entry, dialect=dialect):
        names = ", ".join(sorted(f"{each.kind} '{each.name}'" for each in refused))
        message = f"not judged, because it uses Python content, which --no-code refuses: {names}."
        yield Fault(message, entry.path, hint="Check it without --no-code.", warning=True, note=True)
    else:
        yield from check_xml(entry.path, catalog, options, lambda build, given: _alone(build, catalog, given))


def _in_use(
    entry: Entry, scenario: ScenarioSpec, agent: AgentSpec, catalog: Catalog, options: MissionOptions
) -> Iterator[Fault]:
    """Faults of a mission in a scenario; if the scenario has errors that hide those of the mission, also alone."""
    found = []
    try:
        for fault in _of_agent(scenario, agent, catalog):
            found.append(fault)
    except InputError as error:
        found += error.faults
    yield from found
    errors = [f.file for f in found if not f.warning]
    if errors and not {None, entry.path} & set(errors) and entry.path.suffix in TREES:
        yield from _tree_alone(entry, catalog, options)


def _of_agent(scenario: ScenarioSpec, agent: AgentSpec, catalog: Catalog) -> Iterator[Fault]:
    found = list[Fault]()
    alone = replaced(scenario, agents=(replaced(agent, rules=()),))
    if not worldless_agents(alone, catalog, seed=1, faults=found):
        message = f"not judged in the scenario '{scenario.name}': '{agent.name}' cannot be built without its mission."
        yield Fault(message, hint="Check the scenario.", warning=True, note=True)
        return
    yield from found


def _alone(build: Any, catalog: Catalog, parameters: dict[str, Any]) -> list[Fault]:
    """Faults of a mission that no scenario uses, for the robot of the catalog with the fewest errors.

    The robots of the project come first. Signals that this robot has not are only noted, because another one may.
    """
    best: list[Fault] | None = None
    actions, options = mission_actions(build), CheckOptions(robot="")
    for robot in catalog.list("robot"):
        found = list[Fault]()
        try:
            controller = Controller(
                build=build,
                parameters=parameters,
                actions=actions,
                schema=catalog.load_schema(),
                check_options=options,
            )
            stub_agent(catalog.load_robot(str(robot.path)), catalog.load_class, controller, found)
        except InputError:
            continue  # reported by the check of the robot
        if best is None or _misfit(found) < _misfit(best):
            best = found
        if not _of_signals(best):
            break
    return [_noted(fault) if fault in _of_signals(best or []) else fault for fault in best or []]


def mission_notes(agent: AgentSpec, catalog: Catalog) -> Iterable[Fault]:
    """Notes about the file of an agent's mission, such as that it was recognised as one of Nav2.

    Raises:
        InputError: The mission does not load.
    """
    trees = agent.mission and catalog.find("mission", agent.mission).path.suffix in TREES
    return getattr(catalog.load_mission(agent.mission, agent.nodes), "notes", ()) if trees else ()


def _misfit(faults: list[Fault]) -> tuple[int, int]:
    """Number of errors, and of those about unknown signals."""
    return sum(not fault.warning for fault in faults), len(_of_signals(faults))


def _of_signals(faults: list[Fault]) -> list[Fault]:
    """Errors that depend on the signals of the robot."""
    return [fault for fault in faults if not fault.warning and NO_NAME.search(fault.message)]


def _noted(fault: Fault) -> Fault:
    message = f"not judged, because no scenario uses this mission: {fault.message}"
    return replace(fault, message=message, hint="Check it again once a scenario uses it.", warning=True, note=True)
