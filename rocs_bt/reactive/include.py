"""Rule files that include other rule files: `include = ["common.toml"]`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..base.errors import InputError
from ..base.files import confined, is_file, read_text
from ..base.toml_table import Table, read_toml
from ..declare import read
from .rule_keys import RuleFile

MAX_FILES = 50


@dataclass(frozen=True)
class RuleDocument:
    """One file of a rule set, as read.

    Attributes:
        table: Root table of the file.
        keys: Its keys; their faults are in the table.
        lines: Lines of the file; empty if its text is not available.
    """

    table: Table
    keys: RuleFile
    lines: list[str]


def read_documents(file: Path | Table) -> list[RuleDocument]:
    """Read a rule file and its included files, each once; included files come first.

    Paths in `include` are relative to the including file and must lie in the same project. Faults of an `include` are
    recorded in the table that contains it.

    Raises:
        InputError: `file` itself cannot be read.
    """
    top = file if isinstance(file, Table) else read_toml(file)
    found: dict[Path, RuleDocument] = {}
    _gather(top, [], found, project_of(top.file))
    return list(found.values())


def included_files(file: Path) -> list[Path]:
    """Paths of the files that a rule file includes, directly or indirectly; files that cannot be read are left out."""
    try:
        documents = read_documents(file)
    except InputError:
        return []
    return [document.table.file for document in documents[:-1]]


def project_of(file: Path) -> Path:
    """Folder in which all included files must lie: PROJECT for a file in `PROJECT/rules/`, else the file's folder."""
    folder = file.resolve().parent
    return folder.parent if folder.name == "rules" else folder


def _gather(table: Table, above: list[Path], found: dict[Path, RuleDocument], project: Path) -> None:
    path = table.file.resolve()
    chain, keys = [*above, path], read(RuleFile, table)
    for named in keys.include:
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
    found[path] = RuleDocument(table, keys, _lines(table.file))


def _include(table: Table, target: Path, chain: list[Path], found: dict[Path, RuleDocument], project: Path) -> None:
    if len(chain) + len(found) >= MAX_FILES:
        table.fault("include", f"a rule file can consist of at most {MAX_FILES} files.")
        return
    try:
        included = read_toml(target)
    except InputError as error:
        if is_file(target):
            table.faults.extend(error.faults)
        else:
            table.fault("include", f"no file '{target}' to include.", "Give its path relative to this file.")
        return
    _gather(included, chain, found, project)


def _lines(path: Path) -> list[str]:
    try:
        return read_text(path).splitlines()
    except InputError:
        return []
