"""Whether a scenario can be played: everybody can stand at the start, and every goal can be reached."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from ..agent import Agent, Mind, Rates, Runtime, build_agent
from ..catalog import AgentSpec, Catalog, PlaceSpec, ScenarioSpec
from ..errors import Fault
from ..event import NullSink
from ..geometry import Pose2
from ..reactive import RuleModel
from ..simulation import POSES_TRIED, FreePose, SimulatedWorld, build_world, free_goal_poses
from .paper import idle
from .trial import trial_faults

_EASY = 0.5  # the share of poses at a goal that must be free for nobody to worry
_LATER = 1e6  # [s]; by then a guard that holds has held for any rule's `for`


def check_feasible(scenario: ScenarioSpec, catalog: Catalog) -> Iterable[Fault]:
    """What keeps a scenario from being played; a goal that cannot be reached is a warning, as the run still runs.

    A goal needs a pose within its tolerance at which the robot touches nothing and no reflex fires; a goal with few
    such poses is reported too. Every goal that an agent knows is checked.

    Raises:
        InputError: The world does not compile, or a robot cannot be at its start.
    """
    yield from _beyond(scenario, build_world(scenario, catalog, 1, NullSink()))
    for agent in scenario.agents:
        stage = build_world(replace(scenario, agents=(agent,), movers=()), catalog, 1, NullSink())
        built = _build(scenario, catalog, agent, stage)
        faults = list(trial_faults(built, stage.robots[agent.name], stage.sensors[agent.name]))
        yield from faults
        if faults:
            continue  # no reflex can be asked about poses that cannot be sensed
        for goal in scenario.places:
            if goal.kind == "goal" and agent.name in goal.agents:
                fault = _doubt(stage, built, agent, goal)
                if fault is not None:
                    yield replace(fault, file=scenario.file, line=goal.line, warning=True)


def _beyond(scenario: ScenarioSpec, stage: SimulatedWorld) -> Iterable[Fault]:
    """Places, and starts of things, beyond all that is in the world; a robot's start there is refused before."""
    left, low, right, high = stage.world.bounds()
    named = [(f"the start of {m.name}", m.pose, m.line) for m in scenario.movers]
    named += [(f"the {p.kind} '{p.name}'", p.pose, p.line) for p in scenario.places]
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


def _build(scenario: ScenarioSpec, catalog: Catalog, agent: AgentSpec, stage: SimulatedWorld) -> Agent:
    """An agent alone in the world, without a mission."""
    mind = Mind(
        build=idle,
        rules=[catalog.find("rules", name).path for name in agent.rules],
        places=[p for p in scenario.places if agent.name in p.agents],
        facts=scenario.facts_of(agent.name),
        schema=catalog.load_schema(),
    )
    rates = Rates(scenario.rate.control_rate, scenario.rate.plan_rate)
    runtime = Runtime(stage.clock, NullSink())
    return build_agent(agent.name, stage.devices(agent.name), mind, rates, runtime, load_class=catalog.load_class)


def _doubt(stage: SimulatedWorld, built: Agent, agent: AgentSpec, goal: PlaceSpec) -> Fault | None:
    """Why an agent, alone in the world, cannot stand at a goal, or hardly; None when it can with ease."""
    world, what = stage.world, f"the goal '{goal.name}' of {agent.name} cannot be reached"
    poses = free_goal_poses(world, agent.name, goal.pose, goal.tolerance)
    if not poses:
        world.place(agent.name, goal.pose._replace(yaw=0.0))
        depth, thing = world.clearance(agent.name)
        where = f"at the goal itself its hull is {max(-depth, 0.0):.2f} m inside '{thing}'"
        message = f"{what}: within {goal.tolerance:g} m of it {agent.robot} is free at no pose; {where}."
        return Fault(message, hint="Move the goal or what stands there.")
    built.knowledge.world.pursue(goal.name)
    fires = ""
    for free in poses:
        world.place(agent.name, free.pose)
        fires = _firing(built, free.pose, goal.pose)
        if not fires:
            return None if len(poses) >= _EASY * POSES_TRIED else _tight(agent, goal, poses)
    message = f"{what}: at every free pose within {goal.tolerance:g} m of it a reflex fires; at the last, {fires}."
    return Fault(message, hint="Move the goal or what stands there, or let the rule look at goal_distance.")


def _tight(agent: AgentSpec, goal: PlaceSpec, poses: Sequence[FreePose]) -> Fault:
    things = ", ".join(sorted({f"'{pose.nearest}'" for pose in poses if pose.nearest}))
    message = (
        f"the goal '{goal.name}' of {agent.name} is tight: {agent.robot} is free at {len(poses)} of the {POSES_TRIED} "
        f"poses tried within {goal.tolerance:g} m of it; near it: {things}."
    )
    return Fault(message, hint="It can be reached, but expect contacts on the way in.")


def _firing(agent: Agent, pose: Pose2, goal: Pose2) -> str:
    """The rule that fires where the robot stands now, with its reading; empty when none does."""
    t = agent.clock.now()
    for monitor in agent.monitors:
        monitor.run(t, 0)
    if any(signal.name == "pose" for analyze in agent.analyzes for signal in analyze.signals()):
        # One that localises cannot follow from pose to pose in no time; it is taken to be right.
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
