"""One thing in a content folder: a robot, a rule file, a mission ... and where each kind stands."""

from __future__ import annotations

import ast
import hashlib
import re
import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from ..confine import confined, is_file
from ..errors import Fault, InputError, RocsError
from ..python_content import is_reference
from ..toml_text import parse_toml

# Where each kind stands in a project, in the order in which people read of them.
KINDS: dict[str, tuple[str, ...]] = {
    "scenario": ("scenarios/*.toml",),
    "mission": ("planners/missions/*.py", "planners/missions/*.xml"),
    "rules": ("rules/*.toml",),
    "robot": ("robots/*/robot.toml",),
    "world": ("scenarios/worlds/*.xml",),
    "schema": ("scenarios/schema/*.toml",),
    "family": ("scenarios/families/*.py",),
    "route": ("planners/routes/*.py",),
    "node": ("planners/nodes/*.py",),
    "planner": ("planners/*.toml",),
}

_XML_FILE = re.compile(r"""\b(?:file|path)\s*=\s*["']([^"']+)["']""")


@dataclass(frozen=True)
class Entry:
    """One piece of content.

    Attributes:
        name: What people call it: the file's stem, for a robot its folder's name.
        kind: One of `KINDS`.
        path: Its file; a robot's is `robot.toml`.
        origin: `project`, `shipped`, or `file` where it was named by its path.
        text: Content of an entry that a program made and no file has; None for a file's.
        outside: Whether a link leads out of the project; such an entry is listed and never read.
    """

    name: str
    kind: str
    path: Path
    origin: str = "project"
    text: str | None = None
    outside: bool = False

    @property
    def doc(self) -> str:
        """One sentence: TOML's `doc`, Python's docstring, XML's first comment; empty where there is none."""
        return "" if self.outside or self.text is not None else doc_of(self.path)

    def contents(self) -> Iterator[tuple[str, bytes]]:
        """Relative path and bytes of each of its files, sorted."""
        if self.text is not None:
            yield self.path.name, self.text.encode()
            return
        for file in self.files():
            inside = file.is_relative_to(self.path.parent)
            yield file.relative_to(self.path.parent).as_posix() if inside else file.name, file.read_bytes()

    def files(self) -> list[Path]:
        """Every file that it is made of, sorted: a robot is its folder, an XML file what it refers to as well."""
        if self.kind == "robot":
            return sorted(p for p in self.path.parent.rglob("*") if p.is_file() and "__pycache__" not in p.parts)
        if self.path.suffix == ".xml":
            return sorted(_with_references(self.path, set()))
        return [self.path]


def scan(root: Path, kind: str, origin: str) -> Iterator[Entry]:
    """The entries of one kind in a project's folders, sorted by name; runs no code."""
    inside = root.resolve()
    for pattern in KINDS[kind]:
        for path in sorted(root.glob(pattern)):
            if not path.name.startswith(("_", ".")) and path.is_file():
                if origin == "project" and not path.resolve().is_relative_to(inside):
                    yield Entry(name_of(path, kind), kind, path, origin, outside=True)  # refused when used
                else:
                    yield make_entry(path, kind, origin)


def make_entry(path: Path, kind: str, origin: str) -> Entry:
    """The entry of a file."""
    return Entry(name_of(path, kind), kind, path, origin)


def name_of(path: Path, kind: str) -> str:
    """The name of the entry of a file."""
    return path.parent.name if kind == "robot" else path.stem


def kind_of(path: Path) -> str | None:
    """The kind that a file's place in a project tells; None for a file that is no content."""
    for kind, patterns in KINDS.items():
        if any(path.match(pattern) for pattern in patterns):
            return kind
    return None


def doc_of(path: Path) -> str:
    """The one-sentence description that a content file carries; empty where it has none or is broken."""
    try:
        text = path.read_text(encoding="utf-8")
        if path.suffix == ".toml":
            doc = parse_toml(text, path)[0].get("doc", "")
        elif path.suffix == ".py":
            doc = ast.get_docstring(ast.parse(text)) or ""
        else:
            begin = text.find("<!--")
            end = text.find("-->", begin + 4)
            doc = text[begin + 4 : end].strip() if 0 <= begin < end else ""
    except (OSError, ValueError, SyntaxError, RecursionError, MemoryError, InputError):
        return ""
    return str(doc).strip().split("\n", 1)[0].strip()


def by_name(entries: Iterable[Entry]) -> dict[str, Entry]:
    """Entries of one kind by name.

    Raises:
        InputError: Two have the same name.
    """
    found: dict[str, Entry] = {}
    for entry in entries:
        if entry.name in found:
            message = f"two {entry.kind} files are named '{entry.name}'; the other is {found[entry.name].path}."
            raise InputError(Fault(message, entry.path))
        found[entry.name] = entry
    return found


def content_hash(entries: Iterable[Entry]) -> str:
    """sha256 over all files of some content: kind, name, relative path and bytes; the same on every machine."""
    digest = hashlib.sha256()
    for entry in sorted(set(entries), key=lambda e: (e.kind, e.name)):
        for place, data in entry.contents():
            digest.update(f"{entry.kind}\0{entry.name}\0{place}\0{len(data)}\0".encode())
            digest.update(data)
    return digest.hexdigest()


def _with_references(path: Path, seen: set[Path]) -> set[Path]:
    """An XML file and the files that it names, and theirs."""
    path = path.resolve()
    if path in seen or not is_file(path):
        return seen
    seen.add(path)
    if path.suffix == ".xml":
        for name in _XML_FILE.findall(path.read_text(encoding="utf-8", errors="replace")):
            _with_references(path.parent / name, seen)
    return seen


def shipped_root() -> Path:
    """The folder that holds the content we ship: inside a wheel's package, or a checkout's root.

    Raises:
        RocsError: This installation has no content.
    """
    package = Path(__file__).resolve().parent.parent
    if (inside := package / "_content").is_dir():
        return inside
    # Never trust what lies beside the package before its pyproject says that this is our checkout.
    pyproject = package.parent / "pyproject.toml"
    if pyproject.is_file() and tomllib.loads(pyproject.read_text("utf-8")).get("project", {}).get("name") == "rocs_bt":
        return package.parent
    raise RocsError(f"no content was found in {inside}, and {package.parent} is no checkout. Install rocs_bt again.")


def find_project(start: Path) -> Path | None:
    """The nearest folder, from `start` upwards, that has content of its own; None where there is none."""
    start = start.resolve()
    for folder in (start, *start.parents):
        if any(next(folder.glob(pattern), None) for patterns in KINDS.values() for pattern in patterns):
            return folder
    return None


def is_path(name: str) -> bool:
    """Whether a person means a file by this rather than a name."""
    return "/" in name or name.endswith((".toml", ".xml", ".py"))


def confine_name(name: str, roots: tuple[Path, ...], own: Path) -> None:
    """Refuse the path of other content in a content file, unless it is inside the project.

    Args:
        name: A path, or `file.py:Class`, which is looked for in the folders' `planners` first.
        roots: The folders whose content may be named.
        own: The folder of the project of the naming file.

    Raises:
        InputError: It is outside.
    """
    path = name.partition(":")[0]
    if is_reference(name) and not Path(path).is_absolute():
        for root in roots:
            if is_file(root / "planners" / path):
                confined(path, root / "planners", (root,))
                return
    confined(path, Path(), (*roots, own))
