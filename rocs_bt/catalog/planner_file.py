"""Planner files (planner/1): mission, rule files, parameters and planning-time budget."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..base.errors import Fault, InputError
from ..base.python_content import is_reference
from ..base.toml_table import Table, read_toml
from ..plan import mission_arguments
from .perturbation import Perturbation
from .scenario_file import AgentSpec, ScenarioSpec, dialect_in
from .values import ParameterTable, latency_of, mission_parameters_in

FORMAT = "planner/1"
Missing = Callable[[str, str], Fault | None]


@dataclass(frozen=True, kw_only=True)
class PlannerSpec:
    """A planner: mission, rules and parameters of an agent; with `robot`, also the robot that they control.

    Attributes:
        name: Name in results.
        mission: Mission's name; or `file.py:Class` for a PythonPlanner, which has no tree. Empty for the mission, rules
            and parameters of the scenario itself.
        rules: Names of the rule files; empty for a planner without reflexes.
        parameters: Mission parameters as written in a scenario: `{"cruise": "0.5 m/s"}`.
        latency: Planning time [s], simulated; None if it is measured, which is not reproducible.
        nodes: Dialect of a mission in XML, one of `DIALECTS`; empty to recognise it.
        robot: Robot that the planner controls; empty for the robot of the scenario.
        perturbations: Changes of the simulated robot of which planner and agent do not know.
        oracle: Whether the planner gets ground-truth information: the map of a scene (`Mission.privileged`), and the
            true future of what moves.
        doc: One-sentence description.
        source: Book or paper of the method.
        file: Planner file; None for a planner made by a program.
        parameters_at: Position of the parameters in the file; None for those made by a program.
    """

    name: str
    mission: str
    rules: tuple[str, ...] = ()
    parameters: Mapping[str, Any] = field(default_factory=dict)
    latency: float | None = 0.0
    nodes: str = ""
    robot: str = ""
    perturbations: tuple[Perturbation, ...] = ()
    oracle: bool = False
    doc: str = ""
    source: str = ""
    file: Path | None = None
    parameters_at: ParameterTable | None = None

    def drives(self, scenario: ScenarioSpec, agent: str, privileged: Mapping[str, Any] | None = None) -> ScenarioSpec:
        """Copy of a scenario in which this planner controls an agent; name and random samples do not change.

        Args:
            scenario: Scenario to copy.
            agent: Name of an agent of the scenario.
            privileged: Ground-truth information; passed on only if this planner is an oracle.
        """
        known = (privileged or {}) if self.oracle else None
        agents = [self._instead_of(each, known) if each.name == agent else each for each in scenario.agents]
        return replace(scenario, agents=tuple(agents))

    def on(self, robot: str) -> PlannerSpec:
        """This planner on a robot, named `PLANNER@ROBOT`."""
        return replace(self, name=f"{self.name}@{robot}", robot=robot)

    def under(self, *perturbations: Perturbation) -> PlannerSpec:
        """This planner with perturbations of its robot, named `PLANNER~NAME=STRENGTH`."""
        name = "~".join((self.name, *map(str, perturbations)))
        return replace(self, name=name, perturbations=(*self.perturbations, *perturbations))

    def _instead_of(self, agent: AgentSpec, privileged: Mapping[str, Any] | None) -> AgentSpec:
        agent = replace(agent, robot=self.robot or agent.robot, perturbations=self.perturbations)
        if not self.mission:
            return agent
        return replace(
            agent,
            mission=self.mission,
            rules=self.rules,
            parameters=dict(self.parameters),
            parameters_at=self.parameters_at,
            latency=self.latency,
            nodes=self.nodes,
            privileged=privileged,
        )


def read_planner(file: Path, missing: Missing = lambda kind, name: None) -> PlannerSpec:
    """Read a planner file.

    Args:
        file: File to read.
        missing: Returns the fault of referenced content that cannot be used, by kind and name, or None; faults are
            reported at the position of the name.

    Raises:
        InputError: The file has faults; contains all of them, each with its line.
    """
    root = read_toml(file)
    root.choice("format", (FORMAT,))
    doc, source = root.text("doc", ""), root.text("source", "")
    rules = tuple(root.texts("rules", []))
    for name in rules:
        if fault := missing("rules", name):
            root.fault("rules", fault.message, fault.hint)
    parameters, parameters_at = mission_parameters_in(root)
    spec = PlannerSpec(
        name=file.stem,
        mission=_mission(root, missing),
        rules=rules,
        parameters=parameters,
        parameters_at=parameters_at,
        latency=latency_of(root),
        nodes=dialect_in(root),
        oracle=root.flag("oracle", False),
        doc=doc,
        source=source,
        file=file,
    )
    root.done()
    return spec


def mission_values(build: Callable[..., Any], controller: AgentSpec | PlannerSpec) -> dict[str, Any]:
    """Parameters of an agent or a planner as arguments of its mission, in SI units.

    Raises:
        InputError: The mission does not take them; each fault has the position of its parameter.
    """
    if (at := controller.parameters_at) is None:
        return mission_arguments(build, controller.parameters)
    try:
        return mission_arguments(build, controller.parameters, at.file, at.positions)
    except InputError as error:
        raise error.at(*at.of("")) from error


def _mission(root: Table, missing: Missing) -> str:
    """Name of the mission, or `file.py:Class` of the key `python`."""
    root.text("mission", ""), root.text("python", "")  # marks both keys as known
    if ("mission" in root) == ("python" in root):
        root.fault(None, "a planner needs either 'mission' or 'python'.", "Write mission = ... or python = ...")
        return ""
    key = "mission" if "mission" in root else "python"
    name = root.text(key)
    if key == "python" and not is_reference(name):
        root.fault(
            key, f"'{name}' is not a class reference.", 'Write python = "file.py:Class"; the file is beside this one.'
        )
        return name
    if key == "python" and root.file.parent.name != "planners":
        name = str(root.file.parent / name)  # a catalog searches relative names in `planners` only
    if fault := missing("mission", name):
        root.fault(key, fault.message, fault.hint)
    return name
