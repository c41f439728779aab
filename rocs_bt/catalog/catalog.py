"""Catalog of content by name: the user's project first, then the shipped content (docs/architecture.md)."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeVar, cast

from ..base.errors import Fault, InputError, did_you_mean, located_at
from ..base.files import confined, is_file, same_file
from ..base.python_content import is_reference, lacks_class
from ..base.toml_table import Table, read_toml
from ..declare import location_of
from ..knowledge import SCHEMA, Schema, load_schema
from ..reactive import included_files
from .content_kinds import Entry, content_hash, make_entry, scan
from .device_spec import ActuatorSpec, SensorSpec
from .finder import kept
from .inherit import merged_with_base
from .mission_catalog import MissionCatalog
from .perturbation import Perturbation, parse_perturbation, read_perturbations
from .planner_file import PlannerSpec, read_planner
from .robot_file import load_robot
from .robot_spec import RobotSpec
from .scenario_file import AgentSpec, ScenarioSpec, read_scenario

T = TypeVar("T")

LIMIT = 64
"""Maximum number of objects that a `CachingCatalog` keeps; then the least recently used one is dropped."""


class Catalog(MissionCatalog):
    """Content of a project and of rocs_bt, by kind and name.

    Args:
        project: Project's root; None for shipped content only.
        code: Whether Python content may run; False with `--no-code`.

    Raises:
        InputError: The project folder does not exist.
    """

    def fresh(self) -> Catalog:
        """Catalog of the same project that looks at its folders again."""
        return Catalog(self.project, code=self.code)

    @kept(lambda self, name: (name,))
    def load_robot(self, name: str) -> RobotSpec:
        """Load a robot by name.

        Raises:
            InputError: The robot does not exist, or its file has faults; contains all of them.
        """
        file = self.find("robot", name).path
        return load_robot(file, lambda base: self.find("robot", base, named_in=file).path)

    @kept(lambda self, agent: (agent.robot, location_of(agent.overlay), repr(agent.overlay)))
    def robot_of(self, agent: AgentSpec) -> RobotSpec:
        """Load the robot of an agent, with the tables of the scenario that override the robot's.

        Raises:
            InputError: The robot does not exist, or its file or these tables have faults; contains all of them.
        """
        if not agent.overlay:
            return self.load_robot(agent.robot)
        file = self.find("robot", agent.robot).path
        return load_robot(file, lambda base: self.find("robot", base, named_in=file).path, agent.overlay)

    def load_scenario(self, name: str, *, missions: bool = True) -> ScenarioSpec:
        """Load a scenario by name or path, and check that its content exists and that its rates and robots fit.

        Args:
            name: Name or path.
            missions: Whether each agent must have a mission.

        Raises:
            InputError: The scenario has faults; contains all of them, each with its line.
        """
        scenario = self.read_scenario(name, missions=missions)
        self.check_robots(scenario)
        self._allow(*(entry.path for entry in self.content_of(scenario)))
        return scenario

    def check_robots(self, scenario: ScenarioSpec) -> None:
        """Check that the robots of a scenario exist and can do what it asks of them.

        Raises:
            InputError: A robot has faults, or does not fit the scenario; contains all faults, each with its line.
        """
        faults: list[Fault] = []
        robots = [(name, partial(self.load_robot, name)) for name in scenario.robots]
        for each, load in (*robots, *((a.robot, partial(self.robot_of, a)) for a in scenario.agents if a.overlay)):
            try:
                robot = load()
                self._allow(*robot.code)
                for sensor in robot.sensors:
                    scenario.rate.sensor_rate(sensor.rate, f"{each}/{sensor.name}")
            except InputError as error:
                faults += error.at(scenario.file, location_of(scenario.rate).line).faults
            else:
                faults += _agent_faults(scenario, each, robot)
        if faults:
            raise InputError(*faults)

    @kept(lambda self, name, missions=True: (name, missions, self.made))
    def read_scenario(self, name: str, *, missions: bool = True) -> ScenarioSpec:
        """Read a scenario by name or path without checking its robots; see `load_scenario`.

        Raises:
            InputError: The file or its bases have faults; contains all of them, each with its line.
        """
        entry = self.find("scenario", name)
        file = entry.path
        own = read_toml(file) if entry.text is None else Table(file, self._made_scenario, (), {})
        table = merged_with_base(own, lambda base: self.find("scenario", base, named_in=file).path)
        return read_scenario(table, partial(self._unusable, table), missions=missions)

    def content_of(self, scenario: ScenarioSpec) -> tuple[Entry, ...]:
        """Catalog entries of all files that a scenario uses, including the scenario, for `content_hash`.

        Raises:
            InputError: Referenced content does not exist.
        """
        entries = [self.entry_of(scenario), self.find("world", scenario.world)]
        entries += [self.find("scenario", path.stem) for path in scenario.bases]
        scripts = {actor.script for actor in scenario.actors if is_reference(actor.script)}
        files = (self._script_file((scenario.file, *scenario.bases), script) for script in scripts)
        entries += [make_entry(file, "script", "file") for file in files]
        for name in scenario.robots:
            entries += self.content_of_robot(name)
        for agent in scenario.agents:
            entries += self.content_of_controller(agent)
        entries += self.list("schema")
        return tuple(dict.fromkeys(entries))

    def load_driver(self, robot: RobotSpec, device: SensorSpec | ActuatorSpec) -> type:
        """Load the class of a driver that a robot's device names by `file.py:Class`.

        Raises:
            InputError: The class does not load; at the line of the device.
        """
        file, _, name = device.driver.partition(":")
        with located_at(robot.file, device.line):
            return self.load_class(robot.beside(file), name)

    def load_script(self, scenario: ScenarioSpec, name: str) -> type:
        """Load the class of a script that an actor of a scenario names by `file.py:Class`.

        Raises:
            InputError: The file does not load or lacks the class, or `--no-code` forbids it.
        """
        return self.load_class(self._script_file((scenario.file, *scenario.bases), name), name.partition(":")[2])

    def _script_file(self, files: Sequence[Path], name: str) -> Path:
        """File of a script `file.py:Class`: beside one of the scenarios; that of a family's scene is in `scenarios`."""
        script = name.partition(":")[0]
        folders = [*(file.parent for file in files), *(root / "scenarios" for root in self.roots)]
        found = next((folder for folder in folders if is_file(folder / script)), None)
        if found is None:
            beside = [path.name for path in files[0].parent.glob("*.py")]
            hint = did_you_mean(script, beside, "Its folder").brief
            raise InputError(Fault(f"there is no file '{script}' beside the scenario.", hint=hint))
        return confined(script, found, (found,))

    def _unusable(self, root: Table, kind: str, name: str) -> Fault | None:
        """Fault of content that a scenario names; the names of shipped scripts are those of the simulation."""
        if kind != "script":
            return self._missing(root.file, kind, name)
        if not is_reference(name):  # a script of the simulation, which is above the catalog
            return None
        try:
            return lacks_class(self._script_file((root.file, *root.bases), name), name.partition(":")[2])
        except InputError as error:
            return error.faults[0]

    def entry_of(self, scenario: ScenarioSpec) -> Entry:
        """Entry of a loaded scenario."""
        made = self._made.get("scenario")
        return made if made and made.path == scenario.file else make_entry(scenario.file, "scenario", "file")

    @kept(lambda self, of: (of.mission, of.rules, repr(of.parameters), of.nodes))
    def content_of_controller(self, controller: AgentSpec | PlannerSpec) -> tuple[Entry, ...]:
        """Catalog entries of a controller (an agent or a planner): mission, rules, and the files that these name.

        Raises:
            InputError: Referenced content does not exist.
        """
        if not controller.mission:
            return ()
        rules = [self.find("rules", name) for name in controller.rules]
        included = [make_entry(file, "rules", r.origin) for r in rules for file in included_files(r.path)]
        mission = self.find("mission", controller.mission)
        python = self.python_of(mission, controller.parameters.values(), controller.nodes)
        return mission, *self._trees_in(mission), *python, *rules, *included

    def content_of_robot(self, name: str) -> tuple[Entry, ...]:
        """Catalog entries of a robot and its bases.

        Raises:
            InputError: The robot or a base does not exist.
        """
        bases = [self.find("robot", path.parent.name) for path in self.load_robot(name).bases]
        return self.find("robot", name), *bases

    @kept(lambda self, scenario, more=(): (scenario.file, self.made, _controllers(scenario), more))
    def digest(self, scenario: ScenarioSpec, more: tuple[Entry, ...] = ()) -> str:
        """`content_hash` of all entries that a scenario uses, and of more that a run was given."""
        return content_hash((*self.content_of(scenario), *more))

    def load_schema(self) -> Schema:
        """Load the schema of Knowledge: the shipped schema, extended by the project's schema files.

        Raises:
            InputError: The files have faults; contains all of them, each with its line.
        """
        files = [self.find("schema", entry.name).path for entry in self.list("schema")]
        return load_schema(files, SCHEMA) if files else SCHEMA

    def load_perturbations(self) -> dict[str, Perturbation]:
        """Load the perturbations of robots by name: the shipped ones, extended by the project's file.

        Raises:
            InputError: A file has faults; contains all of them, each with its line.
        """
        found: dict[str, Perturbation] = {}
        for origin, root in (("shipped", self.shipped), ("project", self.project)):
            for entry in () if root is None else scan(root, "perturbations", origin):
                self.confine(entry)
                found |= read_perturbations(entry.path)
        return found

    def load_planner(self, name: str) -> PlannerSpec:
        """Load a planner by name or path, and check that its mission and rules exist.

        Args:
            name: Name or path; `PLANNER@ROBOT` is the planner on another robot than that of the scenario, and `@ROBOT`
                the scenario's own mission and rules on it. A robot's path remains part of the planner's name if the
                catalog has another robot, or none, of this name. `PLANNER~NAME=STRENGTH` is the planner with a
                perturbation of its robot.

        Raises:
            InputError: The file has faults; contains all of them, each with its line. Or the robot does not exist.
        """
        if "~" in name and not is_file(Path(name)):
            name, _, perturbed = name.partition("~")
            known = self.load_perturbations()
            return self.load_planner(name).under(*(parse_perturbation(each, known) for each in perturbed.split("~")))
        name, at, robot = name.partition("@")
        if name or not at:
            file = self.find("planner", name).path
            planner = read_planner(file, partial(self._missing, file))
        else:
            planner = PlannerSpec(name="", mission="", doc="The mission and the rules of the scenario.")
        return planner.on(self._robot_name(robot)) if at else planner

    def _robot_name(self, robot: str) -> str:
        """Name of a robot; its path as given if the catalog has another robot, or none, of this name."""
        found = self.find("robot", robot)
        listed = self._entries("robot").get(found.name)
        return found.name if listed and same_file(listed.path, found.path) else robot


class CachingCatalog(Catalog):
    """Catalog that keeps what it has loaded; files must not change while it is in use.

    Args:
        project: Project's root; None for shipped content only.
        code: Whether Python content may run.
    """

    def __init__(self, project: Path | None = None, *, code: bool = True) -> None:
        super().__init__(project, code=code)
        self._cached: OrderedDict[Hashable, Any] = OrderedDict()

    def cached(self, key: Hashable, make: Callable[[], T]) -> T:
        if key in self._cached:
            self._cached.move_to_end(key)
            return cast("T", self._cached[key])
        made = self._cached[key] = make()
        if len(self._cached) > LIMIT:
            self._cached.popitem(last=False)
        return made


def _controllers(scenario: ScenarioSpec) -> tuple[Hashable, ...]:
    return tuple((a.name, a.robot, a.mission, a.rules, repr(a.parameters), a.nodes) for a in scenario.agents)


def _agent_faults(scenario: ScenarioSpec, name: str, robot: RobotSpec) -> Iterator[Fault]:
    """Faults of a robot as an agent of a scenario, each located in the file that has to change.

    An agent, its devices and the places that it knows are nodes of one graph, so their names must differ. The maximum
    command age of an actuator must not be shorter than the control period of the scenario.
    """
    agents = [agent for agent in scenario.agents if agent.robot == name]
    devices = {d.name: kind for kind, of in (("sensor", robot.sensors), ("actuator", robot.actuators)) for d in of}
    named = [(agent.name, location_of(agent).line) for agent in agents]
    names = {agent.name for agent in agents}
    named += [(place.name, location_of(place).line) for place in scenario.places if names.intersection(place.agents)]
    for taken, line in named:
        if taken in devices:
            message = f"the name '{taken}' is taken by the {devices[taken]} '{taken}' of {robot.name}."
            yield Fault(message, scenario.file, line, hint="Choose another name.")
    period = scenario.rate.control_rate.period
    for actuator in robot.actuators if agents else ():
        if actuator.max_command_age < period - 1e-9:
            yield Fault(
                f"the actuator '{actuator.name}' goes to neutral {actuator.max_command_age:g} s after a command, but "
                f"{scenario.name} sends one only every {period:g} s.",
                robot.file,
                actuator.line,
                hint=f'Write max_command_age = "{4.0 * period:g} s", or use a higher control rate.',
            )
