"""Check of scenarios: builds all referenced content as for a run, and checks that starts and goals are free."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import replace

from ..actions import action_table
from ..agent import Agent, Controller, Rates, Runtime, build_agent
from ..agent.build import thresholds
from ..catalog import AgentSpec, Catalog, Entry, PlaceSpec, RobotSpec, ScenarioSpec
from ..errors import Fault, InputError
from ..event import NullSink
from ..expression import Environment
from ..geometry import Pose2
from ..plan import mission_actions, mission_arguments
from ..reactive import Rule, RuleModel, load_rules, rule_misfits
from ..reactive.analysis import examine_fit
from ..record import TRUTH
from ..simulation import (
    POSES_TRIED,
    FreePose,
    SimulatedWorld,
    build_world,
    free_goal_poses,
    on_hardware,
    requirement_faults,
)
from ..simulation.share import share_faults
from .mission import built_faults, nodes_in, words_in
from .protection import unprotected
from .robot import trial_faults
from .rules import inactive_faults
from .stub_agent import idle, stub_agent


def check_scenario_file(entry: Entry, catalog: Catalog) -> Iterable[Fault]:
    """Check a scenario: its file, its agents' missions and rules, and whether its goals can be reached."""
    # Read with code allowed: reading runs no code, and most checks do not either.
    scenario = Catalog(catalog.project).load_scenario(str(entry.path))
    for agent in scenario.agents:
        try:
            yield from _agent_faults(scenario, agent, catalog)
        except InputError as error:
            yield from error.at(scenario.file, agent.line).faults
    yield from share_faults(scenario, catalog.load_schema())
    yield from _late_pushes(scenario)
    robots = [catalog.load_robot(name) for name in scenario.robots]
    # Not simulated: robots with code that may not run, and robots with drivers for hardware.
    if all((catalog.code or not robot.code) and not on_hardware(catalog, robot) for robot in robots):
        yield from check_feasible(scenario, catalog)


def agent_warnings(scenario: ScenarioSpec, catalog: Catalog) -> list[Fault]:
    """Warnings about the agents of a scenario and about pushes after its end.

    Raises:
        InputError: An agent can be built but has faults, such as a goal that is no place of the scenario.
    """
    warnings = list(_late_pushes(scenario))
    for agent in scenario.agents:
        try:
            found = list(_agent_faults(scenario, agent, catalog))
            if wrong := [fault for fault in found if not fault.warning]:
                _build(scenario, agent, catalog)
        except InputError:
            continue  # raised again with better positions when the agent is built
        if wrong:
            raise InputError(*dict.fromkeys(wrong))
        warnings += found
    return warnings


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


def _idle_controller(scenario: ScenarioSpec, agent: AgentSpec, catalog: Catalog) -> Controller:
    """Controller with an agent's initial knowledge and an idle mission."""
    return Controller(
        build=idle,
        places=[p for p in scenario.places if agent.name in p.agents],
        facts=scenario.facts_of(agent.name),
        peers={name: tag for name, tag in scenario.tags.items() if name != agent.name},
        schema=catalog.load_schema(),
    )


def _build(scenario: ScenarioSpec, agent: AgentSpec, catalog: Catalog) -> None:
    """Build an agent with its mission and its rules.

    Raises:
        InputError: The agent cannot be built.
    """
    build = catalog.load_mission(agent.mission, agent.nodes)
    controller = replace(
        _idle_controller(scenario, agent, catalog),
        build=build,
        mission=agent.mission,
        parameters=mission_arguments(build, agent.parameters),
        rules=[catalog.find("rules", name).path for name in agent.rules],
        actions=mission_actions(build),
    )
    stub_agent(catalog.load_robot(agent.robot), catalog.load_class, controller, agent.name)


def _agent_faults(scenario: ScenarioSpec, agent: AgentSpec, catalog: Catalog) -> Iterable[Fault]:
    robot = catalog.load_robot(agent.robot)
    if robot.code and not catalog.code:
        return
    built = stub_agent(robot, catalog.load_class, _idle_controller(scenario, agent, catalog), agent.name)
    environment = Environment.of(built.knowledge.signals)
    build = catalog.load_mission(agent.mission, agent.nodes) if catalog.code else None
    actions = action_table(*(mission_actions(build) if build else ()))
    period, modes = scenario.rate.control_rate.period, words_in(catalog.find("mission", agent.mission).path)
    found: list[Rule] = []
    for name in agent.rules:
        file = catalog.find("rules", name).path
        own = thresholds(robot, file)
        yield from examine_fit(file, environment, actions, own, period, modes)
        with suppress(InputError):  # reported already
            rules = load_rules(file, environment, actions, overrides=own)
            yield from inactive_faults(rules, robot.name, catalog)
            yield from rule_misfits(rules.rules, actions, built.knowledge)
            found += rules.rules
    if on_hardware(catalog, robot):
        yield from (fault.at(scenario.file, agent.line) for fault in unprotected(built, robot, found))
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
    later, named = _later(scenario, agent, robot, catalog), f"{robot.name} ({agent.name} in {scenario.name})"
    for fault in built_faults(build, built, parameters, later, robot=named, ros2=robot.ros2):
        yield fault.at(scenario.file, line)


def _later(scenario: ScenarioSpec, agent: AgentSpec, robot: RobotSpec, catalog: Catalog) -> set[str] | None:
    """Names of nodes that may be added to an agent's Knowledge during the run; None if they cannot be determined.

    The reason for None is that sharing, user blocks and TrackObjects may add nodes with any name.
    """
    if scenario.share is not None or robot.code or any(spec.cls == "TrackObjects" for spec in robot.analyzers):
        return None
    mission = catalog.find("mission", agent.mission)
    python = catalog.python_of(mission, agent.parameters.values())
    declared = {fact.node for fact in scenario.facts_of(agent.name)}
    return declared | nodes_in([mission.path, *(entry.path for entry in python)])


_EASY = 0.5  # fraction of free poses at a goal below which the goal is reported as tight
_LATER = 1e6  # [s] longer than the `for` of any rule, so that a rule with a true guard fires


def check_feasible(scenario: ScenarioSpec, catalog: Catalog) -> Iterable[Fault]:
    """Check the feasibility of a scenario; an unreachable goal is a warning, since the scenario still runs.

    A goal needs a pose within its tolerance at which the robot has no contact and no reflex fires; a goal with few
    free poses is also reported. Every goal that an agent knows is checked.

    Raises:
        InputError: The world does not compile, or a robot's start pose is not free.
    """
    yield from _outside(scenario, build_world(scenario, catalog, 1, NullSink()))
    for agent in scenario.agents:
        others = tuple(m for m in scenario.actors if not m.robot)
        world = build_world(replace(scenario, agents=(agent,), actors=others), catalog, 1, NullSink())
        built = _single_agent(scenario, catalog, agent, world)
        faults = list(trial_faults(built, world.robots[agent.name], world.sensors[agent.name]))
        yield from faults
        if faults:
            continue  # without readings the reflexes cannot be evaluated
        for goal in scenario.places:
            if goal.kind == "goal" and agent.name in goal.agents:
                fault = _goal_warning(world, built, agent, goal)
                if fault is not None:
                    yield replace(fault, file=scenario.file, line=goal.line, warning=True)


def _outside(scenario: ScenarioSpec, simulated: SimulatedWorld) -> Iterable[Fault]:
    """Places, grounds and starts of actors outside of the world; an agent's start there is refused earlier."""
    left, low, right, high = simulated.world.bounds()
    named = [(f"the start of {m.name}", m.pose, m.line) for m in scenario.actors]
    named += [(f"the {p.kind} '{p.name}'", p.pose, p.line) for p in scenario.places]
    named += [(f"the ground '{g.name}'", g.pose, g.line) for g in scenario.grounds]
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


def _single_agent(scenario: ScenarioSpec, catalog: Catalog, agent: AgentSpec, world: SimulatedWorld) -> Agent:
    """Build an agent with its rules and an idle mission, alone in the world."""
    controller = Controller(
        build=idle,
        rules=[catalog.find("rules", name).path for name in agent.rules],
        places=[p for p in scenario.places if agent.name in p.agents],
        facts=scenario.facts_of(agent.name),
        schema=catalog.load_schema(),
    )
    rates = Rates(scenario.rate.control_rate, scenario.rate.plan_rate)
    runtime = Runtime(world.clock, NullSink())
    return build_agent(agent.name, world.devices(agent.name), controller, rates, runtime, load_class=catalog.load_class)


def _goal_warning(simulated: SimulatedWorld, built: Agent, agent: AgentSpec, goal: PlaceSpec) -> Fault | None:
    """Warning about a goal with no or few free poses for an agent alone in the world; None if it is reachable."""
    world, what = simulated.world, f"the goal '{goal.name}' of {agent.name} cannot be reached"
    height = goal.z if simulated.robots[agent.name].locomotion.kind == "flying" else None
    poses = free_goal_poses(world, agent.name, goal.pose, goal.tolerance, height=height)
    if not poses:
        world.place(agent.name, goal.pose._replace(yaw=0.0), height)
        depth, obstacle = world.clearance(agent.name)
        where = f"at the goal itself its hull is {max(-depth, 0.0):.2f} m inside '{obstacle}'"
        message = f"{what}: {agent.robot} has no free pose within {goal.tolerance:g} m of it; {where}."
        return Fault(message, hint="Move the goal or the obstacle.")
    built.knowledge.world.pursue(goal.name)
    fires = ""
    for free in poses:
        world.place(agent.name, free.pose, height)
        fires = _firing(built, free.pose, goal.pose)
        if not fires:
            return None if len(poses) >= _EASY * POSES_TRIED else _tight(agent, goal, poses)
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
    """Rule that fires at the robot's present pose, with its signal values; empty if none fires."""
    t = agent.clock.now()
    for monitor in agent.monitors:
        monitor.run(t, 0)
    if any(signal.name == "pose" for analyze in agent.analyzes for signal in analyze.signals()):
        # An estimator cannot follow jumps between poses; its estimate is assumed to be correct.
        agent.knowledge.signals.write("pose", [*pose], t)
        agent.knowledge.signals.write("goal_distance", pose.distance(goal), t)
    snapshot = agent.knowledge.signals.snapshot(t)
    for model in agent.knowledge.reactive_models:
        if isinstance(model, RuleModel):
            model.reset()
            for moment in (t, t + _LATER):
                for reflex in model.react(snapshot, moment):
                    if reflex.latched:
                        return f"{reflex.rule} with {reflex.describe()}"
    return ""
