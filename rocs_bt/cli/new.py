"""`rocs-bt new`: create a project, or add a file to the project around the current folder."""

from __future__ import annotations

import re
import shlex
import tomllib
from pathlib import Path
from typing import Any

import click

from ..base.errors import Fault, InputError
from ..base.files import new_folder, read_bytes, read_text, write_whole
from ..base.toml_text import as_toml
from ..catalog import IDENTIFIED, Catalog, copy_content, find_project
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
_PYTHON: dict[str, dict[str, Path | None]] = {
    "mission": {"planners/missions/@NAME@.py": _PROJECT / "planners/missions/patrol.py"},
    "planner": {
        "planners/@NAME@.py": _CONTENT / "planner.py",
        "planners/@NAME@.toml": _CONTENT / "planner_python.toml",
    },
}
_NEXT = {
    "mission": 'rocs-bt show @NAME@   and write in a scenario: mission = "@NAME@"',
    "rules": 'rocs-bt rules test @NAME@   and write in a scenario: rules = ["@NAME@"]',
    "robot": 'rocs-bt identify @NAME@   and write in a scenario: robot = "@NAME@"',
    "scenario": "rocs-bt run @NAME@",
    "planner": (
        "rocs-bt run @FAMILY@-0 --planner @NAME@   or   rocs-bt compare @NAME@ tree --family @FAMILY@ --scenes 5"
    ),
}


@click.command()
@click.argument("name")
@click.option("--kind", type=click.Choice(list(_FILES)), help="Add a file of this kind to the project around you.")
@click.option("--copy", "copied", is_flag=True, help="With --kind: copy the shipped content NAME, to change it.")
@click.option("--python", is_flag=True, help="With --kind mission or planner: a Python file.")
@click.option("--family", help="With --kind planner: begin with the mission and the rules of this family's own agent.")
def command(name: str, kind: str | None, copied: bool, python: bool, family: str | None) -> None:
    """Create a project in the folder NAME; with --kind, add content NAME to the project around the current folder.

    A project has a mission, rules, a robot, a scenario and tests. New files pass `rocs-bt check`; no file is
    overwritten.
    """
    if python and kind not in _PYTHON:
        hint = "Add --kind mission or --kind planner, or remove --python."
        raise InputError(Fault("--python is for missions and planners.", hint=hint))
    if family is not None and kind != "planner":
        raise InputError(Fault("--family is for planners.", hint="Add --kind planner, or remove --family."))
    if copied:
        if kind is None or python or family is not None:
            raise InputError(Fault("--copy needs --kind alone.", hint="Write: rocs-bt new exp1 --kind scenario --copy"))
        path = copy_content(Catalog.here(), kind, name)
        echo(f"Created {path}. In this project it hides the shipped {kind} '{name}'.")
    elif kind is None:
        _create_project(Path(name))
    else:
        _add(kind, name, (_PYTHON if python else _FILES)[kind], family)


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


def _add(kind: str, name: str, files: dict[str, Path | None], family: str | None) -> None:
    if not re.fullmatch(r"\w[\w-]*", name):
        raise InputError(Fault(f"'{name}' is not a valid name.", hint="Use letters, digits, '_' and '-'."))
    project = find_project(Path.cwd())
    if project is None:
        hint = "Create a project with `rocs-bt new my_project`, and call this inside it."
        raise InputError(Fault(f"there is no project in '{Path.cwd()}' or above.", hint=hint))
    own = {} if family is None else _of_family(family, Catalog(project))
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
                text = read_text(template).replace("@NAME@", name)
                if own and path.suffix == ".toml":
                    table = tomllib.loads(text)
                    text = as_toml({**table, **({"rules": own["rules"]} if "python" in table else own)})
                write_whole(path, text)
            echo(f"Created {path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path}.")
    except OSError as error:
        raise InputError(Fault(f"cannot write '{error.filename or project}': {error.strerror or error}.")) from error
    if hidden:
        echo(f"In this project it hides the shipped {kind} '{name}'.")
    known = "maze" if len(targets) == 1 else "exp1_family"  # what these files can do without an edit
    echo(f"Try next: {_NEXT[kind].replace('@NAME@', name).replace('@FAMILY@', family or known)}")


def _copy(source: Path, target: Path, without: tuple[str, ...] = ()) -> None:
    for file in sorted(source.rglob("*")):
        if file.is_file() and file.suffix != ".pyc" and file.name not in without:
            copy = target / file.relative_to(source)
            copy.parent.mkdir(parents=True, exist_ok=True)
            write_whole(copy, read_bytes(file))


def _of_family(name: str, catalog: Catalog) -> dict[str, Any]:
    """Keys of a planner that does what the agent under test does in each scene of a family; raises InputError."""
    from ..compare.family import load_family, scene_of

    family = load_family(catalog, name)
    first, second = (scene_of(family, index).scenario["agent"][0] for index in (0, 1))
    parameters = {key: value for key, value in first["parameters"].items() if second["parameters"].get(key) == value}
    doc = f"The mission and the rules of the family {family.name}."
    return {"doc": doc, "mission": first["mission"], "rules": first["rules"], "parameters": parameters}
