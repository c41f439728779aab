"""`rocs-bt new`: create a project, or add a file to the project around the current folder."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import click

from ..catalog import IDENTIFIED, Catalog, find_project
from ..errors import Fault, InputError
from ..files import new_folder, read_bytes, read_text, write_whole
from .terminal import echo

_PROJECT = Path(__file__).parent / "project"
_CONTENT = Path(__file__).parent / "content"
_ROBOT = "jackal"

# Files of each kind in a project, with their templates.
_FILES: dict[str, dict[str, Path | None]] = {
    "mission": {"planners/missions/@NAME@.xml": _CONTENT / "mission.xml"},
    "rules": {"rules/@NAME@.toml": _PROJECT / "rules/keep_clear.toml"},
    "robot": {"robots/@NAME@": None},  # a copy of a shipped robot
    "scenario": {
        "scenarios/@NAME@.toml": _CONTENT / "scenario.toml",
        "scenarios/worlds/@NAME@.xml": _PROJECT / "scenarios/worlds/yard.xml",
    },
    "planner": {"planners/@NAME@.toml": _CONTENT / "planner.toml"},
}
_PYTHON: dict[str, Path | None] = {"planners/missions/@NAME@.py": _PROJECT / "planners/missions/patrol.py"}
_NEXT = {
    "mission": 'rocs-bt show @NAME@   and write in a scenario: mission = "@NAME@"',
    "rules": 'rocs-bt rules test @NAME@   and write in a scenario: rules = ["@NAME@"]',
    "robot": 'rocs-bt identify @NAME@   and write in a scenario: robot = "@NAME@"',
    "scenario": "rocs-bt run @NAME@",
    "planner": "rocs-bt episode @NAME@ maze-1   or   rocs-bt compare @NAME@ tree --family maze --scenes 5",
}


@click.command()
@click.argument("name")
@click.option("--kind", type=click.Choice(list(_FILES)), help="Add a file of this kind to the project around you.")
@click.option("--python", is_flag=True, help="With --kind mission: Python instead of XML.")
def command(name: str, kind: str | None, python: bool) -> None:
    """Create a project in the folder NAME; with --kind, add content NAME to the project around the current folder.

    A project has a mission, rules, a robot, a scenario and tests. New files pass `rocs-bt check`; no file is
    overwritten.
    """
    if python and kind != "mission":
        raise InputError(Fault("--python is for missions.", hint="Add --kind mission, or remove --python."))
    if kind is None:
        _create_project(Path(name))
    else:
        _add(kind, name, _PYTHON if python else _FILES[kind])


def _create_project(folder: Path) -> None:
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(Fault(f"'{folder}' exists and is not empty.", hint="Choose a new name, or an empty folder."))
    shipped = Catalog()
    around = find_project(folder.absolute().parent)
    if around is not None and around != shipped.shipped:
        kinds = "|".join(_FILES)
        raise InputError(
            Fault(
                f"'{folder}' is inside the project '{around}'. Projects cannot be nested.",
                hint=f"To add a file, write: rocs-bt new NAME --kind {kinds}. For a project, choose a folder outside.",
            )
        )
    try:
        with new_folder(folder):
            _copy(_PROJECT, folder)
            _copy(shipped.find("robot", _ROBOT).path.parent, folder / "robots" / "rover")
    except OSError as error:
        raise InputError(Fault(f"cannot write the project '{folder}': {error.strerror or error}.")) from error
    echo(f"Created the project {folder}; see its README.md.")
    echo(f"Try next: cd {shlex.quote(str(folder))} && rocs-bt run first && pytest")


def _add(kind: str, name: str, files: dict[str, Path | None]) -> None:
    if not re.fullmatch(r"\w[\w-]*", name):
        raise InputError(Fault(f"'{name}' is not a valid name.", hint="Use letters, digits, '_' and '-'."))
    project = find_project(Path.cwd())
    if project is None:
        hint = "Create a project with `rocs-bt new my_project`, and call this inside it."
        raise InputError(Fault(f"there is no project in '{Path.cwd()}' or above.", hint=hint))
    targets = {project / path.replace("@NAME@", name): template for path, template in files.items()}
    taken = [e.path for e in Catalog(project).list(kind) if e.name == name and e.path.is_relative_to(project)]
    if taken := taken + [path for path in targets if path.exists()]:
        raise InputError(Fault(f"the {kind} '{name}' already exists.", taken[0], hint="Choose another name."))
    hidden = any(entry.name == name for entry in Catalog().list(kind))
    try:
        for path, template in targets.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            if template is None:
                with new_folder(path):
                    _copy(Catalog().find("robot", _ROBOT).path.parent, path, without=(IDENTIFIED,))  # not measured
            else:
                write_whole(path, read_text(template).replace("@NAME@", name))
            echo(f"Created {path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path}.")
    except OSError as error:
        raise InputError(Fault(f"cannot write '{error.filename or project}': {error.strerror or error}.")) from error
    if hidden:
        echo(f"In this project it hides the shipped {kind} '{name}'.")
    echo(f"Try next: {_NEXT[kind].replace('@NAME@', name)}")


def _copy(source: Path, target: Path, without: tuple[str, ...] = ()) -> None:
    for file in sorted(source.rglob("*")):
        if file.is_file() and file.suffix != ".pyc" and file.name not in without:
            copy = target / file.relative_to(source)
            copy.parent.mkdir(parents=True, exist_ok=True)
            write_whole(copy, read_bytes(file))
