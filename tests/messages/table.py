"""Golden table of messages: wrong inputs, given as a user gives them, and all that the user then reads.

`messages.toml` has a group for each kind of input. A group names the file at fault and the command that reads it; a row
puts the text `new` in place of `old` (or of the whole file) in a copy of the folder `project`, or gives a command line.
After a change of messages: `python -m tests.messages.table` writes the table anew, and its diff is to be read.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import re
import shutil
import tempfile
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from rocs_bt.catalog import Catalog
from rocs_bt.cli.main import call

FOLDER = Path(__file__).parent
FILE, PROJECT = FOLDER / "messages.toml", FOLDER / "project"
_SHIPPED = {entry.name for entry in Catalog().list()}
CHECK = "check scenarios/own.toml"


@dataclass(frozen=True)
class Row:
    """A wrong input and what the user reads.

    Attributes:
        group: Kind of input.
        name: What is wrong.
        file: Path of the changed file in the project; empty where none is changed.
        command: Command line, without `rocs-bt`.
        old: Text in the file, or None for the whole file.
        new: Text in its place.
        code: Exit code.
        reads: Text on stdout and stderr.
    """

    group: str
    name: str
    file: str
    command: str
    old: str | None
    new: str
    code: int
    reads: str

    @property
    def title(self) -> str:
        """Name of the row with that of its group."""
        return f"{self.group}.{self.name}"

    def put(self, project: Path) -> None:
        """Put the fault into a project."""
        if self.old is None and not self.new:
            return
        file = project / self.file
        file.parent.mkdir(parents=True, exist_ok=True)
        text = file.read_text(encoding="utf-8") if self.old is not None else ""
        assert self.old is None or self.old in text, f"{self.title}: no '{self.old}' in {self.file}"
        file.write_text(text.replace(self.old, self.new, 1) if self.old is not None else self.new, encoding="utf-8")


def write_project(folder: Path, faults: Iterable[Row] = ()) -> Path:
    """Write the good project with faults; returns the file of its scenario."""
    shutil.copytree(PROJECT, folder, dirs_exist_ok=True, ignore=shutil.ignore_patterns("__pycache__"))
    for fault in faults:
        fault.put(folder)
    return folder / "scenarios/own.toml"


def rows() -> list[Row]:
    """Rows of the table."""
    found, standard = [], {"file": "", "command": CHECK, "old": None, "new": "", "code": 2, "reads": ""}
    for group, table in tomllib.loads(FILE.read_text(encoding="utf-8")).items():
        head = {key: value for key, value in table.items() if not isinstance(value, dict)}
        found += [Row(group, name, **{**standard, **head, **row}) for name, row in table.items() if name not in head]
    return found


def play(table: list[Row]) -> list[Row]:
    """The rows with the exit code and the text that each command gives today."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as made:
        shared = Path(made).resolve() / "shared"
        write_project(shared)
        try:
            return [_play(row, shared) for row in table]
        finally:
            os.chdir(before)


def _play(row: Row, shared: Path) -> Row:
    """Play a row in the shared project, or in one of its own: a process loads a Python file once."""
    own = row.file.endswith(".py")
    folder = write_project(shared.with_name(row.title)).parents[1] if own else shared
    os.chdir(folder)
    row.put(folder)
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        code = call(row.command.split())
    text = (
        said.getvalue().replace(f"{folder}/", "").replace(str(folder), ".").replace(str(PROJECT.parents[2]), "ROCS_BT")
    )
    text = re.sub(r"(?<=There are: )\w+(?:, \w+)+", _without_shipped, re.sub(r"\.\.\. \d+ more", "... more", text))
    lines = [line.rstrip() for line in text.splitlines() if " checked: " not in line]
    if (PROJECT / row.file).is_file():
        shutil.copyfile(PROJECT / row.file, folder / row.file)
    elif row.file:
        (folder / row.file).unlink()
    return replace(row, code=code, reads="\n".join(lines))


def _without_shipped(found: re.Match[str]) -> str:
    """A list of names without those of shipped content, so that new content changes no message."""
    names = found[0].split(", ")
    own = [name for name in names if name not in _SHIPPED]
    return found[0] if 2 * len(own) > len(names) else ", ".join([*own, "(what is shipped)"])


def written(played: list[Row]) -> str:
    """Text of the table, with its groups as they are."""
    doc = (__doc__ or "").strip().splitlines()
    text = "".join(f"# {line}".rstrip() + "\n" for line in doc)
    for group, head in heads().items():
        text += f"\n[{group}]\n" + "".join(f"{key} = {_quoted(value)}\n" for key, value in head.items())
        text += text_of([row for row in played if row.group == group])
    return text


def heads() -> dict[str, dict[str, object]]:
    """Values that the rows of each group have if they give no other."""
    groups = tomllib.loads(FILE.read_text(encoding="utf-8"))
    return {name: {k: v for k, v in table.items() if not isinstance(v, dict)} for name, table in groups.items()}


def text_of(played: list[Row]) -> str:
    """Text of rows, each with the values that are not those of its group."""
    text, all_heads = "", heads()
    for row in played:
        given = {"file": "", "command": CHECK, "old": None, "new": "", "code": 2, **all_heads[row.group]}
        keys = {key: getattr(row, key) for key in (*given, "reads")}
        said = [f"{key} = {_quoted(value)}\n" for key, value in keys.items() if key == "reads" or value != given[key]]
        text += f"\n[{row.title}]\n" + "".join(said)
    return text


def _quoted(value: object) -> str:
    if not isinstance(value, str):
        return str(value)
    if "\n" in value:
        return f"'''\n{value}'''"
    return json.dumps(value, ensure_ascii=False) if "'" in value else f"'{value}'"


if __name__ == "__main__":
    FILE.write_text(written(play(rows())), encoding="utf-8")
