"""The one place that finds content by name: the user's project first, then what we ship (docs/architecture.md)."""

from __future__ import annotations

import copy
import os
from collections import OrderedDict
from collections.abc import Callable, Collection, Hashable, Iterable, Iterator, Mapping
from functools import partial, wraps
from pathlib import Path
from types import ModuleType
from typing import Any, Self, TypeVar, cast

from ..confine import confined, is_file
from ..document import Table, read_toml
from ..errors import Fault, InputError, UnknownName, unknown
from ..knowledge import SCHEMA, Schema, load_schema
from ..python_content import classes_in, guarded, is_reference, load_class, load_module, texts_in
from ..reactive import included_files
from ..toml_text import as_data, as_toml
from .entry import (
    KINDS,
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
from .planner_file import PlannerSpec, read_planner
from .robot_file import load_robot
from .robot_spec import RobotSpec
from .scenario_file import AgentSpec, ScenarioSpec, read_scenario

T = TypeVar("T")

_SPOKEN = {"rules": "rule file"}  # what is one of a kind, where that is not the kind's own name


class Catalog:
    """All the content there is: a project's, and what we ship.

    Args:
        project: The project's root; None for shipped content only.
        code: Whether Python content may run; `--no-code` says no.

    Raises:
        InputError: There is no such folder.
    """

    def __init__(self, project: Path | None = None, *, code: bool = True) -> None:
        self.shipped = shipped_root()
        if project is not None and not project.is_dir():
            raise InputError(Fault(f"there is no project folder '{project}'.", hint="Name one that exists."))
        self.project = None if project is None or project.resolve() == self.shipped else project.resolve()
        self.code = code
        self._entries_of: dict[str, dict[str, Entry]] = {}  # by kind, what the project and we have
        self._made: dict[str, Entry] = {}  # by kind, a scenario and its world that a program made, found first
        self._made_scenario: dict[str, Any] = {}

    @staticmethod
    def here(start: Path | None = None, *, code: bool = True) -> Catalog:
        """The catalog of the project around a folder, the current one if none is given."""
        return Catalog(find_project(start or Path.cwd()), code=code)

    def with_scene(self, name: str, scenario: Mapping[str, Any], world: str) -> Self:
        """The same catalog, what it keeps included, with a scenario and its world that a program made.

        Args:
            name: Name of both; each hides one of the project.
            scenario: Content of the scenario's file: dicts, lists, texts, numbers and flags.
            world: The world as MJCF.
        """
        other = copy.copy(self)
        other._made_scenario = as_data(scenario)
        other._made = {
            "scenario": Entry(name, "scenario", Path(f"{name}.toml"), text=as_toml(scenario)),
            "world": Entry(name, "world", Path(f"{name}.xml"), text=world),
        }
        return other

    def list(self, kind: str | None = None) -> list[Entry]:
        """All entries of a kind, or of all kinds, sorted by kind and name; a project's hides a shipped one's name.

        Raises:
            InputError: There is no such kind, or two files of one folder have one name.
        """
        kinds = list(KINDS) if kind is None else [kind]
        return [entry for k in kinds for _, entry in sorted(self._entries(k).items())]

    @property
    def roots(self) -> tuple[Path, ...]:
        """The folders whose files content may name: the project, and what we ship."""
        return tuple(root for root in (self.project, self.shipped) if root is not None)

    def find(self, kind: str, name: str, *, named_in: Path | None = None) -> Entry:
        """One entry by its name, or by its path.

        Args:
            kind: Its kind.
            name: Its name, or its path.
            named_in: The content file that names it, if any: then a path must be inside the project.

        Raises:
            UnknownName: There is none; lists those that exist.
            InputError: It is outside of the project, itself or by a link.
        """
        if named_in is not None and (is_path(name) or is_reference(name)):
            confine_name(name, self.roots, self.root_of(named_in))
        if kind == "mission" and is_reference(name):
            return self._python_planner(name.partition(":")[0])
        if is_path(name):
            return self._by_path(kind, Path(name))
        entries = self._entries(kind)
        if name not in entries:
            raise UnknownName(unknown(_SPOKEN.get(kind, kind), name, entries))
        self.confine(entries[name])
        return entries[name]

    def confine(self, entry: Entry) -> None:
        """Refuse an entry that a link leads out of the project; one that a person named by its path may be anywhere.

        Raises:
            InputError: It is outside.
        """
        if entry.origin == "project" and entry.text is None:
            confined(entry.path, Path(), self.roots)

    def load_robot(self, name: str) -> RobotSpec:
        """A robot by its name.

        Raises:
            InputError: It does not exist, or its file is wrong; with every fault.
        """
        file = self.find("robot", name).path
        return load_robot(file, lambda base: self.find("robot", base, named_in=file).path)

    def load_scenario(self, name: str) -> ScenarioSpec:
        """A scenario by its name or path, whose world, robots, missions and rules exist and whose rates divide.

        Raises:
            InputError: With every fault, each at its line.
        """
        scenario = self.read_scenario(name)
        faults: list[Fault] = []
        for each in scenario.robots:
            try:
                robot = self.load_robot(each)
                self._allow(*robot.code)
                for sensor in robot.sensors:
                    scenario.rate.sensor_rate(sensor.rate, f"{each}/{sensor.name}")
            except InputError as error:
                faults += error.at(scenario.file, scenario.rate.line).faults
            else:
                faults += misfits(scenario, each, robot)
        if faults:
            raise InputError(*faults)
        self._allow(*(entry.path for entry in self.content_of(scenario)))
        return scenario

    def read_scenario(self, name: str) -> ScenarioSpec:
        """A scenario by its name or path, whose robots may be wrong or may not fit it.

        Raises:
            InputError: With every fault of the scenario's own file and of its bases, each at its line.
        """
        entry = self.find("scenario", name)
        file = entry.path
        own = read_toml(file) if entry.text is None else Table(file, self._made_scenario, (), {})
        table = merged_with_base(own, lambda base: self.find("scenario", base, named_in=file).path)
        return read_scenario(table, partial(self._missing, file))

    def content_of(self, scenario: ScenarioSpec) -> tuple[Entry, ...]:
        """Everything that a scenario uses, itself included, for `content_hash`.

        Raises:
            InputError: Something that it names does not exist.
        """
        made = self._made.get("scenario")
        own = made if made and made.path == scenario.file else make_entry(scenario.file, "scenario", "file")
        entries = [own, self.find("world", scenario.world)]
        entries += [self.find("scenario", path.stem) for path in scenario.bases]
        for name in scenario.robots:
            entries += [self.find("robot", name)]
            entries += [self.find("robot", path.parent.name) for path in self.load_robot(name).bases]
        for agent in scenario.agents:
            entries += self.content_of_controller(agent)
        entries += self.list("schema")
        return tuple(dict.fromkeys(entries))

    def content_of_controller(self, mind: AgentSpec | PlannerSpec) -> tuple[Entry, ...]:
        """What an agent's mind, or a planner, is made of: mission, rules, and what these name.

        Raises:
            InputError: Something that it names does not exist.
        """
        rules = [self.find("rules", name) for name in mind.rules]
        included = [make_entry(file, "rules", r.origin) for r in rules for file in included_files(r.path)]
        mission = self.find("mission", mind.mission)
        return mission, *self.python_of(mission, mind.parameters.values(), mind.nodes), *rules, *included

    def digest(self, scenario: ScenarioSpec) -> str:
        """The `content_hash` of everything that a scenario uses."""
        return content_hash(self.content_of(scenario))

    def cached(self, key: Hashable, make: Callable[[], T]) -> T:
        """What episodes of the same content share, such as a compiled world: here made anew for each."""
        return make()

    def load_schema(self) -> Schema:
        """What may stand in Knowledge: what we ship, and what the project's schema files add.

        Raises:
            InputError: With every fault of these files, each at its line.
        """
        files = [self.find("schema", entry.name).path for entry in self.list("schema")]
        return load_schema(files, SCHEMA) if files else SCHEMA

    def load_planner(self, name: str) -> PlannerSpec:
        """A planner by its name or path, whose mission and rules exist.

        Raises:
            InputError: With every fault, each at its line.
        """
        file = self.find("planner", name).path
        return read_planner(file, partial(self._missing, file))

    def load_mission(self, name: str, dialect: str = "") -> Callable[..., Any]:
        """The function `build` of a mission, by the mission's name or path; that of an XML file makes its tree.

        Args:
            name: The name or path; `file.py:Class` is a PythonPlanner, of a file in `planners` or of a path.
            dialect: Whose meaning the nodes of an XML file have: `nav2` for Nav2's.

        Raises:
            InputError: There is no such mission, it does not load, has no `build`, or `--no-code` forbids it.
        """
        entry = self.find("mission", name)
        if is_reference(name):
            return self.with_content(self._python_mission(entry.path, name.rpartition(":")[2]))
        if entry.path.suffix != ".py":
            return self.with_content(self._xml_mission(entry.path, dialect))
        build = getattr(self.load_python(entry), "build", None)
        if not callable(build):
            hint = "Write: def build(mission: Mission): ..."
            raise InputError(Fault("the mission has no function 'build'.", entry.path, hint=hint))
        return self.with_content(guarded(cast("Callable[..., Any]", build), entry.path))

    def with_content(self, build: Callable[..., Any]) -> Callable[..., Any]:
        """The same function, whose mission finds by name what this catalog has."""

        @wraps(build)
        def at_home(mission: Any, *args: Any, **kwargs: Any) -> Any:
            mission.content = self
            return build(mission, *args, **kwargs)

        return at_home

    def _python_planner(self, file: str) -> Entry:
        """The file of a PythonPlanner."""
        for root in filter(None, (self.project, self.shipped)):
            if not Path(file).is_absolute() and is_file(place := root / "planners" / file):
                return make_entry(place, "planner", "file")
        return self._by_path("planner", Path(file))

    def _python_mission(self, file: Path, name: str) -> Callable[..., Any]:
        from ..plan import python_mission

        return guarded(python_mission(self.load_class(file, name)), file)

    def _xml_mission(self, file: Path, dialect: str) -> Callable[..., Any]:
        from ..plan import xml_mission  # py_trees is loaded where a tree is made

        def other(name: str) -> Callable[..., Any] | None:
            return self.load_mission(name) if self.is_python_mission(name) else None

        within = self.root_of(file)
        return xml_mission(file, within=within, nodes=self.load_nodes, missions=other, dialect=dialect)

    def root_of(self, file: Path) -> Path:
        """The project that a file lies in, or ours; its folder where it lies in none."""
        place = file.resolve()
        roots = [root for root in (self.project, self.shipped) if root is not None and place.is_relative_to(root)]
        return roots[0] if roots else place.parent

    def load_nodes(self, names: Collection[str] | None = None) -> tuple[type[Any], ...]:
        """The node classes in the Python files of `planners/nodes`, those of certain names, or all.

        A file runs only where it has one of the names; a node is named like its class.

        Raises:
            InputError: A file does not load, two have a class of one name, or `--no-code` forbids it.
        """
        from ..trees.nodes import nodes_of

        entries = self._node_files(names)
        self._allow(*(entry.path for entry in entries))
        for entry in entries:
            self.confine(entry)
        classes = [node for entry in entries for node in nodes_of(load_module(entry.path))]
        return tuple(node for node in classes if names is None or node.tag in names)

    def load_route(self, name: str) -> type[Any]:
        """The route planner in a Python file of `planners/routes`, by the file's name.

        Raises:
            InputError: There is no such file, it does not load, it has not exactly one RoutePlanner, or `--no-code`
                forbids it.
        """
        from ..plan.route import RoutePlanner

        entry = self.find("route", name)
        module = self.load_python(entry)
        own = [v for v in vars(module).values() if isinstance(v, type) and v.__module__ == module.__name__]
        planners = [cls for cls in own if issubclass(cls, RoutePlanner)]
        if len(planners) != 1:
            hint = "Write one class that derives from rocs_bt.plan.RoutePlanner."
            raise InputError(Fault(f"the file has {len(planners)} route planners, not one.", entry.path, hint=hint))
        return planners[0]

    def _node_files(self, names: Collection[str] | None) -> tuple[Entry, ...]:
        """The node files that have a class of one of these names; their classes are read, not run."""
        entries = [e for e in self.list("node") if e.path.suffix == ".py"]
        return tuple(e for e in entries if names is None or set(names) & set(classes_in(e.path)))

    def is_python_mission(self, name: str) -> bool:
        """Whether a mission of that name is written in Python."""
        entry = self._entries("mission").get(name)
        return entry is not None and entry.path.suffix == ".py"

    def python_of(self, mission: Entry, values: Iterable[object] = (), dialect: str = "") -> tuple[Entry, ...]:
        """The node files, the route planners and the Python missions that a mission names.

        Args:
            mission: The mission.
            values: What it is given as parameters, which may name a route planner, too.
            dialect: Whose meaning the nodes of an XML file have.
        """
        missions: set[str] = set()
        if mission.path.suffix == ".xml":
            from ..plan.nav2 import ROUTES
            from ..plan.xml_mission import shipped_nodes, tags_of, values_of
            from ..trees.xml import outer_trees, read_document

            document = read_document(mission.path, within=self.root_of(mission.path))
            tags, texts = tags_of(document) - set(shipped_nodes(dialect)), values_of(document)
            texts |= set(ROUTES if dialect else ())
            missions = {name for name in outer_trees(document) if self.is_python_mission(name)}
        else:
            tags = texts = texts_in(mission.path)
        named = texts | {value for value in values if isinstance(value, str)}
        routes = [entry for entry in self.list("route") if entry.name in named]
        return (*self._node_files(tags), *routes, *(self.find("mission", name) for name in sorted(missions)))

    def load_python(self, entry: Entry) -> ModuleType:
        """The module of a Python content file; run once in a process.

        Raises:
            InputError: It is not Python, does not load, or `--no-code` forbids it.
        """
        self._allow(entry.path)
        self.confine(entry)
        return load_module(entry.path)

    def load_class(self, path: Path, name: str) -> type:
        """A class of a Python file, as robot.toml names it by `file.py:Class`.

        Raises:
            InputError: The file does not load or lacks the class, or `--no-code` forbids it.
        """
        self._allow(path)
        return load_class(path, name)

    def _allow(self, *paths: Path) -> None:
        """Refuse the Python files among these where no code may run."""
        code = [path for path in paths if path.suffix == ".py"]
        if code and not self.code:
            hint = "Leave --no-code out if you trust it."
            message = "this Python content may not run: --no-code was given."
            raise InputError(*(Fault(message, p, hint=hint) for p in code))

    def _missing(self, file: Path, kind: str, name: str) -> Fault | None:
        """Why a name cannot be used in a file; None when it can."""
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
            raise UnknownName(unknown(_SPOKEN.get(kind, f"{kind} file"), str(path), self._entries(kind)))
        return make_entry(path.resolve(), kind, "file")


def misfits(scenario: ScenarioSpec, name: str, robot: RobotSpec) -> Iterator[Fault]:
    """What keeps a robot from being an agent of a scenario, each fault in the file that has to change.

    An agent, its devices and the places that it is told of are nodes of one graph, so they cannot share a name; and
    its actuators must wait for a command as long as the scenario's control period is.

    Args:
        scenario: The scenario.
        name: What it calls the robot.
        robot: The robot.
    """
    agents = [agent for agent in scenario.agents if agent.robot == name]
    devices = {d.name: kind for kind, of in (("sensor", robot.sensors), ("actuator", robot.actuators)) for d in of}
    named = [(agent.name, agent.line) for agent in agents]
    told = {agent.name for agent in agents}
    named += [(place.name, place.line) for place in scenario.places if told.intersection(place.agents)]
    for taken, line in named:
        if taken in devices:
            message = f"the name '{taken}' is taken by the {devices[taken]} '{taken}' of {robot.name}."
            yield Fault(message, scenario.file, line, hint="Choose another name.")
    period = scenario.rate.control_rate.period
    for actuator in robot.actuators if agents else ():
        if actuator.max_command_age < period - 1e-9:
            yield Fault(
                f"the actuator '{actuator.name}' goes to neutral {actuator.max_command_age:g} s after a command, but "
                f"{scenario.name} commands it only every {period:g} s.",
                robot.file,
                actuator.line,
                hint=f'Write max_command_age = "{4.0 * period:g} s", or a faster control rate.',
            )


LIMIT = 64
"""How many things are kept; what was not used for longest is let go."""


class CachingCatalog(Catalog):
    """A catalog that keeps what it has read and what was made of it. Files must not change while it is in use.

    Args:
        project: The project's root; None for shipped content only.
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

    def load_mission(self, name: str, dialect: str = "") -> Callable[..., Any]:
        key = "mission", name, dialect
        return self.cached(key, lambda: super(CachingCatalog, self).load_mission(name, dialect))

    def content_of_controller(self, mind: AgentSpec | PlannerSpec) -> tuple[Entry, ...]:
        key = "mind", mind.mission, mind.rules, repr(mind.parameters), mind.nodes
        return self.cached(key, lambda: super(CachingCatalog, self).content_of_controller(mind))

    def digest(self, scenario: ScenarioSpec) -> str:
        minds = tuple((a.name, a.mission, a.rules, repr(a.parameters), a.nodes) for a in scenario.agents)
        made = self._made.get("scenario"), self._made.get("world")
        return self.cached(("digest", scenario.file, made, minds), lambda: super(CachingCatalog, self).digest(scenario))
