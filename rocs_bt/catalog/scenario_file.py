"""Scenario files (scenario/2): world, agents, actors, places, facts, requirements and end conditions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from ..base.errors import Fault
from ..base.geometry import Pose2
from ..base.toml_table import Table
from ..base.units import LENGTH, TIME, Bounds
from ..declare import (
    Content,
    Declared,
    InFile,
    Key,
    Keys,
    Names,
    Open,
    Registered,
    Rest,
    Scope,
    SetByPrograms,
    Value,
    names_of,
    note_twice,
    read_root,
    read_values,
    replaced,
    rows_in,
)
from .device_spec import OVERLAID
from .marks import At, Coordinate, Dialect, Identifier, Jitter, Latency, Name, PlaceKeys, Pose
from .perturbation import Perturbation
from .scenario_tables import AGENTS, FactSpec, GroundSpec, PushSpec, RateSpec

D = TypeVar("D", bound=Declared)

_TOLERANCE = Annotated[float, LENGTH, Bounds(1e-4)]
_GOAL = Names("goal", "no goal")
_DEADLINE = Annotated[float, TIME, Bounds(0.0, infinite=True)]


class PlaceSpec(Value):
    """One `[[place]]` table: a node in the agents' initial Knowledge.

    Attributes:
        name: Node's name.
        kind: `goal`, `place` or `object`.
        pose: Pose, world frame; yaw is NaN if any heading is accepted.
        tolerance: Distance within which the place counts as reached [m].
        agents: Names of the agents that know the place.
        z: Height of the pose, world frame [m]; None on the floor.
        height_tolerance: Height difference within which the place counts as reached [m]; None if `tolerance` is that
            of the distance in space.
        attributes: Further attributes of an object's node, unconverted; the agents' schema types them.
    """

    name: Name
    kind: Literal["goal", "place", "object"] = "goal"
    pose: Annotated[Pose2, Keys(PlaceKeys, here=True)]
    tolerance: _TOLERANCE = 0.1
    agents: Annotated[tuple[str, ...], AGENTS] = ()
    z: Coordinate | None = None
    height_tolerance: _TOLERANCE | None = None
    attributes: Annotated[Mapping[str, Any], Rest(field="kind", value="object")] = Open()

    @classmethod
    def _prepare(cls, table: Table, scope: Scope) -> None:
        """Note the fault of a tolerance without a height."""
        if "height_tolerance" in table and "z" not in table:
            table.fault("height_tolerance", "a place without z has no height.", "Add z, or remove height_tolerance.")


class SuccessSpec(Value):
    """Table `success` of an agent: what the ground truth must show besides the mission's result.

    Attributes:
        goal: Goal that the ground-truth pose must reach; None if the mission's result suffices.
        at: `end` if the robot must be at the goal when the run ends, whatever the mission returns, for missions that
            never end; else `once`.
        after: Goals that the robot must have reached before, each with its deadline [s].
        shortest_path: Length of the shortest path to the goal [m]; None if unknown.
    """

    goal: Annotated[str, _GOAL, InFile()] | None = None
    at: Literal["once", "end"] = "once"
    after: Annotated[Mapping[str, _DEADLINE], _GOAL] = Open()
    shortest_path: Annotated[float, LENGTH, Bounds(1e-3)] | None = None


class AgentSpec(Value):
    """One `[[agent]]` table: a robot with its mission and rules.

    Attributes:
        name: Agent's name, and prefix of its body in the world.
        robot: Robot's name.
        mission: Mission's name.
        rules: Names of the rule files.
        pose: Start pose, world frame.
        jitter: Half-widths of the uniform noise, sampled with the seed, on the start pose.
        success: Conditions on the ground truth for `success`.
        latency: Planning time [s], simulated; None if it is measured, which is not reproducible.
        parameters: Mission parameters as in the file, typed by the mission's annotations.
        nodes: Dialect of a mission in XML, one of `dialects`; empty to recognise it.
        overlay: Tables that override those of the robot, as a robot's file does with those of its `base`.
        privileged: Ground-truth information of an oracle planner (`Mission.privileged`), which then also knows the
            future of what moves; None for all others. Set by programs and never by a file.
        perturbations: Changes of the simulated robot of which the agent does not know, set by programs and never by a
            file.
    """

    name: Annotated[Name, Identifier]
    robot: Annotated[str, Content("robot")]
    mission: Annotated[str, Content("mission")]
    rules: Annotated[tuple[str, ...], Content("rules")] = ()
    pose: Pose
    jitter: Jitter = Pose2(0.0, 0.0)
    success: SuccessSpec = SuccessSpec()
    latency: Latency = 0.0
    parameters: Mapping[str, Any] = Open()
    nodes: Dialect = ""
    overlay: Annotated[Open, Rest(OVERLAID)] = Open()
    privileged: Annotated[Mapping[str, Any] | None, SetByPrograms()] = None
    perturbations: Annotated[tuple[Perturbation, ...], SetByPrograms()] = ()


class ActorSpec(Value):
    """One `[[actor]]` table: a robot or an object of the world that follows a script.

    Attributes:
        name: Actor's name, and prefix of a robot's body in the world; for an object, the name of its body.
        robot: Robot's name; empty for an object.
        script: Name of the script that moves the robot or object, or `file.py:Class` beside the scenario.
        pose: Start pose, world frame.
        jitter: Half-widths of the uniform noise, sampled with the seed, on the start pose.
        one_of: Group of objects of which the seed selects one, the only one that follows its script; empty for none.
        parameters: Script parameters, unconverted.
    """

    name: Annotated[Name, Identifier]
    robot: Annotated[str, Content("robot")] = ""
    script: Annotated[str, Content("script")]
    pose: Pose
    jitter: Jitter = Pose2(0.0, 0.0)
    one_of: str = ""
    parameters: Annotated[Mapping[str, Any], Rest()] = Open()

    def with_keys(self, script: type[D]) -> D:
        """The script with the keys of this table.

        Raises:
            InputError: Parameters are unknown, missing, of a wrong unit or out of range; the error lists all faults.
        """
        return read_values(script, self.parameters, f"{self.script.rpartition(':')[2]} '{self.name}'")

    @classmethod
    def _prepare(cls, table: Table, scope: Scope) -> None:
        """Note the fault of a robot that the seed would select."""
        if "robot" in table and "one_of" in table:
            table.fault("one_of", "one_of is for objects of the world, and this actor is a robot.", "Remove it.")


class RequirementSpec(Value):
    """One `[[requirement]]` table: a condition on the whole run, reported in the summary; it does not affect outcomes.

    Attributes:
        name: Requirement's name.
        require: Condition in the rule language, such as `always min_clearance > 0.05 m`.
        agent: Name of the agent for which the requirement is checked; empty for every agent.
        doc: One-sentence description.
    """

    name: Name
    require: str
    agent: Annotated[str, Names("agent", "no agent")] = ""
    doc: str = ""

    def applies_to(self, agent: str) -> bool:
        """Whether the requirement is checked for an agent."""
        return self.agent in ("", agent)


class ScenarioSpec(Value):
    """Content of a scenario file.

    Attributes:
        name: File stem.
        file: Scenario file.
        bases: Scenario files that this one is based on, nearest first.
        format: Format of the file.
        doc: One-sentence description.
        world: World's name.
        duration: Time limit of the episode [s].
        end_on_collision: Whether a collision ends the episode.
        nodes: Dialect of the missions of agents that name none.
        rate: Rates of physics, control, plan and sensors.
        places: Places in the agents' initial Knowledge.
        facts: Further facts, initial or received during the run.
        agents: Robots with a mission.
        actors: Scripted robots and objects.
        requirements: Conditions on the whole run.
        tables: Tables of packages (`rocs_bt.tables`), such as `[share]`, by name.
        grounds: Parts of the floor that are not level.
        pushes: Scheduled pushes of robots.
    """

    name: Annotated[str, SetByPrograms()] = ""
    file: Annotated[Path, SetByPrograms()] = Path()
    bases: Annotated[tuple[Path, ...], SetByPrograms()] = ()
    format: Annotated[Literal["scenario/2"], InFile()] = "scenario/2"
    doc: str = ""
    world: Annotated[str, Content("world")]
    duration: At = 60.0
    end_on_collision: bool = False
    nodes: Dialect = ""
    rate: RateSpec = RateSpec()
    places: Annotated[tuple[PlaceSpec, ...], Key("place")] = ()
    agents: Annotated[tuple[AgentSpec, ...], Key("agent")] = ()
    actors: Annotated[tuple[ActorSpec, ...], Key("actor")] = ()
    requirements: Annotated[tuple[RequirementSpec, ...], Key("requirement")] = ()
    facts: Annotated[tuple[FactSpec, ...], Key("fact")] = ()
    tables: Annotated[Mapping[str, Any], Registered("scenario")] = Open()
    grounds: Annotated[tuple[GroundSpec, ...], Key("ground")] = ()
    pushes: Annotated[tuple[PushSpec, ...], Key("push")] = ()

    @classmethod
    def _prepare(cls, table: Table, scope: Scope) -> None:
        """Add the names of agents, goals and robots; note names that two tables have, and a lack of agents."""
        agents, actors, places = (rows_in(table, key) for key in ("agent", "actor", "place"))
        scope.names |= {
            "agent": names_of(agents),
            "goal": names_of(place for place in places if place.get("kind", "goal") == "goal"),
            "robot": names_of([*agents, *(actor for actor in actors if "robot" in actor)]),
        }
        shared = "Agents, actors and places share their names: give each its own."
        note_twice(table, ("agent", "actor", "place"), "table", shared)
        note_twice(table, ("requirement",), "table", "Give each requirement its own.")
        note_twice(table, ("ground",), "ground", "Give each ground its own.")
        if not agents:
            table.fault(None, "the scenario has no agent.", "Add an [[agent]] table.")

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
    found = read_root(ScenarioSpec, root, Scope(missing=missing, optional=() if missions else ("mission",)))
    agents = tuple(replaced(agent, nodes=agent.nodes or found.nodes) for agent in found.agents)
    return replaced(found, name=root.file.stem, file=root.file, bases=root.bases, agents=agents)
