"""scenario.toml: where, who, and how it ends."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..clock import Rate
from ..document import Table
from ..errors import Fault, InputError, RateError, did_you_mean
from ..geometry import Pose2, wrap_angle
from ..units import ANGLE, FREQUENCY, LENGTH, TIME
from .values import free_parameters, given_name

FORMAT = "scenario/1"


@dataclass(frozen=True)
class RateSpec:
    """The `[rate]` table: how often things happen (docs/architecture.md).

    Attributes:
        physics: Length of a physics step [s].
        control: Control periods per second [1/s].
        plan: Ticks of the tree per second [1/s].
        sensors: Readings per second of every sensor [1/s]; None for what each robot.toml says.
        line: Where the table stands in the file.
    """

    physics: float = 0.005
    control: float = 20.0
    plan: float = 10.0
    sensors: float | None = None
    line: int = 0

    @property
    def control_rate(self) -> Rate:
        """The control rate, over physics steps.

        Raises:
            RateError: It does not divide.
        """
        return Rate.dividing(self.control, self.physics, "the control rate")

    @property
    def plan_rate(self) -> Rate:
        """The plan rate, over control periods.

        Raises:
            RateError: It does not divide.
        """
        return Rate.dividing(self.plan, 1.0 / self.control, "the plan rate")

    def sensor_rate(self, hz: float | None, name: str = "") -> Rate:
        """A sensor's rate, over control periods.

        Args:
            hz: What robot.toml says [1/s]; None for one reading in each control period.
            name: The sensor, for the message.

        Raises:
            RateError: It does not divide.
        """
        wanted = self.sensors or hz or self.control
        try:
            return Rate.dividing(wanted, 1.0 / self.control, f"the rate of sensor '{name}'")
        except RateError as error:
            all_alike = f'Or have all sensors keep step: sensors = "{self.control:g} Hz" under [rate].'
            raise RateError(*(replace(f, hint=f"{f.hint} {all_alike}".strip()) for f in error.faults)) from error


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
        rules: The names of its rule files.
        pose: Where it starts, world frame.
        jitter: Half-widths of the uniform draw that the seed adds to the pose.
        success: The goal at which it must truly be for `success`; None where the mission's word is enough.
        at_end: Whether it must be there when the run ends, whatever its mission says, as for one that never ends.
        parameters: The mission's parameters as the file has them; the mission's annotations type them.
        line: Where its table stands in the file.
        parameters_line: Where its parameters stand in the file.
    """

    name: str
    robot: str
    mission: str
    rules: tuple[str, ...]
    pose: Pose2
    jitter: Pose2
    success: str | None = None
    at_end: bool = False
    parameters: Mapping[str, Any] = field(default_factory=dict)
    line: int = 0
    parameters_line: int = 0


@dataclass(frozen=True)
class MoverSpec:
    """One `[[mover]]`: a robot that follows a script and has no mind.

    Attributes:
        name: Its name, and the prefix of its body in the world.
        robot: The robot's name.
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
        place: Line and column of its text.
    """

    name: str
    require: str
    agents: tuple[str, ...]
    doc: str = ""
    line: int = 0
    place: tuple[int, int] = (0, 0)


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
        agents: Who thinks.
        movers: Who else moves.
        requirements: What must hold over the run.
        bases: The scenario files that its own is based on, the nearest first.
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
    bases: tuple[Path, ...] = ()

    @property
    def tags(self) -> dict[str, int]:
        """The tags that robots wear, for robot sensors, by the names of the agents and movers: 1, 2, ..."""
        names = [*(agent.name for agent in self.agents), *(mover.name for mover in self.movers)]
        return {name: tag for tag, name in enumerate(names, 1)}

    @property
    def robots(self) -> tuple[str, ...]:
        """The names of all robots that take part, each once."""
        return tuple(dict.fromkeys([*(a.robot for a in self.agents), *(m.robot for m in self.movers)]))


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
    agents = tuple(_agent(t, missing) for t in agent_tables)
    names = tuple(a.name for a in agents)
    if not agents:
        root.fault(None, "the scenario has no agent.", "Add an [[agent]] table.")
    places = tuple(_place(t, names) for t in place_tables)
    goals = [p.name for p in places if p.kind == "goal"]
    for table, agent in zip(agent_tables, agents, strict=True):
        if agent.success is not None and agent.success not in goals:
            table.fault(
                "success", f"no goal is named '{agent.success}'.", did_you_mean(agent.success, goals, "The scenario")
            )
    scenario = ScenarioSpec(
        name=root.file.stem,
        file=root.file,
        doc=root.text("doc", ""),
        world=_content(root, "world", missing),
        duration=root.quantity("duration", TIME, 60.0, low=0.0, high=86400.0),
        end_on_collision=root.flag("end_on_collision", False),
        rate=_rate(root.table("rate")),
        places=places,
        agents=agents,
        movers=tuple(_mover(t, missing) for t in mover_tables),
        requirements=_requirements(root, names),
        bases=root.bases,
    )
    root.done()
    return scenario


def _rate(table: Table) -> RateSpec:
    default, before = RateSpec(), len(table.faults)
    rate = RateSpec(
        physics=table.quantity("physics", TIME, default.physics, low=1e-5, high=0.1),
        control=table.quantity("control", FREQUENCY, default.control, low=0.1, high=1e4),
        plan=table.quantity("plan", FREQUENCY, default.plan, low=0.01, high=1e4),
        sensors=table.quantity("sensors", FREQUENCY, low=0.01, high=1e4) if "sensors" in table else None,
        line=table.place()[0],
    )
    if len(table.faults) > before:
        return default  # numbers that are out of bounds divide nothing
    for key in ("control", "plan"):
        try:
            getattr(rate, f"{key}_rate")
        except InputError as error:
            table.adopt(key, error)
    return rate


def _place(table: Table, agents: Sequence[str]) -> PlaceSpec:
    known = ("name", "kind", "x", "y", "yaw", "tolerance", "agents")
    kind = table.choice("kind", ("goal", "place", "object"), "goal")
    told = tuple(table.texts("agents", list(agents)))
    for name in told:
        if name not in agents:
            table.fault("agents", f"no agent is named '{name}'.", did_you_mean(name, agents, "The scenario"))
    return PlaceSpec(
        name=given_name(table),
        kind=kind,
        pose=_pose(table, yaw=math.nan),
        tolerance=table.quantity("tolerance", LENGTH, 0.1, low=1e-4),
        agents=told,
        # Of these only objects have attributes of their own; on others another key is a slip of the pen.
        attributes=free_parameters(table, known) if kind == "object" else {},
        line=table.place()[0],
    )


def _agent(table: Table, missing: Missing) -> AgentSpec:
    success = table.table("success")
    parameters = table.table("parameters")
    return AgentSpec(
        name=_name(table),
        robot=_content(table, "robot", missing),
        mission=_content(table, "mission", missing),
        rules=_rules(table, missing),
        pose=_pose(table),
        jitter=_jitter(table),
        success=success.text("goal") if "success" in table else None,
        at_end=success.choice("at", ("once", "end"), "once") == "end",
        parameters={key: parameters.raw(key) for key in parameters.keys()},  # noqa: SIM118 - a Table is no mapping
        line=table.place()[0],
        parameters_line=parameters.place()[0],
    )


def _mover(table: Table, missing: Missing) -> MoverSpec:
    known = ("name", "robot", "script", "x", "y", "yaw", "jitter")
    return MoverSpec(
        name=_name(table),
        robot=_content(table, "robot", missing),
        script=table.text("script"),
        pose=_pose(table),
        jitter=_jitter(table),
        parameters=free_parameters(table, known),
        line=table.place()[0],
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
        name=given_name(table),
        require=table.text("require"),
        agents=tuple(agents) if agent is None else (agent,),
        doc=table.text("doc", ""),
        line=table.place()[0],
        place=table.place("require"),
    )


def _name(table: Table) -> str:
    name = given_name(table)
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
