"""Scenario files (scenario/2): world, agents, actors, places, facts, requirements and end conditions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..base.dialect import DIALECTS
from ..base.errors import Fault, did_you_mean
from ..base.geometry import Pose2, wrap_angle
from ..base.parameter import Positions
from ..base.toml_table import Table
from ..base.units import ANGLE, LENGTH, TIME
from .ground_tables import GroundSpec, PushSpec, read_grounds, read_pushes
from .inherit import Overlay, read_overlay
from .perturbation import Perturbation
from .scenario_tables import FactSpec, RateSpec, ShareSpec, read_facts, read_rate, read_share
from .values import ParameterTable, latency_of, mission_parameters_in, raw_parameters, read_name

FORMAT = "scenario/2"


@dataclass(frozen=True)
class PlaceSpec:
    """One `[[place]]` table: a node in the agents' initial Knowledge.

    Attributes:
        name: Node's name.
        kind: `goal`, `place` or `object`.
        pose: Pose, world frame; yaw is NaN if any heading is accepted.
        tolerance: Distance within which the place counts as reached [m].
        agents: Names of the agents that know the place.
        attributes: Further attributes of an object's node, unconverted; the agents' schema types them.
        line: Line of the table in the file.
        z: Height of the pose, world frame [m]; None on the floor.
        height_tolerance: Height difference within which the place counts as reached [m]; None if `tolerance` is that
            of the distance in space.
        positions: Line and column of each attribute in the file.
    """

    name: str
    kind: str
    pose: Pose2
    tolerance: float
    agents: tuple[str, ...]
    attributes: Mapping[str, Any] = field(default_factory=dict)
    line: int = 0
    z: float | None = None
    height_tolerance: float | None = None
    positions: Positions = field(default_factory=dict)


@dataclass(frozen=True)
class AgentSpec:
    """One `[[agent]]` table: a robot with its mission and rules.

    Attributes:
        name: Agent's name, and prefix of its body in the world.
        robot: Robot's name.
        mission: Mission's name.
        nodes: Dialect of a mission in XML, one of `DIALECTS`; empty to recognise it.
        rules: Names of the rule files.
        pose: Start pose, world frame.
        jitter: Half-widths of the uniform noise, sampled with the seed, on the start pose.
        success: Goal that the ground-truth pose must reach for `success`; None if the mission's result suffices.
        at_end: Whether the robot must be at the goal when the run ends, whatever the mission returns; for missions
            that never end.
        after: Goals that the robot must have reached before `success`, each with its deadline [s].
        shortest_path: Length of the shortest path to the goal [m]; None if unknown.
        latency: Planning time [s], simulated; None if it is measured, which is not reproducible.
        parameters: Mission parameters as in the file, typed by the mission's annotations.
        line: Line of the table in the file.
        parameters_at: Position of the parameters in their file; None for those made by a program.
        overlay: Tables that override those of the robot.
        privileged: Ground-truth information of an oracle planner (`Mission.privileged`), which then also knows the
            future of what moves; None for all others. Set by programs and never by a file.
        perturbations: Changes of the simulated robot of which the agent does not know, set by programs and never by a
            file.
    """

    name: str
    robot: str
    mission: str
    rules: tuple[str, ...]
    pose: Pose2
    jitter: Pose2
    success: str | None = None
    at_end: bool = False
    after: Mapping[str, float] = field(default_factory=dict)
    shortest_path: float | None = None
    latency: float | None = 0.0
    parameters: Mapping[str, Any] = field(default_factory=dict)
    line: int = 0
    parameters_at: ParameterTable | None = None
    nodes: str = ""
    overlay: Overlay | None = None
    privileged: Mapping[str, Any] | None = None
    perturbations: tuple[Perturbation, ...] = ()


@dataclass(frozen=True)
class ActorSpec:
    """One `[[actor]]` table: a robot or an object of the world that follows a script.

    Attributes:
        name: Actor's name, and prefix of a robot's body in the world; for an object, the name of its body.
        robot: Robot's name; empty for an object.
        script: Name of the script that moves the robot or object.
        pose: Start pose, world frame.
        jitter: Half-widths of the uniform noise, sampled with the seed, on the start pose.
        parameters: Script parameters, unconverted.
        line: Line of the table in the file.
        one_of: Group of objects of which the seed selects one, the only one that follows its script; empty for none.
        positions: Line and column of each script parameter in the file.
    """

    name: str
    robot: str
    script: str
    pose: Pose2
    jitter: Pose2
    parameters: Mapping[str, Any] = field(default_factory=dict)
    line: int = 0
    one_of: str = ""
    positions: Positions = field(default_factory=dict)


@dataclass(frozen=True)
class RequirementSpec:
    """One `[[requirement]]` table: a condition on the whole run, reported in the summary; it does not affect outcomes.

    Attributes:
        name: Requirement's name.
        require: Condition in the rule language, such as `always min_clearance > 0.05 m`.
        agents: Names of the agents for which the requirement is checked.
        doc: One-sentence description.
        line: Line of the table in the file.
        position: Line and column of the condition.
    """

    name: str
    require: str
    agents: tuple[str, ...]
    doc: str = ""
    line: int = 0
    position: tuple[int, int] = (0, 0)


@dataclass(frozen=True)
class ScenarioSpec:
    """Content of a scenario file.

    Attributes:
        name: File stem.
        file: Scenario file.
        doc: One-sentence description.
        world: World's name.
        duration: Time limit of the episode [s].
        end_on_collision: Whether a collision ends the episode.
        rate: Rates of physics, control, plan and sensors.
        places: Places in the agents' initial Knowledge.
        facts: Further facts, initial or received during the run.
        agents: Robots with a mission.
        actors: Scripted robots and objects.
        requirements: Conditions on the whole run.
        bases: Scenario files that this one is based on, nearest first.
        share: Sharing of knowledge between agents; None for none.
        grounds: Parts of the floor that are not level.
        pushes: Scheduled pushes of robots.
    """

    name: str
    file: Path
    doc: str
    world: str
    duration: float
    end_on_collision: bool
    rate: RateSpec
    places: tuple[PlaceSpec, ...]
    agents: tuple[AgentSpec, ...]
    actors: tuple[ActorSpec, ...]
    requirements: tuple[RequirementSpec, ...] = ()
    facts: tuple[FactSpec, ...] = ()
    bases: tuple[Path, ...] = ()
    share: ShareSpec | None = None
    grounds: tuple[GroundSpec, ...] = ()
    pushes: tuple[PushSpec, ...] = ()

    @property
    def tags(self) -> dict[str, int]:
        """Number 1, 2, ... of each robot, by name of the agent or scripted robot; sensors can detect the number."""
        names = [*(agent.name for agent in self.agents), *(actor.name for actor in self.actors if actor.robot)]
        return {name: tag for tag, name in enumerate(names, 1)}

    def facts_of(self, agent: str) -> tuple[FactSpec, ...]:
        """Facts that an agent receives, in addition to its places."""
        return tuple(fact for fact in self.facts if agent in fact.agents)

    @property
    def robots(self) -> tuple[str, ...]:
        """Names of all robots in the scenario, each once."""
        return tuple(dict.fromkeys([*(a.robot for a in self.agents), *(m.robot for m in self.actors if m.robot)]))


# Returns the fault of content that cannot be used, by kind and name; None if it can.
Missing = Callable[[str, str], Fault | None]


def read_scenario(root: Table, missing: Missing = lambda kind, name: None, *, missions: bool = True) -> ScenarioSpec:
    """Read a scenario from a TOML document.

    Args:
        root: Root table of the document.
        missing: Returns the fault of referenced content that cannot be used, by kind and name, or None; faults are
            reported at the position of the name.
        missions: Whether each agent must have a mission; else that of an agent without one is an empty text.

    Raises:
        InputError: The document has faults; contains all of them, each with its line.
    """
    root.choice("format", (FORMAT,))
    agent_tables, actor_tables, place_tables = (root.tables(key) for key in ("agent", "actor", "place"))
    _unique([*agent_tables, *actor_tables, *place_tables])
    nodes = dialect_in(root)
    agents = tuple(replace(_agent(t, missing, missions), nodes=dialect_in(t, nodes)) for t in agent_tables)
    names = tuple(a.name for a in agents)
    if not agents:
        root.fault(None, "the scenario has no agent.", "Add an [[agent]] table.")
    places = tuple(_place(t, names) for t in place_tables)
    goals = [p.name for p in places if p.kind == "goal"]
    for table, agent in zip(agent_tables, agents, strict=True):
        for name in (agent.success, *agent.after):
            if name is not None and name not in goals:
                table.fault("success", f"no goal is named '{name}'.", did_you_mean(name, goals, "The scenario"))
    actors = tuple(_actor(t, missing) for t in actor_tables)
    scenario = ScenarioSpec(
        name=root.file.stem,
        file=root.file,
        doc=root.text("doc", ""),
        world=_content(root, "world", missing),
        duration=root.quantity("duration", TIME, 60.0, low=0.0, high=86400.0),
        end_on_collision=root.flag("end_on_collision", False),
        rate=read_rate(root.table("rate")),
        places=places,
        agents=agents,
        actors=actors,
        requirements=_requirements(root, names),
        facts=read_facts(root, names),
        bases=root.bases,
        share=read_share(root, names),
        grounds=read_grounds(root),
        pushes=read_pushes(root, [*names, *(actor.name for actor in actors if actor.robot)]),
    )
    root.done()
    return scenario


def _place(table: Table, agents: Sequence[str]) -> PlaceSpec:
    known = ("name", "kind", "x", "y", "z", "yaw", "tolerance", "height_tolerance", "agents")
    kind = table.choice("kind", ("goal", "place", "object"), "goal")
    receivers = tuple(table.texts("agents", list(agents)))
    for name in receivers:
        if name not in agents:
            table.fault("agents", f"no agent is named '{name}'.", did_you_mean(name, agents, "The scenario"))
    if "height_tolerance" in table and "z" not in table:
        table.fault("height_tolerance", "a place without z has no height.", "Add z, or remove height_tolerance.")
    # Only objects have further attributes; an unknown key of a goal or a place is an error.
    attributes, positions = raw_parameters(table, known) if kind == "object" else ({}, {})
    return PlaceSpec(
        name=read_name(table),
        kind=kind,
        pose=_pose(table, yaw=math.nan),
        tolerance=table.quantity("tolerance", LENGTH, 0.1, low=1e-4),
        agents=receivers,
        attributes=attributes,
        line=table.position()[0],
        z=table.quantity("z", LENGTH, low=-1e4, high=1e4) if "z" in table else None,
        height_tolerance=table.quantity("height_tolerance", LENGTH, low=1e-4) if "height_tolerance" in table else None,
        positions=positions,
    )


def _agent(table: Table, missing: Missing, missions: bool) -> AgentSpec:
    success = table.table("success")
    goal = success.text("goal") if "success" in table else None
    parameters, parameters_at = mission_parameters_in(table)
    return AgentSpec(
        name=_name(table),
        robot=_content(table, "robot", missing),
        mission=_content(table, "mission", missing) if missions or "mission" in table else "",
        rules=_rules(table, missing),
        pose=_pose(table),
        jitter=_jitter(table),
        success=goal if "goal" in success else None,
        at_end=success.choice("at", ("once", "end"), "once") == "end",
        after=_after(success.table("after")),
        shortest_path=success.quantity("shortest_path", LENGTH, low=1e-3) if "shortest_path" in success else None,
        latency=latency_of(table),
        parameters=parameters,
        line=table.position()[0],
        parameters_at=parameters_at,
        overlay=read_overlay(table),
    )


def dialect_in(table: Table, default: str = "") -> str:
    """Dialect of XML missions: the key `nodes` of a table, or the default; empty if it is to be recognised."""
    return table.choice("nodes", DIALECTS, default)


def _after(table: Table) -> dict[str, float]:
    """Read the goals that must be reached before the success goal, each with its deadline [s]."""
    names = table.keys()
    return {name: table.quantity(name, TIME, low=0.0, high=math.inf) for name in names}


def _actor(table: Table, missing: Missing) -> ActorSpec:
    known = ("name", "robot", "script", "x", "y", "yaw", "jitter", "one_of")
    if "robot" in table and "one_of" in table:
        table.fault("one_of", "one_of is for objects of the world, and this actor is a robot.", "Remove it.")
    parameters, positions = raw_parameters(table, known)
    return ActorSpec(
        name=_name(table),
        robot=_content(table, "robot", missing) if "robot" in table else "",
        script=table.text("script"),
        pose=_pose(table),
        jitter=_jitter(table),
        parameters=parameters,
        line=table.position()[0],
        one_of=table.text("one_of", ""),
        positions=positions,
    )


def _requirements(root: Table, agents: Sequence[str]) -> tuple[RequirementSpec, ...]:
    tables = root.tables("requirement")
    _unique(tables, "Give each requirement its own.")
    return tuple(_requirement(table, agents) for table in tables)


def _requirement(table: Table, agents: Sequence[str]) -> RequirementSpec:
    agent = table.text("agent") if "agent" in table else None
    if agent is not None and agent not in agents:
        table.fault("agent", f"no agent is named '{agent}'.", did_you_mean(agent, agents, "The scenario"))
    return RequirementSpec(
        name=read_name(table),
        require=table.text("require"),
        agents=tuple(agents) if agent is None else (agent,),
        doc=table.text("doc", ""),
        line=table.position()[0],
        position=table.position("require"),
    )


def _name(table: Table) -> str:
    name = read_name(table)
    if name and not name.isidentifier():
        table.fault(
            "name", f"'{name}' is not a valid body name.", "Use letters, digits and '_', beginning with a letter."
        )
    return name


def _content(table: Table, kind: str, missing: Missing) -> str:
    name = table.text(kind)
    if name and (fault := missing(kind, name)):
        table.fault(kind, fault.message, fault.hint)
    return name


def _rules(table: Table, missing: Missing) -> tuple[str, ...]:
    names = tuple(table.texts("rules", []))
    for name in names:
        if fault := missing("rules", name):
            table.fault("rules", fault.message, fault.hint)
    return names


def _pose(table: Table, yaw: float = 0.0) -> Pose2:
    x, y = (table.quantity(key, LENGTH, low=-1e4, high=1e4) for key in ("x", "y"))
    yaw = table.quantity("yaw", ANGLE, yaw, low=-1e4, high=1e4)
    return Pose2(x, y, yaw if math.isinf(yaw) else wrap_angle(yaw))


def _jitter(table: Table) -> Pose2:
    inner = table.table("jitter")
    x, y = (inner.quantity(key, LENGTH, 0.0, low=0.0, high=1e4) for key in ("x", "y"))
    return Pose2(x, y, inner.quantity("yaw", ANGLE, 0.0, low=0.0, high=math.pi))


def _unique(
    tables: Sequence[Table], hint: str = "Agents, actors and places share their names: give each its own."
) -> None:
    """Note a fault at each table with the name of an earlier one."""
    seen: set[str] = set()
    for table in tables:
        name = table.raw("name", "")
        if name and str(name) in seen:
            table.fault("name", f"another table has the name '{name}'.", hint)
        seen.add(str(name))
