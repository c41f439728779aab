"""`rocs-bt import`: convert a user's copy of a benchmark to scenarios."""

from __future__ import annotations

import itertools
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..errors import Fault, InputError
from ..units import LENGTH, convert
from ..words import counted
from .terminal import echo

if TYPE_CHECKING:
    from ..compare import Scene
    from ..compare.family import AgentSetup


@click.command()
@click.argument("benchmark", type=click.Choice(["barn", "mrpb", "movingai"]))
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), default=Path(), help="Project folder.")
@click.option("--limit", type=click.IntRange(min=1), help="Maximum number of scenarios.")
@click.option("--robot", default="jackal", show_default=True, help="Robot of the scenarios.")
@click.option("--mission", default="go_to", show_default=True, help="Mission; replaced by that of a planner.")
@click.option("--rules", default="avoid_collision", show_default=True, help="Rule file; may be empty.")
@click.option(
    "--pairs",
    type=click.IntRange(min=1),
    default=5,
    show_default=True,
    help="mrpb: number of start and goal pairs per map.",
)
@click.option("--cell-size", "cell", default="0.5 m", show_default=True, help="movingai: cell size.")
@click.option(
    "--every", type=click.IntRange(min=1), default=100, show_default=True, help="movingai: take every Nth problem."
)
def command(
    benchmark: str,
    folder: Path,
    out: Path,
    limit: int | None,
    robot: str,
    mission: str,
    rules: str,
    pairs: int,
    cell: str,
    every: int,
) -> None:
    """Convert the worlds of BENCHMARK in FOLDER, your own copy of it, to scenarios in your project.

    barn: a clone of the BARN challenge. mrpb: a clone of the local planning benchmark MRPB, or any maps in the format
    of ROS's map server. movingai: .map and .scen files.
    """
    from ..compare.family import AgentSetup

    if not folder.exists():
        raise InputError(
            Fault(f"there is no folder '{folder}'.", hint="Give the folder of your copy of the benchmark.")
        )
    side = convert(cell, LENGTH, "--cell-size")
    if not 0.05 <= side <= 10.0:
        raise InputError(Fault(f"--cell-size must be 5 cm to 10 m, found {side:g} m."))
    setup = AgentSetup(robot=robot, mission=mission, rules=rules)
    found = itertools.islice(_scenes(benchmark, folder, setup, pairs, side, every), limit)
    names = []
    for scene in found:
        scene.write(out)
        names.append(scene.name)
    if not names:
        raise InputError(Fault("no scene with enough space for the robot.", folder, hint="Try a larger --cell-size."))
    inside = "" if out == Path() else f"cd {shlex.quote(str(out))} && "
    which = names[0] if len(names) == 1 else f"{names[0]} to {names[-1]}"
    echo(f"{counted(len(names), 'scenario')}: {which}.")
    echo(f"Try next: {inside}rocs-bt run {names[0]}")


def _scenes(benchmark: str, folder: Path, setup: AgentSetup, pairs: int, cell: float, every: int) -> Iterator[Scene]:
    from ..compare.imports import read_barn, read_movingai, read_mrpb

    if benchmark == "barn":
        return read_barn(folder, setup)
    if benchmark == "mrpb":
        return read_mrpb(folder, setup, pairs=pairs)
    return read_movingai(folder, setup, cell=cell, every=every)
