"""Whether a scenario can be played: everybody can stand at the start, and every goal can be reached."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from ..agent import Agent, Mind, Rates, build_agent
from ..catalog import AgentSpec, Catalog, PlaceSpec, ScenarioSpec
from ..errors import Fault
from ..event import NullSink
from ..reactive import RuleModel
from .paper import idle

_LATER = 1e6  # [s]; by then a guard that holds has held for any rule's `for`


def check_feasible(scenario: ScenarioSpec, catalog: Catalog) -> Iterable[Fault]:
    """What keeps a scenario from being played; a goal that cannot be reached is a warning, as the run still runs.

    A goal needs a pose within its tolerance at which the robot touches nothing and no reflex fires.

    Raises:
        InputError: The world does not compile, or somebody cannot stand at the start.
    """
    from ..simulation import set_stage

    set_stage(scenario, catalog, 1, NullSink())
    goals = {p.name: p for p in scenario.places}
    for agent in scenario.agents:
        if agent.success is not None:
            fault = _unreachable(scenario, catalog, agent, goals[agent.success])
            if fault is not None:
                yield replace(fault, file=scenario.file, line=agent.line, warning=True)


def _unreachable(scenario: ScenarioSpec, catalog: Catalog, agent: AgentSpec, goal: PlaceSpec) -> Fault | None:
    """Why an agent, alone in the world, cannot stand at a goal; None when it can."""
    from ..simulation import free_goal_poses, set_stage

    stage = set_stage(replace(scenario, agents=(agent,), movers=()), catalog, 1, NullSink())
    world, what = stage.world, f"the goal '{goal.name}' of {agent.name} cannot be reached"
    poses = free_goal_poses(world, agent.name, goal.pose, goal.tolerance)
    if not poses:
        world.place(agent.name, goal.pose._replace(yaw=0.0))
        depth, thing = world.clearance(agent.name)
        where = f"at the goal itself its hull is {max(-depth, 0.0):.2f} m inside '{thing}'"
        message = f"{what}: within {goal.tolerance:g} m of it {agent.robot} is free at no pose; {where}."
        return Fault(message, hint="Move the goal or what stands there.")
    rates = Rates(scenario.rate.control_rate, scenario.rate.plan_rate)
    built = build_agent(
        agent.name,
        stage.robots[agent.name],
        Mind(
            build=idle,
            rules=[catalog.find("rules", name).path for name in agent.rules],
            places=[p for p in scenario.places if agent.name in p.agents],
        ),
        sensors=stage.sensors[agent.name],
        actuators=stage.actuators[agent.name],
        sensor_rates=stage.sensor_rates[agent.name],
        rates=rates,
        clock=stage.clock,
        sink=NullSink(),
        load_class=catalog.load_class,
    )
    built.knowledge.world.pursue(goal.name)
    fires = ""
    for free in poses:
        world.place(agent.name, free.pose)
        fires = _firing(built)
        if not fires:
            return None
    message = f"{what}: at every free pose within {goal.tolerance:g} m of it a reflex fires; at the last, {fires}."
    return Fault(message, hint="Move the goal or what stands there, or let the rule look at goal_distance.")


def _firing(agent: Agent) -> str:
    """The rule that fires where the robot stands now, with its reading; empty when none does."""
    t = agent.clock.now()
    for monitor in agent.monitors:
        monitor.run(t, 0)
    snapshot = agent.knowledge.signals.snapshot(t)
    for model in agent.knowledge.reactive_models:
        if isinstance(model, RuleModel):
            model.reset()
            for moment in (t, t + _LATER):
                for reflex in model.react(snapshot, moment):
                    if reflex.latched:
                        return f"{reflex.rule} with {reflex.describe()}"
    return ""
