"""Finder: content by kind and name, the user's project first, then the shipped content (docs/architecture.md)."""

from __future__ import annotations

import copy
import functools
import os
from collections.abc import Callable, Hashable, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any, Self, TypeVar, cast

from ..base.errors import Fault, InputError, UnknownName, unknown
from ..base.files import confined, is_file
from ..base.python_content import is_reference, load_class, load_module
from ..base.toml_text import as_data, as_toml
from .content_kinds import KINDS, Entry, by_name, confine_name, find_project, is_path, make_entry, scan, shipped_root

F = TypeVar("F", bound=Callable[..., Any])
T = TypeVar("T")

_SINGULAR = {"rules": "rule file"}  # kinds with a plural name


def kept(key: Callable[..., tuple[Hashable, ...]]) -> Callable[[F], F]:
    """Mark of a method with results that a `CachingCatalog` keeps; `key` makes their key of the arguments."""

    def decorate(make: F) -> F:
        @functools.wraps(make)
        def method(self: Finder, *args: Any, **given: Any) -> Any:
            return self.cached((make.__name__, *key(self, *args, **given)), lambda: make(self, *args, **given))

        return cast("F", method)

    return decorate


class Finder:
    """Files with content of a project and of rocs_bt, by kind and name.

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

    def cached(self, key: Hashable, make: Callable[[], T]) -> T:
        """Result of `make`, such as a compiled world; a `CachingCatalog` makes it only once for each key."""
        return make()

    @property
    def made(self) -> tuple[Entry, ...]:
        """Scenario and world made by a program; empty if there are none."""
        return tuple(self._made.values())

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

    def root_of(self, file: Path) -> Path:
        """Project root or shipped root that contains a file; else the file's folder."""
        path = file.resolve()
        roots = [root for root in (self.project, self.shipped) if root is not None and path.is_relative_to(root)]
        return roots[0] if roots else path.parent

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

    def _python_planner(self, file: str) -> Entry:
        """Entry of a PythonPlanner's file."""
        for root in filter(None, (self.project, self.shipped)):
            if not Path(file).is_absolute() and is_file(path := root / "planners" / file):
                return make_entry(path, "planner", "file")
        return self._by_path("planner", Path(file))

    def _by_path(self, kind: str, path: Path) -> Entry:
        if kind == "robot" and os.path.isdir(path):
            path /= "robot.toml"
        if not is_file(path):
            raise UnknownName(unknown(_SINGULAR.get(kind, f"{kind} file"), str(path), self._entries(kind)))
        return make_entry(path.resolve(), kind, "file")
