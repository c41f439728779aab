"""Missions: that they build for a robot, and what their tree looks like."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from ..action import Parameter
from ..actions import action_table
from ..agent import Agent, Mind
from ..catalog import Catalog, Entry, functions_in
from ..errors import Fault
from ..expression import Environment, compile_expression
from ..plan import TreePlan, check_mission, mission_actions, mission_parameters
from ..units import NONE
from .paper import paper_agent


def check_mission_file(entry: Entry, catalog: Catalog) -> Iterable[Fault]:
    """All that is wrong with a mission, with its own parameters; where it needs some, only its form is held."""
    if entry.path.suffix != ".py":
        yield Fault("this version runs missions in Python only.", entry.path, hint="Write it as a .py file.")
    elif "build" not in functions_in(entry.path):
        yield Fault("the mission has no function 'build'.", entry.path, hint="Write: def build(mission: Mission): ...")
    elif catalog.code:
        build = catalog.load_mission(str(entry.path))
        if any(p.required for p in mission_parameters(build).values()):
            return
        robot = next(iter(catalog.list("robot")), None)
        if robot is not None:
            agent = paper_agent(catalog.load_robot(str(robot.path)), catalog.load_class)
            yield from built_faults(build, agent, {})


def built_faults(build: Any, agent: Agent, parameters: Mapping[str, Any]) -> list[Fault]:
    """All that is wrong with a mission when it is built for an agent with these parameters, in SI units."""
    environment = Environment.of(agent.knowledge.signals)
    return check_mission(
        build,
        actions=action_table(*mission_actions(build)),
        knowledge=agent.knowledge,
        clock=agent.clock,
        parameters=parameters,
        compile_guard=lambda text: compile_expression(text, environment),
    )


def draw_mission(catalog: Catalog, entry: Entry, robot: str) -> str:
    """A mission as text: its parameters and its tree.

    Raises:
        InputError: The mission, or the robot, is wrong.
    """
    build = catalog.load_mission(str(entry.path))
    declared = mission_parameters(build)
    given = {name: _any_value(p) for name, p in declared.items() if p.required}
    mind = Mind(build=build, parameters=given, actions=mission_actions(build))
    agent = paper_agent(catalog.load_robot(robot), catalog.load_class, mind)
    lines = [f"{entry.name}: {entry.doc}"]
    lines += [f"  {name} = {_shown(p)}" for name, p in declared.items()]
    plan = agent.plan
    if not isinstance(plan, TreePlan):
        return "\n".join([*lines, f"planned by {type(plan).__name__}, which is no tree."])
    kinds = {n.path: n for n in plan.outline}
    lines += [f"{'    ' * n.depth}{n.name}{_kind(n.kind)}" for n in kinds.values()]
    return "\n".join(lines)


def _any_value(parameter: Parameter) -> Any:
    """A value for a parameter that must be given, so that the tree can be drawn."""
    return parameter.name if parameter.type is str else parameter.type(1)


def _shown(parameter: Parameter) -> str:
    if parameter.required:
        return "(must be given)"
    unit = "" if parameter.dimension in (None, NONE) else f" {parameter.dimension}"
    return f"{parameter.default}{unit}"


def _kind(kind: str) -> str:
    return "" if kind == "Act" else f"  [{kind}]"
