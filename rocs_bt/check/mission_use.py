"""Missions in use: built for an agent of a scenario, with its robot, parameters and initial knowledge."""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from ..actions import ACTIONS, action_table
from ..actions.heading import looked_at
from ..agent import Agent, Controller
from ..catalog import TREES, AgentSpec, Catalog, RobotSpec, ScenarioSpec, mission_values
from ..drivers.ros2.known_types import installed_types
from ..errors import Fault, InputError
from ..expression import Environment, compile_expression
from ..files import read_text
from ..plan import check_mission, mission_actions
from .stub_agent import idle

_GOALS = ("goal", "leader", "heading")
"""Names of parameters for a place or a robot to go to or to look at."""


def idle_controller(scenario: ScenarioSpec, agent: AgentSpec, catalog: Catalog) -> Controller:
    """Controller with an agent's initial knowledge and an idle mission."""
    return Controller(
        build=idle,
        places=[p for p in scenario.places if agent.name in p.agents],
        facts=scenario.facts_of(agent.name),
        peers={name: tag for name, tag in scenario.tags.items() if name != agent.name},
        schema=catalog.load_schema(),
    )


def mission_faults(scenario: ScenarioSpec, agent: AgentSpec, catalog: Catalog, built: Agent) -> Iterator[Fault]:
    """Faults of an agent's mission with its parameters, its robot and its initial knowledge.

    Args:
        scenario: Scenario of the agent.
        agent: The agent.
        catalog: Catalog that may load the mission.
        built: Stub agent of the robot, with the controller from `idle_controller`.

    Raises:
        InputError: The mission does not load, or does not take its parameters.
    """
    robot, at = catalog.load_robot(agent.robot), agent.parameters_at
    build = catalog.load_mission(agent.mission, agent.nodes)
    found = built_faults(
        build,
        built,
        mission_values(build, agent),
        f"{robot.name} ({agent.name} in {scenario.name})",
        later=_later(scenario, agent, robot, catalog),
        ros_types=partial(installed_types, robot.ros2),
        position=(lambda name: (None, 0, 0)) if at is None else at.of,
        privileged=agent.privileged,
    )
    for fault in found:
        yield fault.at(scenario.file, agent.line) if at is None else fault.at(*at.of(""))


def mission_notes(agent: AgentSpec, catalog: Catalog) -> Iterable[Fault]:
    """Notes about the file of an agent's mission, such as that it was recognised as one of Nav2.

    Raises:
        InputError: The mission does not load.
    """
    trees = agent.mission and catalog.find("mission", agent.mission).path.suffix in TREES
    return getattr(catalog.load_mission(agent.mission, agent.nodes), "notes", ()) if trees else ()


def _later(scenario: ScenarioSpec, agent: AgentSpec, robot: RobotSpec, catalog: Catalog) -> set[str] | None:
    """Names of nodes that may be added to an agent's Knowledge during the run; None if they cannot be determined.

    The reason for None is that sharing, user blocks and TrackObjects may add nodes with any name.
    """
    if scenario.share is not None or robot.code or any(spec.cls == "TrackObjects" for spec in robot.analyzers):
        return None
    mission = catalog.find("mission", agent.mission)
    python = catalog.python_of(mission, agent.parameters.values(), agent.nodes)
    declared = {fact.node for fact in scenario.facts_of(agent.name)}
    return declared | nodes_in([mission.path, *(entry.path for entry in python)])


def built_faults(build: Any, agent: Agent, parameters: Mapping[str, Any], robot: str, **more: Any) -> list[Fault]:
    """Faults of a mission built for an agent.

    Args:
        build: The mission's `build` function.
        agent: Agent of the mission.
        parameters: Mission parameters, in SI units.
        robot: Robot of the agent in messages; empty if it is an arbitrary one, for which the mission is not meant.
        more: Further arguments of `check_mission`.
    """
    environment = Environment.of(agent.knowledge.signals)
    return check_mission(
        build,
        actions=action_table(*mission_actions(build)),
        knowledge=agent.knowledge,
        clock=agent.clock,
        parameters=parameters,
        compile_guard=lambda text: compile_expression(text, environment),
        robot=robot,
        **more,
    )


def words_in(mission: Path) -> set[str] | None:
    """All words in the string literals of a mission's file; None if the file is unreadable.

    A check uses them to find modes that the mission never sets.
    """
    try:
        text = read_text(mission)
        if mission.suffix != ".py":
            return set(re.findall(r"\w+", text))
        found = _texts(text)
    except (InputError, ValueError, SyntaxError, RecursionError, MemoryError):
        return None
    return {word for value in found for word in re.findall(r"\w+", value)}


def nodes_in(files: Iterable[Path]) -> set[str]:
    """Strings in content files that may name nodes of Knowledge which the content itself adds.

    A string that occurs only as the goal of an action is not included, since something else must then add the node.
    """
    found: Counter[str] = Counter()
    goals: Counter[str] = Counter()
    for file in files:
        try:
            text = read_text(file)
            if file.suffix == ".py":
                found.update(_texts(text))
                goals.update(_goals(text))
            else:
                found.update(looked_at(value) or value for value in re.findall(r"""=\s*["']([^"']*)["']""", text))
                goals.update(_xml_goals(text))
        except (InputError, ValueError, SyntaxError, RecursionError, MemoryError):
            continue  # reported where the file itself is checked
    return {text for text, count in found.items() if count > max(1, goals[text])}


def _xml_goals(text: str) -> list[str]:
    """Goals of actions and subtrees in an XML mission; other nodes may add these goals to Knowledge."""
    tags = re.findall(r"<(\w+)((?:[^<>\"']|\"[^\"]*\"|'[^']*')*)>", text)
    going = [attributes for tag, attributes in tags if tag == "SubTree" or tag in ACTIONS]
    given = [pair for each in going for pair in re.findall(r"""(\w+)\s*=\s*["']([^"']*)["']""", each)]
    return [looked_at(value) or value for name, value in given if name in _GOALS]


def _goals(python: str) -> list[str]:
    """Goals of actions and subtrees in a Python mission; other nodes may add these goals to Knowledge."""
    found = [node for node in ast.walk(ast.parse(python)) if isinstance(node, ast.Call)]
    calls = [call for call in found if isinstance(call.func, ast.Attribute) and call.func.attr in ("act", "tree")]
    values = [word.value for call in calls for word in call.keywords if word.arg in _GOALS]
    texts = [node.value for node in values if isinstance(node, ast.Constant) and isinstance(node.value, str)]
    return [looked_at(text) or text for text in texts]


def _texts(python: str) -> list[str]:
    """String constants in a Python file."""
    found = [node.value for node in ast.walk(ast.parse(python)) if isinstance(node, ast.Constant)]
    return [looked_at(value) or value for value in found if isinstance(value, str)]
