"""`rocs-bt scene`: generate scenes of a family as scenarios, and report their difficulty."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..catalog import Catalog
from .content import json_option, no_code_option
from .terminal import echo

if TYPE_CHECKING:
    from ..compare import Scene


@click.command()
@click.argument("family")
@click.argument("index", type=click.IntRange(min=0), default=0)
@click.option("--count", type=click.IntRange(min=1), default=1, help="Number of scenes, from INDEX on.")
@click.option("--set", "values", multiple=True, metavar="NAME=VALUE", help="A parameter, such as 'people=12'.")
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), default=Path(), help="Project folder.")
@click.option("--dry-run", is_flag=True, help="Print the difficulty; write nothing.")
@json_option("Difficulty as JSON, SI units.")
@no_code_option
def command(
    family: str,
    index: int,
    count: int,
    values: tuple[str, ...],
    out: Path,
    dry_run: bool,
    as_json: bool,
    no_code: bool,
) -> None:
    """Generate scenes of FAMILY, from INDEX on (0 by default), as scenarios with their worlds.

    The same family, parameters and index give the same scene on every machine.
    """
    from ..compare.family import load_family, scene_of
    from ..compare.replay import parse_parameters

    made = load_family(Catalog.here(code=not no_code), family, parse_parameters(values))
    scenes = [scene_of(made, i) for i in range(index, index + count)]
    written = [] if dry_run else [scene.write(out) for scene in scenes]
    if as_json:
        echo(json.dumps([_plain(scene) for scene in scenes], indent=2))
        return
    for scene in scenes:
        difficulty = ", ".join(f"{name} {value:.3g}" for name, value in scene.difficulty.items())
        echo(f"{scene.name}: {difficulty}")
    if written:
        inside = "" if out == Path() else f"cd {shlex.quote(str(out))} && "
        echo(f"Try next: {inside}rocs-bt run {scenes[0].name}")


def _plain(scene: Scene) -> dict[str, object]:
    return {
        "name": scene.name,
        "difficulty": dict(scene.difficulty),
        "reference_length": scene.reference_length,
        "reference": [list(point) for point in scene.reference],
    }
