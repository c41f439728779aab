"""Header of a recording: description of a run before it starts."""

from __future__ import annotations

import importlib.metadata
import math
import platform
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache

import msgspec

from ..agent import Agent
from ..base.version import __version__
from ..catalog import RobotSpec, ScenarioSpec
from ..devices.mujoco import MujocoWorld
from ..devices.mujoco.body import hull_outline, outlines
from ..event import GuardInfo
from ..expression import Environment
from ..expression.source import source
from ..plan import TreePlan
from ..reactive import OnInvalid, Rule, RuleSet
from ..reactive.analysis.prover import Prover
from ..record import AgentInfo, BodyInfo, Place, RunHeader, SensorInfo, SignalInfo, SubtreeSwap
from ..record.explanation.condition import parts_of, unit_of
from ..simulation.body_shapes import RobotShapes, object_shapes
from ..simulation.ground import ground_outlines
from ..simulation.scripts import FREE
from ..simulation.simulated_world import SimulatedWorld
from .requirements import requirements_of

_PACKAGES = ("mujoco", "casadi", "py-trees", "networkx", "numpy")


@cache
def versions() -> Mapping[str, str]:
    """Versions of the packages that affect the results of a run, by package."""
    # A checkout that is not installed has no metadata, so the own version comes from the package.
    others = {name: importlib.metadata.version(name) for name in _PACKAGES}
    return {"python": platform.python_version(), "rocs_bt": __version__, **others}


def make_scenery(scenario: ScenarioSpec, world: MujocoWorld) -> RunHeader:
    """Header with only the static obstacles and places of a scenario, for figures."""
    return RunHeader(
        scenario=scenario.name,
        seed=0,
        outlines=outlines(world.model, world.robots),
        grounds=ground_outlines(scenario),
        places=_places(scenario),
    )


def plain_header(
    scenario: ScenarioSpec,
    agents: Sequence[Agent],
    *,
    seed: int,
    mode: str,
    digest: str,
    swaps: tuple[SubtreeSwap, ...] = (),
    simulated: bool = True,
) -> RunHeader:
    """Header of a run without bodies, obstacles and places; sufficient for a summary."""
    rate = scenario.rate
    return RunHeader(
        scenario=scenario.name,
        seed=seed,
        mode=mode,
        versions=versions(),
        content_hash=digest,
        rates={"physics": 1.0 / rate.physics, "control": rate.control, "plan": rate.plan},
        agents=tuple(agent_info(scenario, agent) for agent in agents),
        requirements=requirements_of(scenario),
        swaps=swaps,
        simulated=simulated,
    )


def with_scenery(header: RunHeader, scenario: ScenarioSpec, simulated: SimulatedWorld) -> RunHeader:
    """Header of a run with the bodies, obstacles and places that figures show."""
    model, scripts = simulated.world.model, {actor.name: actor.script for actor in scenario.actors}
    return msgspec.structs.replace(
        header,
        agents=tuple(msgspec.structs.replace(a, faults=simulated.robots[a.name].faults) for a in header.agents),
        bodies=(
            *(_body(model, simulated, name, scripts) for name in simulated.world.robots),
            *(_object(model, simulated, name, scripts) for name in simulated.world.objects),
        ),
        outlines=outlines(model, simulated.world.robots),
        grounds=ground_outlines(scenario),
        places=_places(scenario),
    )


def without_world(header: RunHeader, scenario: ScenarioSpec, robots: Mapping[str, RobotSpec]) -> RunHeader:
    """Header of a run on hardware: robots as boxes and the scenario's places; the world is unknown."""
    bodies = tuple(box_body(name, robot) for name, robot in robots.items())
    return msgspec.structs.replace(header, bodies=bodies, places=_places(scenario))


def box_body(name: str, robot: RobotSpec) -> BodyInfo:
    """Body of a robot as a box of its length and width; without outline if these are unknown."""
    x, y = robot.body.length / 2.0, robot.body.width / 2.0
    return BodyInfo(name=name, hull=((x, y), (-x, y), (-x, -y), (x, -y)) if math.isfinite(x + y) else ())


def agent_info(scenario: ScenarioSpec, agent: Agent) -> AgentInfo:
    """Description of one agent in a recording."""
    spec = next(a for a in scenario.agents if a.name == agent.name)
    locomotion = agent.knowledge.robot.locomotion
    return AgentInfo(
        name=spec.name,
        robot=spec.robot,
        mission=spec.mission,
        rules=spec.rules,
        inactive={rule.name: rule.missing for file in agent.reloadable_rules for rule in file.model.rules.inactive},
        nodes=agent.plan.tree_nodes() if isinstance(agent.plan, TreePlan) else (),
        signals=signals_of(agent),
        axes=() if locomotion.wheels else locomotion.values,
        guards=tuple(guard for file in agent.reloadable_rules for guard in guards_of(agent, file.model.rules)),
        sensors=tuple(_sensors(agent)),
    )


def _sensors(agent: Agent) -> Iterator[SensorInfo]:
    for monitor in agent.monitors:
        written = [signal.name for signal in monitor.signals()]
        derived = dict.fromkeys(written)
        for analyze in agent.analyzes:  # one reads what others write, in this order
            if not derived.keys().isdisjoint(analyze.expects()):
                derived.update(dict.fromkeys(signal.name for signal in analyze.signals()))
        for each in monitor.monitored:
            others = tuple(name for name in derived if name not in written)
            yield SensorInfo(name=each.sensor.name, signals=tuple(written), derived=others)


def guards_of(agent: Agent, rules: RuleSet) -> tuple[GuardInfo, ...]:
    """Descriptions of the guards of an agent's rules."""
    environment = Environment.of(agent.knowledge.signals)
    return tuple(_limited(agent, guard_info(rules, rule, environment)) for rule in rules.rules)


def _limited(agent: Agent, guard: GuardInfo) -> GuardInfo:
    """The description of a guard with the limits of the range sensors that it reads."""
    read, limits = set(re.findall(r"\w+", " ".join(guard.sources))), list[tuple[float, str]]()
    for monitor in agent.monitors:
        if read.isdisjoint(signal.name for signal in monitor.signals()):
            continue
        for sensor in (each.sensor for each in monitor.monitored):
            found = getattr(sensor, "range", None)
            for value, word in zip(found, ("minimum", "maximum"), strict=False) if isinstance(found, tuple) else ():
                if isinstance(value, float) and math.isfinite(value):
                    limits.append((value, f"{value:.3g} m is the {word} of the sensor '{sensor.name}'"))
    return msgspec.structs.replace(guard, limits=tuple(limits))


def guard_info(rules: RuleSet, rule: Rule, environment: Environment) -> GuardInfo:
    """Description of the guard of a rule in a recording."""
    guards = [rule.when, *([] if rule.until is None else [rule.until])]
    parts = [part for guard in guards for part in parts_of(guard.node)]
    return GuardInfo(
        rule=rule.name,
        when=rule.when.text,
        until="" if rule.until is None else rule.until.text,
        sources=tuple(source(guard.node, environment) for guard in guards),
        comparisons=tuple(part.text for part in parts),
        units=tuple(map(unit_of, parts)),
        doc=rule.doc,
        action=rule.action,
        priority=rule.priority,
        place=f"{at.file.name}:{at.line}" if (at := rule.positions.get("")) and at.file else "",
        thresholds=_thresholds(rules, " ".join(guard.text for guard in guards)),
        hold=rule.hold,
        cooldown=rule.cooldown,
        level=rule.level,
        modes=rule.modes,
        on_invalid=rule.on_invalid.value,
        max_hold=rule.max_hold,
        only_invalid=rule.on_invalid is not OnInvalid.CLEAR
        and Prover(environment, [rule.when.node]).decide(rule.when.node).never,
    )


def _thresholds(rules: RuleSet, text: str) -> dict[str, str]:
    """Values of the thresholds that a text names, with units."""
    named = [name for name in rules.thresholds if re.search(rf"\b{name}\b", text)]
    units = {name: str(rules.dimensions.get(name, "")).removeprefix("1") for name in named}
    return {name: f"{rules.thresholds[name]:.4g} {units[name]}".strip() for name in named}


def signals_of(agent: Agent) -> tuple[SignalInfo, ...]:
    """Signals of an agent, in the order of its snapshots."""
    late = {signal.name for analyze in agent.analyzes if analyze not in agent.prompt for signal in analyze.signals()}
    table = agent.knowledge.signals
    return tuple(SignalInfo.of(table.spec(name), name in late) for name in table.names)


def _body(model: object, simulated: SimulatedWorld, name: str, scripts: Mapping[str, str]) -> BodyInfo:
    sensors = simulated.sensors.get(name, {})
    beams = {s.name: drawn() for s in sensors.values() if (drawn := getattr(s, "beams", None))}
    fans = {s.name: drawn() for s in sensors.values() if (drawn := getattr(s, "fan", None))}
    hull, geometry = hull_outline(model, simulated.world.robots[name].hull), RobotShapes(simulated.world, name)
    return BodyInfo(
        name=name,
        hull=hull,
        beams=beams,
        fans=fans,
        shapes=geometry.shapes,
        links=geometry.links,
        base=geometry.height,
        script=scripts.get(name, ""),
    )


def _object(model: object, simulated: SimulatedWorld, name: str, scripts: Mapping[str, str]) -> BodyInfo:
    shapes, base = object_shapes(simulated.world, name)
    return BodyInfo(
        name=name,
        hull=hull_outline(model, simulated.world.objects[name].geoms),
        shapes=shapes,
        base=base,
        script=script if (script := scripts.get(name, "")) != FREE else "",
        states={state: (pose.x, pose.y, pose.yaw) for state, pose in simulated.states.get(name, {}).items()},
    )


def _places(scenario: ScenarioSpec) -> tuple[Place, ...]:
    return tuple(
        Place(
            name=place.name,
            x=place.pose.x,
            y=place.pose.y,
            yaw=place.pose.yaw if math.isfinite(place.pose.yaw) else 0.0,
            kind=place.kind,
            radius=place.tolerance,
            known=bool(place.agents),
        )
        for place in scenario.places
    )
