"""Rule files that include others: `include = ["common.toml"]`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..confine import confined, is_file
from ..document import Table, read_toml
from ..errors import InputError

MAX_FILES = 50


@dataclass(frozen=True)
class Document:
    """One of the files that make a rule set.

    Attributes:
        table: Its root.
        lines: Its lines; empty where its text is not at hand.
    """

    table: Table
    lines: list[str]


def read_documents(file: Path | Table) -> list[Document]:
    """A rule file and all that it includes, each once; what is included stands before what includes it.

    An included file is named by its path from the one that includes it, and lies in the same project. What is wrong
    with an `include` is noted where it stands.

    Raises:
        InputError: The file itself cannot be read.
    """
    top = file if isinstance(file, Table) else read_toml(file)
    found: dict[Path, Document] = {}
    _gather(top, [], found, project_of(top.file))
    return list(found.values())


def included_files(file: Path) -> list[Path]:
    """The files that a rule file includes, directly or not, without itself; as many as can be read."""
    try:
        documents = read_documents(file)
    except InputError:
        return []
    return [document.table.file for document in documents[:-1]]


def project_of(file: Path) -> Path:
    """The folder that nothing may be included from outside of: the project, where the file stands in its `rules/`."""
    folder = file.resolve().parent
    return folder.parent if folder.name == "rules" else folder


def _gather(table: Table, above: list[Path], found: dict[Path, Document], project: Path) -> None:
    path = table.file.resolve()
    chain = [*above, path]
    for named in table.texts("include", []):
        target = table.file.parent / named
        try:
            resolved = confined(named, table.file.resolve().parent, (project,))
        except InputError as error:
            table.adopt("include", error)
            continue
        if resolved in chain:
            names = [p.name for p in chain[chain.index(resolved) :]]
            table.fault("include", f"the files include each other: {' -> '.join([*names, resolved.name])}.")
        elif resolved not in found:
            _include(table, target, chain, found, project)
    found[path] = Document(table, _lines(table.file))


def _include(table: Table, target: Path, chain: list[Path], found: dict[Path, Document], project: Path) -> None:
    if len(chain) + len(found) >= MAX_FILES:
        table.fault("include", f"a rule file is made of at most {MAX_FILES} files.")
        return
    try:
        included = read_toml(target)
    except InputError as error:
        if is_file(target):
            table.faults.extend(error.faults)
        else:
            table.fault("include", f"there is no file '{target}' to include.", "Give its path from this file.")
        return
    _gather(included, chain, found, project)


def _lines(path: Path) -> list[str]:
    try:
        return path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError, ValueError):
        return []
