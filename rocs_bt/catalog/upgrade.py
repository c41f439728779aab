"""Upgrade of content files of old formats: the format line, renamed and moved keys, and nothing else."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..document import Table
from ..errors import Fault, InputError
from ..files import MOST_TEXT, is_file, read_bytes, read_text
from ..toml_edit import Edit, edited
from ..toml_text import Key, key_parts, parse_toml
from .catalog import Catalog
from .entry import find_project, kind_of
from .inherit import FindBase, merged_data
from .renamed_keys import FORMATS, Format, foreign_keys, moved_keys, old_keys

_FORMAT = re.compile(rf"""^\s*["']?format["']?\s*=\s*["']+\s*({"|".join(FORMATS)})["']""", re.MULTILINE)
_BASE = re.compile(r"^\s*base\s*=", re.MULTILINE)
_SKIPPED = ("__pycache__", "node_modules", "site-packages")


@dataclass(frozen=True)
class KeyChange:
    """Changed key or format in one line.

    Attributes:
        line: 1-based line.
        old: Old key or format.
        new: New key or format.
    """

    line: int
    old: str
    new: str


@dataclass(frozen=True)
class Upgrade:
    """Upgrade of one file.

    Attributes:
        file: The file.
        changes: Changes, in the order of the file; empty if it is up to date or cannot be upgraded.
        text: New text; empty without changes.
        notes: Warnings about keys of the project's own classes, which stay as they are.
        error: Reason why the file cannot be upgraded; None if it can.
    """

    file: Path
    changes: tuple[KeyChange, ...] = ()
    text: str = ""
    notes: tuple[Fault, ...] = ()
    error: InputError | None = None


def upgrades(path: Path) -> Iterator[Upgrade]:
    """Upgrades of a file, or of all robots and scenarios in a folder; writes nothing.

    Args:
        path: File or folder.

    Raises:
        InputError: There is no such file or folder.
    """
    if not path.exists():
        raise InputError(Fault(f"there is no file or folder '{path}'."))
    project = find_project(path if path.is_dir() else path.parent)
    catalog = Catalog(project)
    for file in _content_in(path) if path.is_dir() else [path]:
        try:
            yield _upgrade(file, read_text(file, raw=True), catalog)
        except InputError as error:
            yield Upgrade(file, error=error.at(file))


def upgraded(text: str, file: Path, find: FindBase) -> Upgrade:
    """Upgrade the text of a robot.toml or a scenario.

    Args:
        text: Text of the file.
        file: The file.
        find: Finds the file of a `base` by its name.

    Raises:
        InputError: The file cannot be upgraded: it is not valid TOML or of another format, its base does not exist,
            or a table has both the old and the new name of a key.
    """
    data, positions = parse_toml(text, file)
    own = Table(file, data, (), positions)
    form, bases, base = _inherited(own, find, ())
    if form is None:
        known = ", ".join(f"'{name}'" for name in FORMATS)
        raise InputError(Fault("the file has no format that can be upgraded.", file, hint=f"Formats: {known}."))
    renamed = dict(old_keys(data, form, (file, *bases), base))
    _refuse_both(renamed, own)
    edits = [
        (Edit(part.start, part.end, renamed[part.key]), str(part.key[-1]))
        for part in key_parts(text)
        if part.key in renamed
    ]
    if (found := data.get("format")) in form.old:
        end = next((part.end for part in key_parts(text) if part.key == ("format",)), len(text))
        start = text.find(found, end)
        if start < 0:  # written with an escape
            raise _not_by_names(file)
        edits.append((Edit(start, start + len(found), form.name), found))
    edits.sort()
    new, expected = edited(text, [edit for edit, _ in edits]), _renamed(data, renamed, ())
    if "format" in expected:
        expected["format"] = form.name
    if parse_toml(new, file)[0] != expected:
        raise _not_by_names(file)
    changes = [KeyChange(text.count("\n", 0, edit.start) + 1, old, edit.new) for edit, old in edits]
    moves = list(moved_keys(expected, form, base))
    new, moved = _moved(new, expected, moves, file)
    changes = sorted([*changes, *moved], key=lambda change: change.line)
    notes = tuple(
        Fault(f"'{key[-1]}' belongs to your own '{owner}' and stays.", file, *own.position_of(key), warning=True)
        for key, owner in foreign_keys(data, form, (file, *bases))
    )
    return Upgrade(file, tuple(changes), new if changes else "", notes)


def _not_by_names(file: Path) -> InputError:
    return InputError(Fault("the file cannot be rewritten by names alone.", file, hint="Rename its keys by hand."))


def _upgrade(file: Path, text: str, catalog: Catalog) -> Upgrade:
    def find(base: str) -> Path:
        kind = "robot" if file.name == "robot.toml" else "scenario"
        return catalog.find(kind, base, named_in=file).path

    return upgraded(text, file, find)


def _content_in(folder: Path) -> Iterator[Path]:
    """TOML files in a folder with a format of `FORMATS`; hidden folders and links out of the folder are skipped."""
    root, seen = folder.resolve(), set[Path]()
    for file in sorted(folder.rglob("*.toml")):
        parts = file.relative_to(folder).parts
        if any(part.startswith(".") or part in _SKIPPED for part in parts):
            continue
        if is_file(file) and (target := file.resolve()).is_relative_to(root) and target not in seen:
            seen.add(target)
            try:
                text = read_bytes(file, MOST_TEXT).decode("utf-8", "replace")
            except OSError:  # reported when it is read again
                yield file
                continue
            inherits = _BASE.search(text) is not None and kind_of(file) in ("robot", "scenario")
            if _FORMAT.search(text) or inherits:  # a format may be inherited
                yield file


def _inherited(
    own: Table, find: FindBase, readers: tuple[Path, ...]
) -> tuple[Format | None, tuple[Path, ...], dict[str, Any]]:
    """Format of a document, the files of its bases, and their merged content with present names."""
    form, name = FORMATS.get(str(own.data.get("format"))), own.data.get("base")
    if not isinstance(name, str):
        return form, (), {}
    try:
        path = find(name)
        if path.resolve() in (*readers, own.file.resolve()):
            raise InputError(f"cyclic inheritance: '{name}' is itself based on this file. Remove one 'base'.")
        data, positions = parse_toml(read_text(path, raw=True), path)
        base = Table(path, data, (), positions)
        inherited, bases, further = _inherited(base, find, (*readers, own.file.resolve()))
    except InputError as error:
        raise error.at(own.file, *own.position("base")) from error
    if inherited is not None:
        data = _renamed(data, dict(old_keys(data, inherited, (path, *bases), further)), ())
    return form or inherited, (path, *bases), merged_data(data, further)


def _refuse_both(renamed: Mapping[Key, str], own: Table) -> None:
    faults = []
    for key, new in renamed.items():
        row: Any = own.data
        for part in key[:-1]:
            row = row[part]
        if new in row:
            message = f"'{key[-1]}' is the old name of '{new}', and the table has both."
            faults.append(Fault(message, own.file, *own.position_of(key), hint="Remove one of them."))
    if faults:
        raise InputError(*faults)


def _renamed(value: Any, renamed: Mapping[Key, str], key: Key) -> Any:
    """Copy of a document with present names."""
    if isinstance(value, dict):
        return {renamed.get((*key, name), name): _renamed(each, renamed, (*key, name)) for name, each in value.items()}
    return [_renamed(each, renamed, (*key, i)) for i, each in enumerate(value)] if isinstance(value, list) else value


def _moved(
    text: str, data: dict[str, Any], moves: Sequence[tuple[Key, str]], file: Path
) -> tuple[str, list[KeyChange]]:
    """Move whole lines of a text to the table that their keys belong to, or remove them.

    Args:
        text: Text with present names.
        data: Document of the text; it is changed.
        moves: Keys and their tables, as `moved_keys` returns.
        file: File of the text.

    Returns:
        New text, and the changes with the lines of the old one.

    Raises:
        InputError: A key is not in a line of its own, or its new table has it already.
    """
    if not moves:
        return text, []
    parts = {part.key: part for part in key_parts(text)}
    lines, changes, taken = text.splitlines(keepends=True), list[KeyChange](), dict[str, list[str]]()
    for key, to in moves:
        number = text.count("\n", 0, parts[key].start)
        line = lines[number]
        row: Any = data
        for part in key[:-1]:
            row = row[part]
        table = data.setdefault(to, {}) if to else {}
        if line.lstrip().partition("=")[0].strip() != key[-1] or key[-1] in table:
            raise _not_by_names(file)
        table[key[-1]] = row.pop(key[-1])
        taken.setdefault(to, []).append(line if line.endswith("\n") else line + "\n")
        changes.append(KeyChange(number + 1, str(key[-1]), f"{to}.{key[-1]}" if to else "(removed)"))
    gone = {change.line - 1 for change in changes}
    for to, moved in taken.items():
        if not to:
            continue
        own = {text.count("\n", 0, part.start) for part in parts.values() if part.key[0] == to}
        if own - gone:
            last = max(own - gone)
            lines[last] = (lines[last] if lines[last].endswith("\n") else lines[last] + "\n") + "".join(moved)
        else:
            lines.append(f"\n[{to}]\n" + "".join(moved))
    new = "".join(line for number, line in enumerate(lines) if number not in gone)
    if parse_toml(new, file)[0] != data:
        raise _not_by_names(file)
    return new, changes
