"""`rocs-bt new`: create a project with an example of each kind of content and tests."""

from __future__ import annotations

import shlex
import shutil
from pathlib import Path

import click

from ..catalog import Catalog, find_project
from ..errors import Fault, InputError
from .terminal import echo

_TEMPLATE = Path(__file__).parent / "project"
_ROBOT = "pioneer_p3dx"


@click.command()
@click.argument("name", type=click.Path(path_type=Path))
def command(name: Path) -> None:
    """Create a project in the folder NAME, with a mission, rules, a robot, a scenario and tests."""
    if name.exists() and (not name.is_dir() or any(name.iterdir())):
        raise InputError(Fault(f"'{name}' exists and is not empty.", hint="Choose a new name, or an empty folder."))
    shipped = Catalog()
    around = find_project(name.absolute().parent)
    if around is not None and around != shipped.shipped:
        raise InputError(
            Fault(
                f"'{name}' is inside the project '{around}'.",
                hint="Projects cannot be nested: choose a folder outside, or add files to that project.",
            )
        )
    robot = shipped.find("robot", _ROBOT).path.parent
    ignore = shutil.ignore_patterns("__pycache__", "*.pyc")
    try:
        shutil.copytree(_TEMPLATE, name, dirs_exist_ok=True, ignore=ignore)
        shutil.copytree(robot, name / "robots" / "rover", ignore=ignore)
    except OSError as error:
        raise InputError(Fault(f"cannot write the project '{name}': {error.strerror or error}.")) from error
    echo(f"Created the project {name}; see its README.md.")
    echo(f"Try next: cd {shlex.quote(str(name))} && rocs-bt run first && pytest")
