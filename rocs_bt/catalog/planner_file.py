"""Planner files (planner/1): mission, rule files, parameters and planning-time budget."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from ..base.errors import InputError
from ..base.python_content import is_reference
from ..base.toml_table import Table, read_toml
from ..declare import Content, InFile, Open, Scope, SetByPrograms, Valid, Value, location_of, read, replaced
from ..plan import mission_arguments
from .marks import Dialect, Latency
from .perturbation import Perturbation
from .scenario_file import AgentSpec, Missing, ScenarioSpec

_REFERENCE = Valid(is_reference, "a class reference", 'Write python = "file.py:Class"; the file is beside this one.')


class PlannerSpec(Value):
    """A planner: mission, rules and parameters of an agent; with `robot`, also the robot that they control.

    Attributes:
        name: Name in results.
        mission: Mission's name; or `file.py:Class` for a PythonPlanner, which has no tree. Empty for the mission, rules
            and parameters of the scenario itself.
        rules: Names of the rule files; empty for a planner without reflexes.
        parameters: Mission parameters as written in a scenario: `{"cruise": "0.5 m/s"}`.
        latency: Planning time [s], simulated; None if it is measured, which is not reproducible.
        nodes: Dialect of a mission in XML, one of `dialects`; empty to recognise it.
        robot: Robot that the planner controls; empty for the robot of the scenario.
        perturbations: Changes of the simulated robot of which planner and agent do not know.
        oracle: Whether the planner gets ground-truth information: the map of a scene (`Mission.privileged`), and the
            true future of what moves.
        doc: One-sentence description.
        source: Book or paper of the method.
        format: Format of the file.
        python: `file.py:Class` in a file, beside which it is, in place of a mission.
        file: Planner file; None for a planner made by a program.
    """

    name: Annotated[str, SetByPrograms()] = ""
    format: Annotated[Literal["planner/1"], InFile()] = "planner/1"
    mission: Annotated[str, Content("mission")] = ""
    python: Annotated[str, _REFERENCE] = ""
    rules: Annotated[tuple[str, ...], Content("rules")] = ()
    parameters: Mapping[str, Any] = Open()
    latency: Latency = 0.0
    nodes: Dialect = ""
    robot: Annotated[str, SetByPrograms()] = ""
    perturbations: Annotated[tuple[Perturbation, ...], SetByPrograms()] = ()
    oracle: bool = False
    doc: str = ""
    source: str = ""
    file: Annotated[Path | None, SetByPrograms()] = None

    @classmethod
    def _prepare(cls, table: Table, scope: Scope) -> None:
        """Note the fault of a planner with no mission or two."""
        if ("mission" in table) == ("python" in table):
            message = "a planner needs either 'mission' or 'python'."
            table.fault(None, message, "Write mission = ... or python = ...")

    def drives(self, scenario: ScenarioSpec, agent: str, privileged: Mapping[str, Any] | None = None) -> ScenarioSpec:
        """Copy of a scenario in which this planner controls an agent; name and random samples do not change.

        Args:
            scenario: Scenario to copy.
            agent: Name of an agent of the scenario.
            privileged: Ground-truth information; passed on only if this planner is an oracle.
        """
        known = (privileged or {}) if self.oracle else None
        agents = [self._instead_of(each, known) if each.name == agent else each for each in scenario.agents]
        return replaced(scenario, agents=tuple(agents))

    def on(self, robot: str) -> PlannerSpec:
        """This planner on a robot, named `PLANNER@ROBOT`."""
        return replaced(self, name=f"{self.name}@{robot}", robot=robot)

    def under(self, *perturbations: Perturbation) -> PlannerSpec:
        """This planner with perturbations of its robot, named `PLANNER~NAME=STRENGTH`."""
        name = "~".join((self.name, *map(str, perturbations)))
        return replaced(self, name=name, perturbations=(*self.perturbations, *perturbations))

    def _instead_of(self, agent: AgentSpec, privileged: Mapping[str, Any] | None) -> AgentSpec:
        agent = replaced(agent, robot=self.robot or agent.robot, perturbations=self.perturbations)
        if not self.mission:
            return agent
        return replaced(
            agent,
            mission=self.mission,
            rules=self.rules,
            parameters=self.parameters,
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
    spec = replaced(read(PlannerSpec, root, Scope(missing=missing)), name=file.stem, file=file)
    if is_reference(spec.python):
        # A catalog searches relative names in `planners` only.
        name = spec.python if file.parent.name == "planners" else str(file.parent / spec.python)
        if fault := missing("mission", name):
            root.fault("python", fault.message, fault.hint)
        spec = replaced(spec, mission=name, python="")
    root.done()
    return spec


def mission_values(build: Callable[..., Any], controller: AgentSpec | PlannerSpec) -> dict[str, Any]:
    """Parameters of an agent or a planner as arguments of its mission, in SI units.

    Raises:
        InputError: The mission does not take them; each fault has the position of its parameter.
    """
    try:
        return mission_arguments(build, controller.parameters)
    except InputError as error:
        raise error.at(*location_of(controller.parameters)) from error
