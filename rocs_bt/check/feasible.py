"""Feasibility of scenarios: whether starts and goals are free, and whether reflexes allow to reach the goals."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..agent import Agent
from ..base.errors import Fault
from ..base.geometry import Pose2
from ..base.units import TIME
from ..catalog import AgentSpec, Catalog, PlaceSpec, ScenarioSpec
from ..declare import location_of, replaced
from ..devices.mujoco import MujocoWorld, compose_world
from ..devices.mujoco.body import FLOOR, geom_labels
from ..event import NullSink
from ..expression import Node, evaluate
from ..expression.node import TEMPORAL_OPS
from ..plan import Plan
from ..reactive import Rule, RuleModel
from ..reactive.rule_model import describe, stateless_rule
from ..running import Run
from ..running.simulated_stage import simulated_agents
from ..simulation import POSES_TRIED, FreePose, SimulatedWorld, build_world, free_goal_poses
from ..simulation.identified_file import identified_path
from ..simulation.identify import WORLD
from ..simulation.scripts import FREE
from .identified import TOLERANCE
from .robot import trial_faults

_EASY = 0.5  # fraction of free poses at a goal below which the goal is reported as tight
_AT_ONCE = 0.2  # [s] maximum `for` of a rule that fires before a robot that drives to a goal is there
_MANY = 25  # number of an agent's goals that are checked in every respect, and of warnings about them
_TIME = TIME.exponents.index(1)
_AWAY = 1000.0  # [m] distance of moving objects from the world while the goals are checked


def check_feasible(run: Run) -> Iterator[Fault]:
    """Check the feasibility of a prepared run; an unreachable goal is a warning, since the scenario still runs.

    A goal needs a pose within its tolerance at which the robot has no contact and no reflex fires; a goal with few
    free poses is also reported. Every goal that an agent knows is checked. Each robot is moved in a world of its own.
    """
    scenario, catalog = run.spec, run.catalog
    yield from _outside(scenario, run.world)
    if not catalog.code:
        return
    for agent in scenario.agents:
        others = tuple(m for m in scenario.actors if not m.robot)
        alone = replaced(scenario, agents=(replaced(agent, latency=0.0),), actors=others, tables={})
        world = build_world(alone, catalog, 1, NullSink())
        (built,) = simulated_agents(alone, world, catalog, NullSink(), {agent.name: Plan.idle})
        yield from _in_world(scenario, agent, world, built, catalog)


def _in_world(
    scenario: ScenarioSpec, agent: AgentSpec, world: SimulatedWorld, built: Agent, catalog: Catalog
) -> Iterator[Fault]:
    """Faults of an agent that is alone in the world: of its sensors, monitors, goals, and floor."""
    _remove_movers(scenario, world)
    faults = list(trial_faults(built, world.robots[agent.name], world.sensors[agent.name]))
    yield from faults
    if not faults:  # without readings the reflexes cannot be evaluated
        goals = [place for place in scenario.places if place.kind == "goal" and agent.name in place.agents]
        yield from _goal_warnings(world, built, agent, goals, scenario.file)
        yield from floor_faults(scenario, agent, world.world, catalog)


def _remove_movers(scenario: ScenarioSpec, simulated: SimulatedWorld) -> None:
    """Place the objects that a script moves far away, since they need not stay where they start."""
    _, _, right, _ = simulated.world.bounds()
    for actor in scenario.actors:
        if not actor.robot and actor.script != FREE:
            simulated.world.place_object(actor.name, Pose2(right + _AWAY, 0.0))


def _outside(scenario: ScenarioSpec, simulated: SimulatedWorld) -> Iterable[Fault]:
    """Places, grounds and starts of actors outside of the world; an agent's start there is refused earlier."""
    left, low, right, high = simulated.world.bounds()
    named = [(f"the start of {m.name}", m.pose, location_of(m).line) for m in scenario.actors]
    named += [(f"the {p.kind} '{p.name}'", p.pose, location_of(p).line) for p in scenario.places]
    named += [(f"the ground '{g.name}'", g.pose, location_of(g).line) for g in scenario.grounds]
    for what, pose, line in named:
        if pose.x < left or pose.x > right or pose.y < low or pose.y > high:
            yield Fault(
                f"{what} at x = {pose.x:g} m, y = {pose.y:g} m is outside of the world, which goes from x = {left:.3g} "
                f"to {right:.3g} m and from y = {low:.3g} to {high:.3g} m.",
                scenario.file,
                line,
                hint="Move it inside.",
                warning=True,
            )


def _goal_warnings(
    simulated: SimulatedWorld, built: Agent, agent: AgentSpec, goals: Sequence[PlaceSpec], file: Path
) -> Iterator[Fault]:
    """Warnings about the goals of an agent alone in the world; of many goals, most are only checked to be free."""
    found = 0
    for i, goal in enumerate(goals):
        fault = _goal_warning(simulated, built, agent, goal, thorough=i < _MANY)
        if fault is not None:
            yield replace(fault, file=file, line=location_of(goal).line, warning=True)
            found += 1
        if found == _MANY and i + 1 < len(goals):
            message = f"{len(goals) - i - 1} further goals of {agent.name} were not checked."
            yield Fault(message, file, location_of(goal).line, warning=True, note=True)
            return
    if len(goals) > _MANY:
        message = f"of {len(goals) - _MANY} goals of {agent.name}, only their first free pose was searched."
        yield Fault(message, file, location_of(goals[_MANY]).line, warning=True, note=True)


def _goal_warning(
    simulated: SimulatedWorld, built: Agent, agent: AgentSpec, goal: PlaceSpec, *, thorough: bool
) -> Fault | None:
    """Warning about a goal with no or few free poses, or at which a reflex always fires; None if it is reachable.

    If `thorough`, evaluates the rules too, and looks for a tight goal.
    """
    world, what = simulated.world, f"the goal '{goal.name}' of {agent.name} cannot be reached"
    height = goal.z if simulated.robots[agent.name].locomotion.kind == "flying" else None
    poses = free_goal_poses(world, agent.name, goal.pose, goal.tolerance, height=height)
    first = next(poses, None)
    if first is None:
        world.place(agent.name, goal.pose._replace(yaw=0.0), height)
        depth, obstacle = world.clearance(agent.name)
        where = f"at the goal itself its hull is {max(-depth, 0.0):.2f} m inside '{obstacle}'"
        message = f"{what}: {agent.robot} has no free pose within {goal.tolerance:g} m of it; {where}."
        return Fault(message, hint="Move the goal or the obstacle.")
    if not thorough:
        return None
    free = [first, *poses]
    built.knowledge.world.pursue(goal.name)
    fires = ""
    for each in free:
        world.place(agent.name, each.pose, height)
        fires = _firing(built, each.pose, goal.pose)
        if not fires:
            return None if len(free) >= _EASY * POSES_TRIED else _tight(agent, goal, free)
    message = f"{what}: at every free pose within {goal.tolerance:g} m of it a reflex fires; at the last, {fires}."
    return Fault(message, hint="Move the goal or the obstacle, or use goal_distance in the rule.")


def _tight(agent: AgentSpec, goal: PlaceSpec, poses: Sequence[FreePose]) -> Fault:
    obstacles = ", ".join(sorted({f"'{pose.nearest}'" for pose in poses if pose.nearest}))
    message = (
        f"the goal '{goal.name}' of {agent.name} is tight: {agent.robot} is free at {len(poses)} of the {POSES_TRIED} "
        f"poses tried within {goal.tolerance:g} m of it; obstacles: {obstacles}."
    )
    return Fault(message, hint="It can be reached, but contacts are likely.")


def _firing(agent: Agent, pose: Pose2, goal: Pose2) -> str:
    """Rule that certainly fires at the robot's present pose, with its signal values; empty if none does.

    A rule counts only if the position alone decides its guard: whatever the motion is and was, and without signals that
    are invalid here because no Analyze block runs.
    """
    t = agent.clock.now()
    for monitor in agent.monitors:
        monitor.run(t, 0)
    signals = agent.knowledge.signals
    if any(signal.name == "pose" for analyze in agent.analyzes for signal in analyze.signals()):
        # An estimator cannot follow jumps between poses; its estimate is assumed to be correct.
        signals.write("pose", [*pose], t)
        signals.write("goal_distance", pose.distance(goal), t)
    row = signals.snapshot(t).copy()
    for name in signals.names:
        spec, at = signals.spec(name), signals.slice_of(name).start
        dimensions = [spec.dimension] * spec.size if spec.dimension is not None else spec.dimensions
        moving = [i for i, dimension in enumerate(dimensions) if dimension.exponents[_TIME] < 0]
        row[[at + i for i in moving]] = math.nan
    values = [*row.tolist(), math.nan]
    for model in agent.knowledge.reactive_models:
        for rule in model.rules.rules if isinstance(model, RuleModel) else ():
            if rule.hold <= _AT_ONCE and not rule.modes and evaluate(_momentary(rule, len(row)), values) is True:
                return f"{rule.name} with {describe(rule, True, values)()}"
    return ""


def _momentary(rule: Rule, unknown: int) -> Node:
    """Guard of a rule with reads of the index `unknown` instead of operators on earlier snapshots."""
    return stateless_rule(rule, {node: unknown for node in rule.when.node.walk() if node.op in TEMPORAL_OPS}).when.node


_SETTLED = 40  # [physics steps] until a robot that was placed rests on the floor


def floor_faults(scenario: ScenarioSpec, agent: AgentSpec, world: MujocoWorld, catalog: Catalog) -> Iterator[Fault]:
    """Warn of a floor on which an agent's robot has another friction than where its motion was measured.

    The robot is placed at its start, and settles on the floor.
    """
    robot = catalog.robot_of(agent)
    if identified_path(robot) is None or robot.locomotion.kind == "flying":
        return
    world.place(agent.name, agent.pose)
    world.advance(_SETTLED)
    model, labels = world.model, geom_labels(world.model, world.robots)
    for contact in world.data.contact:
        own = contact.geom1 if labels[contact.geom1] == agent.name else contact.geom2
        if {labels[contact.geom1], labels[contact.geom2]} != {FLOOR, agent.name} or contact.dim == 1:
            continue
        found, measured = float(contact.friction[0]), _measured_friction(model, own, catalog)
        if abs(found - measured) > TOLERANCE * measured:
            message = (
                f"'{robot.name}' is not identified on this floor: its friction is {found:.3g}, not {measured:.3g} as "
                "where the motion was measured. It may stop late and cut corners."
            )
            hint = (
                f"Give the floor of '{scenario.world}' the friction of that of '{WORLD}', or identify the robot on it."
            )
            yield Fault(message, scenario.file, location_of(agent).line, hint=hint, warning=True)
            return


def _measured_friction(model: Any, geom: int, catalog: Catalog) -> float:
    """Sliding friction of a robot's geom on the floor of the world in which robots are identified."""
    plane = compose_world(catalog.find("world", WORLD).path, [], within=catalog.roots).model
    floor = geom_labels(plane, {}).index(FLOOR)
    sides = [(int(m.geom_priority[g]), float(m.geom_friction[g][0])) for m, g in ((model, geom), (plane, floor))]
    first = max(priority for priority, _ in sides)
    return max(friction for priority, friction in sides if priority == first)
