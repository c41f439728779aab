"""MissionCatalog: missions, and the nodes, route planners and trees that they name."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from functools import wraps
from pathlib import Path
from typing import Any, cast

from ..base.errors import Fault, InputError
from ..base.files import is_file
from ..base.python_content import classes_in, guarded, is_reference, load_module, texts_in
from ..interfaces.vocabulary import vocabulary_of
from .content_kinds import TREES, Entry, make_entry
from .finder import Finder, kept

_FAMILY = "rocs_bt.compare.family.Family"
"""Base class of families; by name, because catalogs do not import comparisons."""


class MissionCatalog(Finder):
    """Finder that also loads missions, and what they name."""

    @kept(lambda self, name, dialect="": (name, dialect))
    def load_mission(self, name: str, dialect: str = "") -> Callable[..., Any]:
        """Load the function `build` of a mission; for an XML mission, a function that makes its tree.

        Args:
            name: Name or path; or `file.py:Class` for a PythonPlanner, a path or relative to `planners`.
            dialect: Dialect of the nodes in XML, one of `dialects`; empty to recognise it.

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

    def load_nodes(self, names: Collection[str] | None = None) -> tuple[type[Any], ...]:
        """Load the node classes in the Python files of `planners/nodes`: all, or those with the given names.

        A node has the name of its class. Only files that define one of the names are run.

        Raises:
            InputError: A file does not load, two classes have the same name, a leaf with one of the names has no
                `update`, or `--no-code` forbids it.
        """
        from ..trees.nodes import nodes_of

        entries = self._node_files(names)
        self._allow(*(entry.path for entry in entries))
        for entry in entries:
            self.confine(entry)
        found = [(node, entry.path) for entry in entries for node in nodes_of(load_module(entry.path))]
        classes = [(node, path) for node, path in found if names is None or node.tag in names]
        if names and (faults := [*_faults_of_nodes(classes)]):
            raise InputError(*faults)
        return tuple(node for node, _ in classes)

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

    def load_family(self, entry: Entry) -> type[Any]:
        """Load the class of a family, which has the name of its file in CamelCase.

        Raises:
            InputError: The file does not load or lacks the class, the class is no Family, or `--no-code` forbids it.
        """
        self.confine(entry)
        camel = "".join(part.capitalize() for part in entry.name.split("_"))
        cls = self.load_class(entry.path, camel)
        if _FAMILY not in (f"{base.__module__}.{base.__name__}" for base in cls.__mro__[1:]):
            hint = f"Write: class {camel}(Family)."
            raise InputError(Fault(f"'{camel}' must be a class derived from Family.", entry.path, hint=hint))
        return cls

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
            from ..plan.dialects import dialect_in, shipped_nodes, tags_of
            from ..plan.xml_mission import values_of
            from ..trees.xml import add_siblings, outer_trees, read_document

            document = read_document(mission.path, within=self.root_of(mission.path))
            add_siblings(document, self.tree_files())
            dialect = dialect_in(document, dialect, self.defined_nodes)
            tags, texts = tags_of(document) - set(shipped_nodes(dialect)), values_of(document)
            words, _ = vocabulary_of(dialect)
            texts |= set(() if words is None else words.routes)
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
        from ..plan.dialects import tags_of
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


def _faults_of_nodes(nodes: Sequence[tuple[type[Any], Path]]) -> Iterator[Fault]:
    """Faults of node classes, each with its file; a leaf that another of the nodes extends needs no `update`."""
    from ..trees.nodes import Leaf, Node

    extended = {base for node, _ in nodes for base in node.__mro__[1:]}
    for node, path in nodes:
        line = classes_in(path).get(node.__name__, 0)
        if hasattr(node, "__dataclass_fields__"):
            hint = "Remove the decorator: the annotations declare the ports."
            yield Fault(f"the node {node.__name__} is a dataclass.", path, line, hint=hint)
        elif issubclass(node, Leaf) and node.update is Node.update and node not in extended:
            hint = "Write: def update(self): return SUCCESS."
            yield Fault(f"the leaf {node.__name__} has no method 'update'.", path, line, hint=hint)
