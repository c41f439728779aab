"""Catalog of content by name: the user's project first, then the shipped content (docs/architecture.md)."""

from __future__ import annotations

import copy
import os
from collections import OrderedDict
from collections.abc import Callable, Collection, Hashable, Iterable, Iterator, Mapping
from functools import partial, wraps
from pathlib import Path
from types import ModuleType
from typing import Any, Self, TypeVar, cast

from ..confine import confined
from ..dialect import parts_of
from ..document import Table, read_toml
from ..errors import Fault, InputError, UnknownName, unknown
from ..files import is_file, same_file
from ..knowledge import SCHEMA, Schema, load_schema
from ..python_content import classes_in, guarded, is_reference, load_class, load_module, texts_in
from ..reactive import included_files
from ..toml_text import as_data, as_toml
from .entry import (
    KINDS,
    TREES,
    Entry,
    by_name,
    confine_name,
    content_hash,
    find_project,
    is_path,
    make_entry,
    scan,
    shipped_root,
)
from .inherit import merged_with_base
from .perturbation import Perturbation, parse_perturbation, read_perturbations
from .planner_file import PlannerSpec, read_planner
from .robot_file import load_robot
from .robot_spec import RobotSpec
from .scenario_file import AgentSpec, ScenarioSpec, read_scenario

T = TypeVar("T")

_SINGULAR = {"rules": "rule file"}  # kinds with a plural name


class Catalog:
    """Content of a project and of rocs_bt, by kind and name.

    Args:
        project: Project's root; None for shipped content only.
        code: Whether Python content may run; False with `--no-code`.

    Raises:
        InputError: The project folder does not exist.
    """

    def __init__(self, project: Path | str | None = None, *, code: bool = True) -> None:
        self.shipped = shipped_root()
        project = None if project is None else Path(project)
        if project is not None and not project.is_dir():
            raise InputError(Fault(f"there is no project folder '{project}'.", hint="Give an existing folder."))
        self.project = None if project is None or project.resolve() == self.shipped else project.resolve()
        self.code = code
        self._entries_of: dict[str, dict[str, Entry]] = {}  # by kind: project and shipped entries
        self._made: dict[str, Entry] = {}  # by kind: scenario and world made by a program
        self._made_scenario: dict[str, Any] = {}

    @classmethod
    def here(cls, start: Path | None = None, *, code: bool = True) -> Self:
        """Catalog of the project that contains a folder; the current folder by default."""
        return cls(find_project(start or Path.cwd()), code=code)

    def fresh(self) -> Catalog:
        """Catalog of the same project that looks at its folders again."""
        return Catalog(self.project, code=self.code)

    def with_scene(self, name: str, scenario: Mapping[str, Any], world: str) -> Self:
        """Copy of this catalog, with its cache, to which a scenario and a world made by a program are added.

        Args:
            name: Name of both; they hide a scenario and a world of this name in the project.
            scenario: Content of the scenario's file: dicts, lists, texts, numbers and flags.
            world: World as MJCF.
        """
        other = copy.copy(self)
        other._made_scenario = as_data(scenario)
        other._made = {
            "scenario": Entry(name, "scenario", Path(f"{name}.toml"), text=as_toml(scenario)),
            "world": Entry(name, "world", Path(f"{name}.xml"), text=world),
        }
        return other

    def list(self, kind: str | None = None) -> list[Entry]:
        """Entries of a kind, or of all kinds, sorted by kind and name; a project's entry hides a shipped one.

        Raises:
            InputError: Unknown kind, or two files of one folder have the same name.
        """
        kinds = list(KINDS) if kind is None else [kind]
        return [entry for k in kinds for _, entry in sorted(self._entries(k).items())]

    @property
    def roots(self) -> tuple[Path, ...]:
        """Folders of the files that content may name: the project and the shipped content."""
        return tuple(root for root in (self.project, self.shipped) if root is not None)

    def find(self, kind: str, name: str, *, named_in: Path | None = None) -> Entry:
        """Find an entry by name or path.

        Args:
            kind: Kind of the entry.
            name: Name or path of the entry.
            named_in: Content file that contains the name, if any; a path must then be inside the project.

        Raises:
            UnknownName: No such entry; lists the existing ones.
            InputError: The entry is outside the project, directly or through a link.
        """
        if named_in is not None and (is_path(name) or is_reference(name)):
            confine_name(name, self.roots, self.root_of(named_in))
        if kind == "mission" and is_reference(name):
            return self._python_planner(name.partition(":")[0])
        if is_path(name):
            return self._by_path(kind, Path(name))
        entries = self._entries(kind)
        if name not in entries:
            raise UnknownName(unknown(_SINGULAR.get(kind, kind), name, entries))
        self.confine(entries[name])
        return entries[name]

    def confine(self, entry: Entry) -> None:
        """Refuse an entry of the project that is a symbolic link to a file outside the project.

        An entry that the user names by its path may be anywhere.

        Raises:
            InputError: The entry is outside the project.
        """
        if entry.origin == "project" and entry.text is None:
            confined(entry.path, Path(), self.roots)

    def load_robot(self, name: str) -> RobotSpec:
        """Load a robot by name.

        Raises:
            InputError: The robot does not exist, or its file has faults; contains all of them.
        """
        file = self.find("robot", name).path
        return load_robot(file, lambda base: self.find("robot", base, named_in=file).path)

    def robot_of(self, agent: AgentSpec) -> RobotSpec:
        """Load the robot of an agent, with the tables of the scenario that override the robot's.

        Raises:
            InputError: The robot does not exist, or its file or these tables have faults; contains all of them.
        """
        if agent.overlay is None:
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
                faults += error.at(scenario.file, scenario.rate.line).faults
            else:
                faults += _agent_faults(scenario, each, robot)
        if faults:
            raise InputError(*faults)

    def read_scenario(self, name: str, *, missions: bool = True) -> ScenarioSpec:
        """Read a scenario by name or path without checking its robots; see `load_scenario`.

        Raises:
            InputError: The file or its bases have faults; contains all of them, each with its line.
        """
        entry = self.find("scenario", name)
        file = entry.path
        own = read_toml(file) if entry.text is None else Table(file, self._made_scenario, (), {})
        table = merged_with_base(own, lambda base: self.find("scenario", base, named_in=file).path)
        return read_scenario(table, partial(self._missing, file), missions=missions)

    def content_of(self, scenario: ScenarioSpec) -> tuple[Entry, ...]:
        """Catalog entries of all files that a scenario uses, including the scenario, for `content_hash`.

        Raises:
            InputError: Referenced content does not exist.
        """
        entries = [self.entry_of(scenario), self.find("world", scenario.world)]
        entries += [self.find("scenario", path.stem) for path in scenario.bases]
        for name in scenario.robots:
            entries += self.content_of_robot(name)
        for agent in scenario.agents:
            entries += self.content_of_controller(agent)
        entries += self.list("schema")
        return tuple(dict.fromkeys(entries))

    @property
    def made(self) -> tuple[Entry, ...]:
        """Scenario and world made by a program; empty if there are none."""
        return tuple(self._made.values())

    def entry_of(self, scenario: ScenarioSpec) -> Entry:
        """Entry of a loaded scenario."""
        made = self._made.get("scenario")
        return made if made and made.path == scenario.file else make_entry(scenario.file, "scenario", "file")

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

    def digest(self, scenario: ScenarioSpec, more: tuple[Entry, ...] = ()) -> str:
        """`content_hash` of all entries that a scenario uses, and of more that a run was given."""
        return content_hash((*self.content_of(scenario), *more))

    def cached(self, key: Hashable, make: Callable[[], T]) -> T:
        """Result of `make`, such as a compiled world; a `CachingCatalog` makes it only once for each key."""
        return make()

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

    def load_mission(self, name: str, dialect: str = "") -> Callable[..., Any]:
        """Load the function `build` of a mission; for an XML mission, a function that makes its tree.

        Args:
            name: Name or path; or `file.py:Class` for a PythonPlanner, a path or relative to `planners`.
            dialect: Dialect of the nodes in XML, one of `rocs_bt.dialect.DIALECTS`; empty to recognise it.

        Raises:
            InputError: The mission does not exist, does not load, has no `build`, or `--no-code` forbids it.
        """
        entry = self.find("mission", name)
        if is_reference(name):
            return self.with_content(self._python_mission(entry.path, name.rpartition(":")[2]), dialect)
        if entry.path.suffix != ".py":
            return self.with_content(self._xml_mission(entry.path, dialect), dialect)
        build = getattr(self.load_python(entry), "build", None)
        if not callable(build):
            hint = "Write: def build(mission: Mission): ..."
            raise InputError(Fault("the mission has no function 'build'.", entry.path, hint=hint))
        return self.with_content(guarded(cast("Callable[..., Any]", build), entry.path), dialect)

    def with_content(self, build: Callable[..., Any], dialect: str = "") -> Callable[..., Any]:
        """Wrap a `build` function so that its mission finds content in this catalog, and trees of this dialect."""

        @wraps(build)
        def with_catalog(mission: Any, *args: Any, **kwargs: Any) -> Any:
            if mission.content is not self:  # else a Python subtree of this mission, which has the dialect of the whole
                mission.content, mission.dialect = self, dialect
            return build(mission, *args, **kwargs)

        return with_catalog

    def _python_planner(self, file: str) -> Entry:
        """Entry of a PythonPlanner's file."""
        for root in filter(None, (self.project, self.shipped)):
            if not Path(file).is_absolute() and is_file(path := root / "planners" / file):
                return make_entry(path, "planner", "file")
        return self._by_path("planner", Path(file))

    def _python_mission(self, file: Path, name: str) -> Callable[..., Any]:
        from ..plan import python_mission

        return guarded(python_mission(self.load_class(file, name)), file)

    def _xml_mission(self, file: Path, dialect: str) -> Callable[..., Any]:
        from ..plan import xml_mission  # imported late: it loads py_trees

        return xml_mission(
            file,
            within=self.root_of(file),
            nodes=self.load_nodes,
            defined=self.defined_nodes,
            missions=self.python_tree,
            beside=self.tree_files(),
            dialect=dialect,
        )

    def root_of(self, file: Path) -> Path:
        """Project root or shipped root that contains a file; else the file's folder."""
        path = file.resolve()
        roots = [root for root in (self.project, self.shipped) if root is not None and path.is_relative_to(root)]
        return roots[0] if roots else path.parent

    def load_nodes(self, names: Collection[str] | None = None) -> tuple[type[Any], ...]:
        """Load the node classes in the Python files of `planners/nodes`: all, or those with the given names.

        A node has the name of its class. Only files that define one of the names are run.

        Raises:
            InputError: A file does not load, two classes have the same name, or `--no-code` forbids it.
        """
        from ..trees.nodes import nodes_of

        entries = self._node_files(names)
        self._allow(*(entry.path for entry in entries))
        for entry in entries:
            self.confine(entry)
        classes = [node for entry in entries for node in nodes_of(load_module(entry.path))]
        return tuple(node for node in classes if names is None or node.tag in names)

    def load_route(self, name: str) -> type[Any]:
        """Load the route planner in a Python file of `planners/routes`, by the file's name.

        Raises:
            InputError: The file does not exist, does not load, does not have exactly one RoutePlanner, or `--no-code`
                forbids it.
        """
        from ..plan.route import RoutePlanner

        entry = self.find("route", name)
        module = self.load_python(entry)
        own = [v for v in vars(module).values() if isinstance(v, type) and v.__module__ == module.__name__]
        planners = [cls for cls in own if issubclass(cls, RoutePlanner)]
        if len(planners) != 1:
            hint = "Write one class that derives from rocs_bt.plan.RoutePlanner."
            message = f"expected one route planner in the file, found {len(planners)}."
            raise InputError(Fault(message, entry.path, hint=hint))
        return planners[0]

    def _node_files(self, names: Collection[str] | None) -> tuple[Entry, ...]:
        """Node files that define one of these classes; found by parsing, without running them."""
        entries = [e for e in self.list("node") if e.path.suffix == ".py"]
        return tuple(e for e in entries if names is None or set(names) & set(classes_in(e.path)))

    def defined_nodes(self, names: Collection[str]) -> set[str]:
        """Those of these names of node classes that files of `planners/nodes` define; no file is run."""
        return {name for entry in self._node_files(names) for name in classes_in(entry.path)} & set(names)

    def python_tree(self, name: str) -> Callable[..., Any] | None:
        """Load the `build` function of a Python mission that a SubTree names; None if there is no such mission."""
        return self.load_mission(name) if self.is_python_mission(name) else None

    def is_python_mission(self, name: str) -> bool:
        """Whether the mission of this name is written in Python."""
        entry = self._entries("mission").get(name)
        return entry is not None and entry.path.suffix == ".py"

    def python_of(self, mission: Entry, values: Iterable[object] = (), dialect: str = "") -> tuple[Entry, ...]:
        """Node files, route planners and Python missions that a mission names.

        Args:
            mission: Entry of the mission.
            values: Values of its parameters, which may also name a route planner.
            dialect: Dialect of the nodes in XML; empty to recognise it.
        """
        missions: set[str] = set()
        if mission.path.suffix in TREES:
            from ..plan.nav2 import ROUTES
            from ..plan.xml_mission import dialect_in, shipped_nodes, tags_of, values_of
            from ..trees.xml import add_siblings, outer_trees, read_document

            document = read_document(mission.path, within=self.root_of(mission.path))
            add_siblings(document, self.tree_files())
            dialect = dialect_in(document, dialect, self.defined_nodes)
            tags, texts = tags_of(document) - set(shipped_nodes(dialect)), values_of(document)
            texts |= set(ROUTES if parts_of(dialect)[0] == "nav2" else ())
            missions = {name for name in outer_trees(document) if self.is_python_mission(name)}
        else:
            texts = {text for file in mission.files() for text in texts_in(file)}
            tags = texts.union(*map(self._tags_in, self._trees_in(mission)))
        named = texts | {value for value in values if isinstance(value, str)}
        routes = [entry for entry in self.list("route") if entry.name in named]
        return (*self._node_files(tags), *routes, *(self.find("mission", name) for name in sorted(missions)))

    def tree_files(self) -> dict[str, Path]:
        """Files of the missions in XML by name; a SubTree refers to the tree of the same name in such a file."""
        return {name: e.path for name, e in self._entries("mission").items() if e.path.suffix in TREES}

    def _tags_in(self, tree: Entry) -> set[str]:
        """Names of the node classes in an XML file; none if it is not a mission."""
        from ..plan.xml_mission import tags_of
        from ..trees.xml import read_document

        try:
            return tags_of(read_document(tree.path, within=self.root_of(tree.path)))
        except InputError:
            return set()  # another file, such as a world; a mission is reported where it is loaded

    def _trees_in(self, mission: Entry) -> Iterable[Entry]:
        """XML files with trees that a mission names: by the name of a mission, or as a file beside a Python mission."""
        from ..trees.xml import add_siblings, read_document

        named, files = self.tree_files(), list[Path]()
        if mission.path.suffix in TREES:
            files = add_siblings(read_document(mission.path, within=self.root_of(mission.path)), named)
        elif mission.path.suffix == ".py":
            texts = sorted({text for file in mission.files() for text in texts_in(file)})
            found = [mission.path.parent / text if text.endswith(TREES) else named.get(text) for text in texts]
            files = [file for file in found if file is not None and is_file(file)]
        return [make_entry(file, "mission", mission.origin) for file in dict.fromkeys(files)]

    def load_python(self, entry: Entry) -> ModuleType:
        """Load the module of a Python content file; it runs once per process.

        Raises:
            InputError: The file is not Python, does not load, or `--no-code` forbids it.
        """
        self._allow(entry.path)
        self.confine(entry)
        return load_module(entry.path)

    def load_class(self, path: Path, name: str) -> type:
        """Load a class that robot.toml names by `file.py:Class`.

        Raises:
            InputError: The file does not load or lacks the class, or `--no-code` forbids it.
        """
        self._allow(path)
        return load_class(path, name)

    def _allow(self, *paths: Path) -> None:
        """Refuse Python files if `--no-code` was given."""
        code = [path for path in paths if path.suffix == ".py"]
        if code and not self.code:
            hint = "Remove --no-code if you trust the file."
            message = "this Python content may not run: --no-code was given."
            raise InputError(*(Fault(message, p, hint=hint) for p in code))

    def _missing(self, file: Path, kind: str, name: str) -> Fault | None:
        """Fault if a content file names other content that does not exist or is outside the project; else None."""
        try:
            self.find(kind, name, named_in=file)
        except InputError as error:
            return error.faults[0]
        return None

    def _entries(self, kind: str) -> dict[str, Entry]:
        if kind not in KINDS:
            raise UnknownName(unknown("kind of content", kind, KINDS))
        if kind not in self._entries_of:
            shipped = by_name(scan(self.shipped, kind, "shipped"))
            own = {} if self.project is None else by_name(scan(self.project, kind, "project"))
            self._entries_of[kind] = {**shipped, **own}
        found, made = self._entries_of[kind], self._made.get(kind)
        return found if made is None else {**found, made.name: made}

    def _by_path(self, kind: str, path: Path) -> Entry:
        if kind == "robot" and os.path.isdir(path):
            path /= "robot.toml"
        if not is_file(path):
            raise UnknownName(unknown(_SINGULAR.get(kind, f"{kind} file"), str(path), self._entries(kind)))
        return make_entry(path.resolve(), kind, "file")


def _agent_faults(scenario: ScenarioSpec, name: str, robot: RobotSpec) -> Iterator[Fault]:
    """Faults of a robot as an agent of a scenario, each located in the file that has to change.

    An agent, its devices and the places that it knows are nodes of one graph, so their names must differ. The maximum
    command age of an actuator must not be shorter than the control period of the scenario.

    Args:
        scenario: The scenario.
        name: Robot's name in the scenario.
        robot: The robot.
    """
    agents = [agent for agent in scenario.agents if agent.robot == name]
    devices = {d.name: kind for kind, of in (("sensor", robot.sensors), ("actuator", robot.actuators)) for d in of}
    named = [(agent.name, agent.line) for agent in agents]
    names = {agent.name for agent in agents}
    named += [(place.name, place.line) for place in scenario.places if names.intersection(place.agents)]
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


LIMIT = 64
"""Maximum number of cached objects; then the least recently used one is dropped."""


class CachingCatalog(Catalog):
    """Catalog that caches loaded content and objects made of it. Files must not change while the catalog is in use.

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

    def load_robot(self, name: str) -> RobotSpec:
        return self.cached(("robot", name), lambda: super(CachingCatalog, self).load_robot(name))

    def robot_of(self, agent: AgentSpec) -> RobotSpec:
        return self.cached(
            ("robot", agent.robot, repr(agent.overlay)), lambda: super(CachingCatalog, self).robot_of(agent)
        )

    def load_mission(self, name: str, dialect: str = "") -> Callable[..., Any]:
        key = "mission", name, dialect
        return self.cached(key, lambda: super(CachingCatalog, self).load_mission(name, dialect))

    def read_scenario(self, name: str, *, missions: bool = True) -> ScenarioSpec:
        key = "scenario", name, missions, self.made
        return self.cached(key, lambda: super(CachingCatalog, self).read_scenario(name, missions=missions))

    def content_of_controller(self, controller: AgentSpec | PlannerSpec) -> tuple[Entry, ...]:
        key = "controller", controller.mission, controller.rules, repr(controller.parameters), controller.nodes
        return self.cached(key, lambda: super(CachingCatalog, self).content_of_controller(controller))

    def digest(self, scenario: ScenarioSpec, more: tuple[Entry, ...] = ()) -> str:
        agents = tuple((a.name, a.robot, a.mission, a.rules, repr(a.parameters), a.nodes) for a in scenario.agents)
        return self.cached(
            ("digest", scenario.file, self.made, agents, more),
            lambda: super(CachingCatalog, self).digest(scenario, more),
        )
