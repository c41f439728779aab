"""Kinds of content, `KINDS`: one row each; and the entries of the content folders: names, files and hashes."""

from __future__ import annotations

import ast
import hashlib
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, cast

from ..base.errors import Fault, InputError, RocsError
from ..base.files import MOST_TEXT, confined, is_file, read_bytes, read_text
from ..base.python_content import is_reference, with_siblings
from ..base.toml_text import parse_toml


@dataclass(frozen=True)
class ContentKind:
    """Kind of content.

    Attributes:
        patterns: Patterns of the paths in a project.
        table: Declared class of the files, as `module:Class`; empty for Python and XML.
    """

    patterns: tuple[str, ...]
    table: str = ""

    @property
    def cls(self) -> type[Any]:
        """Declared class of the files."""
        module, _, name = self.table.partition(":")
        return cast("type[Any]", getattr(import_module(module), name))


KINDS: Mapping[str, ContentKind] = {
    "scenario": ContentKind(("scenarios/*.toml",), "rocs_bt.catalog.scenario_file:ScenarioSpec"),
    "mission": ContentKind(("planners/missions/*.py", "planners/missions/*.xml")),
    "rules": ContentKind(("rules/*.toml",), "rocs_bt.reactive.rule_keys:RuleFile"),
    "robot": ContentKind(("robots/*/robot.toml",), "rocs_bt.catalog.robot_spec:RobotSpec"),
    "world": ContentKind(("scenarios/worlds/*.xml",)),
    "schema": ContentKind(("scenarios/schema/*.toml",), "rocs_bt.knowledge.schema.files:SchemaFile"),
    "family": ContentKind(("scenarios/families/*.py",)),
    "route": ContentKind(("planners/routes/*.py",)),
    "node": ContentKind(("planners/nodes/*.py",)),
    "planner": ContentKind(("planners/*.toml",), "rocs_bt.catalog.planner_file:PlannerSpec"),
    "perturbations": ContentKind(("robots/perturbations.toml",), "rocs_bt.catalog.perturbation:PerturbationFile"),
}
"""Kinds of content, in the order of `rocs-bt list`. A kind needs no more than its row and its class: a file of a kind
without checks of its own is checked by its class."""

PATTERNS = tuple(pattern for kind in KINDS.values() for pattern in kind.patterns)
"""Patterns of all content in a project."""

TREES = (".xml", ".btproj")
"""Suffixes of files with trees in XML: documents, and projects of Groot2, which include documents."""

IDENTIFIED = "identified.toml"
"""Name of the file in a robot's folder with its measured parameters, which no run reads."""

_XML_FILE = re.compile(r"""\b(?:file|path)\s*=\s*["']([^"']+)["']""")


@dataclass(frozen=True)
class Entry:
    """One piece of content, such as a robot, a mission or a scenario.

    Attributes:
        name: File stem; for a robot, the folder's name.
        kind: One of `KINDS`.
        path: File of the entry; `robot.toml` for a robot.
        origin: `project`, `shipped`, or `file` for an entry given by its path.
        text: Text of an entry made by a program without a file; None for entries with a file.
        outside: Whether the path is a link that leads out of the project; such an entry is listed but never read.
    """

    name: str
    kind: str
    path: Path
    origin: str = "project"
    text: str | None = None
    outside: bool = False

    @property
    def doc(self) -> str:
        """One-sentence description: TOML's `doc`, Python's docstring or XML's first comment; empty if missing."""
        return "" if self.outside or self.text is not None else doc_of(self.path)

    def contents(self) -> Iterator[tuple[str, bytes]]:
        """Relative path and bytes of each file of the entry, sorted."""
        if self.text is not None:
            yield self.path.name, self.text.encode()
            return
        for file in self.files():
            inside = file.is_relative_to(self.path.parent)
            yield file.relative_to(self.path.parent).as_posix() if inside else file.name, read_bytes(file)

    def files(self) -> list[Path]:
        """Files of the entry that runs depend on, sorted.

        They are a robot's whole folder except identified.toml; an XML or Python file and what it references.
        """
        if self.kind == "robot":
            folder = self.path.parent
            kept = (p for p in folder.rglob("*") if "__pycache__" not in p.parts and p != folder / IDENTIFIED)
            return sorted(p for p in kept if p.is_file())
        if self.path.suffix in TREES:
            return sorted(_with_references(self.path, set()))
        if self.path.suffix == ".py":
            return sorted(with_siblings(self.path))
        return [self.path]


def scan(root: Path, kind: str, origin: str) -> Iterator[Entry]:
    """Entries of one kind in a project's folders, sorted by name; runs no code."""
    inside = root.resolve()
    for pattern in KINDS[kind].patterns:
        for path in sorted(root.glob(pattern)):
            if not path.name.startswith(("_", ".")) and is_file(path):
                if origin == "project" and not path.resolve().is_relative_to(inside):
                    yield Entry(name_of(path, kind), kind, path, origin, outside=True)  # refused when used
                else:
                    yield make_entry(path, kind, origin)


def make_entry(path: Path, kind: str, origin: str) -> Entry:
    """Entry of a file."""
    return Entry(name_of(path, kind), kind, path, origin)


def name_of(path: Path, kind: str) -> str:
    """Name of a file's entry."""
    return path.parent.name if kind == "robot" else path.stem


def kind_of(path: Path) -> str | None:
    """Kind of content of a file, by its folder in a project; None for a file that is not content."""
    return next((kind for kind, of in KINDS.items() if any(map(path.match, of.patterns))), None)


def doc_of(path: Path) -> str:
    """One-sentence description in a content file; empty if it has none or cannot be parsed."""
    try:
        text = read_text(path)
        if path.suffix == ".toml":
            doc = parse_toml(text, path)[0].get("doc", "")
        elif path.suffix == ".py":
            doc = ast.get_docstring(ast.parse(text)) or ""
        else:
            begin = text.find("<!--")
            end = text.find("-->", begin + 4)
            doc = text[begin + 4 : end].strip() if 0 <= begin < end else ""
    except (ValueError, SyntaxError, RecursionError, MemoryError, InputError):
        return ""
    return str(doc).strip().split("\n", 1)[0].strip()


def by_name(entries: Iterable[Entry]) -> dict[str, Entry]:
    """Entries of one kind by name.

    Raises:
        InputError: Two entries have the same name.
    """
    found: dict[str, Entry] = {}
    for entry in entries:
        if entry.name in found:
            message = f"two {entry.kind} files are named '{entry.name}'; the other is {found[entry.name].path}."
            raise InputError(Fault(message, entry.path))
        found[entry.name] = entry
    return found


def content_hash(entries: Iterable[Entry]) -> str:
    """SHA-256 over kind, name, relative path and bytes of all files of the entries; equal on every machine."""
    digest = hashlib.sha256()
    for entry in sorted(set(entries), key=lambda e: (e.kind, e.name)):
        for path, data in entry.contents():
            digest.update(f"{entry.kind}\0{entry.name}\0{path}\0{len(data)}\0".encode())
            digest.update(data)
    return digest.hexdigest()


def _with_references(path: Path, seen: set[Path]) -> set[Path]:
    """An XML file and all files that it references, recursively."""
    path = path.resolve()
    if path in seen or not is_file(path):
        return seen
    seen.add(path)
    if path.suffix in TREES:
        for name in _XML_FILE.findall(read_bytes(path, MOST_TEXT).decode("utf-8", "replace")):
            _with_references(path.parent / name, seen)
    return seen


def shipped_root() -> Path:
    """Folder of the shipped content: `_content` in an installed package, or the root of a checkout.

    Raises:
        RocsError: This installation has no content.
    """
    package = Path(__file__).resolve().parent.parent
    if (inside := package / "_content").is_dir():
        return inside
    # The folder around the package is trusted only if its pyproject.toml is that of rocs_bt.
    pyproject = package.parent / "pyproject.toml"
    if pyproject.is_file() and tomllib.loads(read_text(pyproject)).get("project", {}).get("name") == "rocs_bt":
        return package.parent
    raise RocsError(f"no content found in {inside}, and {package.parent} is no rocs_bt checkout. Reinstall rocs_bt.")


def find_project(start: Path) -> Path | None:
    """Nearest folder with content, from `start` upwards; None if there is none."""
    start = start.resolve()
    for folder in (start, *start.parents):
        if any(next(folder.glob(pattern), None) for pattern in PATTERNS):
            return folder
    return None


def is_path(name: str) -> bool:
    """Whether a text denotes a file rather than a name of content."""
    return "/" in name or name.endswith((".toml", ".py", *TREES))


def confine_name(name: str, roots: tuple[Path, ...], own: Path) -> None:
    """Refuse a path in a content file that leads out of the project.

    Raises:
        InputError: The path is outside the project.
    """
    path = name.partition(":")[0]
    if is_reference(name) and not Path(path).is_absolute():
        for root in roots:
            if is_file(root / "planners" / path):
                confined(path, root / "planners", (root,))
                return
    confined(path, Path(), (*roots, own))
