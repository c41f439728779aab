"""scenario.toml: where, who, and how it ends."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..document import Table
from ..errors import Fault, did_you_mean
from ..geometry import Pose2, wrap_angle
from ..units import ANGLE, LENGTH, TIME
from .scenario_tables import FactSpec, RateSpec, ShareSpec, read_facts, read_rate, read_share
from .values import free_parameters, latency_of, read_name

FORMAT = "scenario/1"


@dataclass(frozen=True)
class PlaceSpec:
    """One `[[place]]`: a node that the scenario puts into the agents' Knowledge.

    Attributes:
        name: The node's name.
        kind: `goal`, `place` or `object`.
        pose: Where it is, world frame; yaw is NaN where it does not matter.
        tolerance: How near counts as there [m].
        agents: Whose Knowledge it goes into.
        attributes: More attributes of the node, in SI units.
        line: Where its table stands in the file.
    """

    name: str
    kind: str
    pose: Pose2
    tolerance: float
    agents: tuple[str, ...]
    attributes: Mapping[str, Any] = field(default_factory=dict)
    line: int = 0


@dataclass(frozen=True)
class AgentSpec:
    """One `[[agent]]`: a robot with a mind.

    Attributes:
        name: The agent's name, and the prefix of its body in the world.
        robot: The robot's name.
        mission: The mission's name.
        nodes: Whose meaning the nodes of a mission in XML have: empty for ours, `nav2` for Nav2's.
        rules: The names of its rule files.
        pose: Where it starts, world frame.
        jitter: Half-widths of the uniform draw that the seed adds to the pose.
        success: The goal at which it must truly be for `success`; None where the mission's word is enough.
        at_end: Whether it must be there when the run ends, whatever its mission says, as for one that never ends.
        after: The goals at which it must truly have been before, each by its time [s].
        shortest: How long the shortest way to the goal is [m]; None where that is unknown.
        latency: How long its planner thinks [s]; None where that is measured, which does not repeat.
        parameters: The mission's parameters as the file has them; the mission's annotations type them.
        line: Where its table stands in the file.
        parameters_line: Where its parameters stand in the file.
        privileged: Information for oracle planners only, set by programs, never by a file (`Mission.privileged`).
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
    shortest: float | None = None
    latency: float | None = 0.0
    parameters: Mapping[str, Any] = field(default_factory=dict)
    line: int = 0
    parameters_line: int = 0
    nodes: str = ""
    privileged: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class MoverSpec:
    """One `[[mover]]`: a robot, or a thing of the world, that follows a script and has no mind.

    Attributes:
        name: Its name, and the prefix of its body in the world; a thing's is its body's.
        robot: The robot's name; empty for a thing.
        script: The script that moves it.
        pose: Where it starts, world frame.
        jitter: Half-widths of the uniform draw that the seed adds to the pose.
        parameters: The script's parameters, in SI units.
        line: Where its table stands in the file.
    """

    name: str
    robot: str
    script: str
    pose: Pose2
    jitter: Pose2
    parameters: Mapping[str, Any] = field(default_factory=dict)
    line: int = 0


@dataclass(frozen=True)
class RequirementSpec:
    """One `[[requirement]]`: what must hold over the run; told in the summary, and without a part in the outcome.

    Attributes:
        name: What it is called.
        require: Its text in the rules' language, such as `always min_clearance > 0.05 m`.
        agents: Whom it is about.
        doc: One sentence for people.
        line: Where its table stands in the file.
        position: Line and column of its text.
    """

    name: str
    require: str
    agents: tuple[str, ...]
    doc: str = ""
    line: int = 0
    position: tuple[int, int] = (0, 0)


@dataclass(frozen=True)
class ScenarioSpec:
    """A scenario, as its file describes it.

    Attributes:
        name: The file's stem.
        file: The file.
        doc: One sentence for people.
        world: The world's name.
        duration: The longest it may take [s].
        end_on_collision: Whether a collision ends the episode.
        rate: How often things happen.
        places: What the agents are told of the world.
        facts: What else they know at the start.
        agents: Who thinks.
        movers: Who else moves.
        requirements: What must hold over the run.
        bases: The scenario files that its own is based on, the nearest first.
        share: What the agents share of their knowledge; None for nothing.
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
    movers: tuple[MoverSpec, ...]
    requirements: tuple[RequirementSpec, ...] = ()
    facts: tuple[FactSpec, ...] = ()
    bases: tuple[Path, ...] = ()
    share: ShareSpec | None = None

    @property
    def tags(self) -> dict[str, int]:
        """The tags that robots wear, for robot sensors, by the names of the agents and movers: 1, 2, ..."""
        names = [*(agent.name for agent in self.agents), *(mover.name for mover in self.movers if mover.robot)]
        return {name: tag for tag, name in enumerate(names, 1)}

    def facts_of(self, agent: str) -> tuple[FactSpec, ...]:
        """What an agent knows at the start, beside its places."""
        return tuple(fact for fact in self.facts if agent in fact.agents)

    @property
    def robots(self) -> tuple[str, ...]:
        """The names of all robots that take part, each once."""
        return tuple(dict.fromkeys([*(a.robot for a in self.agents), *(m.robot for m in self.movers if m.robot)]))


# Tells why the content of a kind and a name cannot be used; None when it can.
Missing = Callable[[str, str], Fault | None]


def read_scenario(root: Table, missing: Missing = lambda kind, name: None) -> ScenarioSpec:
    """The scenario that a document holds.

    Args:
        root: The document.
        missing: Told of each name of other content; its fault is noted at that name.

    Raises:
        InputError: With every fault, each at its line.
    """
    root.choice("format", (FORMAT,))
    agent_tables, mover_tables, place_tables = (root.tables(key) for key in ("agent", "mover", "place"))
    _unique([*agent_tables, *mover_tables, *place_tables])
    nodes = dialect_in(root, "rocs")
    agents = tuple(replace(_agent(t, missing), nodes=dialect_in(t, nodes).removeprefix("rocs")) for t in agent_tables)
    names = tuple(a.name for a in agents)
    if not agents:
        root.fault(None, "the scenario has no agent.", "Add an [[agent]] table.")
    places = tuple(_place(t, names) for t in place_tables)
    goals = [p.name for p in places if p.kind == "goal"]
    for table, agent in zip(agent_tables, agents, strict=True):
        for name in (agent.success, *agent.after):
            if name is not None and name not in goals:
                table.fault("success", f"no goal is named '{name}'.", did_you_mean(name, goals, "The scenario"))
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
        movers=tuple(_mover(t, missing) for t in mover_tables),
        requirements=_requirements(root, names),
        facts=read_facts(root, names),
        bases=root.bases,
        share=read_share(root, names),
    )
    root.done()
    return scenario


def _place(table: Table, agents: Sequence[str]) -> PlaceSpec:
    known = ("name", "kind", "x", "y", "yaw", "tolerance", "agents")
    kind = table.choice("kind", ("goal", "place", "object"), "goal")
    told = tuple(table.texts("agents", list(agents)))
    for name in told:
        if name not in agents:
            table.fault("agents", f"no agent is named '{name}'.", did_you_mean(name, agents, "The scenario"))
    return PlaceSpec(
        name=read_name(table),
        kind=kind,
        pose=_pose(table, yaw=math.nan),
        tolerance=table.quantity("tolerance", LENGTH, 0.1, low=1e-4),
        agents=told,
        # Of these only objects have attributes of their own; on others another key is a slip of the pen.
        attributes=free_parameters(table, known) if kind == "object" else {},
        line=table.position()[0],
    )


def _agent(table: Table, missing: Missing) -> AgentSpec:
    success = table.table("success")
    goal = success.text("goal") if "success" in table else None
    parameters = table.table("parameters")
    return AgentSpec(
        name=_name(table),
        robot=_content(table, "robot", missing),
        mission=_content(table, "mission", missing),
        rules=_rules(table, missing),
        pose=_pose(table),
        jitter=_jitter(table),
        success=goal if "goal" in success else None,
        at_end=success.choice("at", ("once", "end"), "once") == "end",
        after=_after(success.table("after")),
        shortest=success.quantity("shortest", LENGTH, low=1e-3) if "shortest" in success else None,
        latency=latency_of(table),
        parameters={key: parameters.raw(key) for key in parameters.keys()},  # noqa: SIM118 - a Table is no mapping
        line=table.position()[0],
        parameters_line=parameters.position()[0],
    )


def dialect_in(table: Table, default: str) -> str:
    """Whose meaning nodes have in XML missions: an agent's, else the scenario's, else ours."""
    return table.choice("nodes", ("rocs", "nav2"), default)


def _after(table: Table) -> dict[str, float]:
    """The goals to be visited before, each by when [s]."""
    names = table.keys()  # a Table is no mapping: its keys count as asked for once they are read
    return {name: table.quantity(name, TIME, low=0.0, high=math.inf) for name in names}


def _mover(table: Table, missing: Missing) -> MoverSpec:
    known = ("name", "robot", "script", "x", "y", "yaw", "jitter")
    return MoverSpec(
        name=_name(table),
        robot=_content(table, "robot", missing) if "robot" in table else "",
        script=table.text("script"),
        pose=_pose(table),
        jitter=_jitter(table),
        parameters=free_parameters(table, known),
        line=table.position()[0],
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
        table.fault("name", f"'{name}' cannot name a body.", "Use letters, digits and '_', beginning with a letter.")
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
    tables: Sequence[Table], hint: str = "Agents, movers and places share their names: give each its own."
) -> None:
    """Note a fault at each table whose name an earlier one has."""
    seen: set[str] = set()
    for table in tables:
        name = table.raw("name", "")
        if name and str(name) in seen:
            table.fault("name", f"the name '{name}' is taken by another table.", hint)
        seen.add(str(name))
