"""`rocs-bt import`: convert a user's copy of a benchmark, or maps of ROS, to scenarios."""

from __future__ import annotations

import itertools
import shlex
from pathlib import Path

import click

from ...base.errors import Fault, InputError
from ...base.words import counted
from ...cli.terminal import echo


@click.command()
@click.argument("kind", type=click.Choice(["barn", "map"]))
@click.argument("path", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), default=Path(), help="Project folder.")
@click.option("--limit", type=click.IntRange(min=1), help="Maximum number of scenarios.")
@click.option("--robot", default="jackal", show_default=True, help="Robot of the scenarios.")
@click.option("--mission", default="navigate", show_default=True, help="Mission; replaced by that of a planner.")
@click.option("--rules", default="avoid_collision", show_default=True, help="Rule file; may be empty.")
@click.option(
    "--pairs",
    type=click.IntRange(min=1),
    default=5,
    show_default=True,
    help="map: number of start and goal pairs per map.",
)
def command(
    kind: str, path: Path, out: Path, limit: int | None, robot: str, mission: str, rules: str, pairs: int
) -> None:
    """Convert the worlds in PATH to scenarios in your project.

    barn: your clone of the BARN challenge. map: a map of ROS's map server, a .yaml file with its .pgm or .png, or a
    folder with such maps.
    """
    from ...compare.family import AgentSetup
    from .barn import read_barn
    from .maps import read_maps

    if not path.exists():
        hint = "Give the .yaml file of a map, or a folder." if kind == "map" else "Give the folder of your clone."
        raise InputError(Fault(f"there is no '{path}'.", hint=hint))
    setup = AgentSetup(robot=robot, mission=mission, rules=rules)
    found = read_barn(path, setup) if kind == "barn" else read_maps(path, setup, pairs=pairs)
    names = []
    for scene in itertools.islice(found, limit):
        scene.write(out)
        names.append(scene.name)
    inside = "" if out == Path() else f"cd {shlex.quote(str(out))} && "
    which = names[0] if len(names) == 1 else f"{names[0]} to {names[-1]}"
    echo(f"{counted(len(names), 'scenario')}: {which}.")
    echo(f"Try next: {inside}rocs-bt run {names[0]}")
