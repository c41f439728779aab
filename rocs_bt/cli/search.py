"""`rocs-bt search`: where a planner fails, and the least that makes it fail."""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..catalog import Catalog
from ..errors import Fault, InputError
from ..words import counted
from .progress import Progress
from .terminal import echo

if TYPE_CHECKING:
    from ..compare.record import EpisodeRecord
    from ..compare.search import Draft, SearchResult, SearchSpace

_LISTED = 12  # things that are told of a scene


@click.command()
@click.argument("planner")
@click.option("--family", required=True, help="The scenes to search.")
@click.option("--set", "given", multiple=True, metavar="NAME=VALUE", help="A parameter of the family, which stays.")
@click.option("--vary", multiple=True, metavar="NAME=LOW..HIGH", help="The range of one; half to twice if left out.")
@click.option(
    "--failure",
    type=click.Choice(["any", "collision", "failed", "stuck", "timeout", "error"]),
    default="any",
    show_default=True,
    help="What to seek.",
)
@click.option("--budget", type=click.IntRange(min=1), default=300, show_default=True, help="Episodes at most, in all.")
@click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Of what is drawn.")
@click.option("--keep", "folder", type=click.Path(path_type=Path, file_okay=False), help="A project to write it into.")
@click.option("--name", default="", help="Its name there; PLANNER_in_FAMILY if left out.")
@click.option(
    "--store",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("runs/compare"),
    show_default=True,
    help="Where episodes are kept: what is there is not played again.",
)
@click.option("--workers", type=click.IntRange(min=1), help="Processes; one for each core if left out.")
@click.option("--wall-limit", type=float, default=300.0, show_default=True, help="Longest an episode may compute [s].")
@click.option("--json", "as_json", is_flag=True, help="Tell it as JSON, both texts of the scene included.")
@click.option("--no-code", is_flag=True, help="Refuse Python content.")
def command(
    planner: str,
    family: str,
    given: Sequence[str],
    vary: Sequence[str],
    failure: str,
    budget: int,
    seed: int,
    folder: Path | None,
    name: str,
    store: Path,
    workers: int | None,
    wall_limit: float,
    as_json: bool,
    no_code: bool,
) -> int:
    """Search the scenes of FAMILY for one in which PLANNER fails, and make that one as small as can be.

    Killed at any moment and called again, it goes on where it was. Exits with 1 where it found one, else with 0.
    """
    from ..compare import Store, load_family
    from ..compare.replay import parse_value
    from ..compare.search import FAILURES, SearchOptions, SearchSpace, default_name, keep, refuse_existing, search

    catalog = Catalog.here(code=not no_code)
    who = catalog.load_planner(planner)
    fixed = {key: parse_value(value) for key, value in _pairs("--set", given).items()}
    space = SearchSpace.of(load_family(catalog, family, fixed), fixed, _pairs("--vary", vary))
    called = name or default_name(who, space)
    if folder is not None:
        refuse_existing(folder, called)
    options = SearchOptions(
        name=called,
        failures=FAILURES if failure == "any" else (failure,),
        budget=budget,
        seed=seed,
        workers=workers,
        wall_limit=wall_limit,
    )
    with Store(store) as kept, Progress(f"{who.name} in {family}", budget, "episodes") as progress:
        result = search(who, space, options, catalog=catalog, store=kept, progress=progress)
    files = None
    if folder is not None and result.smallest is not None:
        files = keep(result.smallest, planner, folder)
    if as_json:
        echo(json.dumps(_plain(who.name, space, result), indent=1, sort_keys=True))
    else:
        _tell(planner, space, result)
        _tell_kept(planner, result.smallest, folder, files)
    return int(result.found is not None)


def _pairs(option: str, texts: Sequence[str]) -> dict[str, str]:
    found = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals:
            raise InputError(Fault(f"{option} takes NAME=..., found '{text}'."))
        found[name.strip()] = value.strip()
    return found


def _tell(planner: str, space: SearchSpace, result: SearchResult) -> None:
    """What was found, and what is left of it."""
    family = space.family.name
    if result.sampled is None or result.found is None or result.first is None:
        echo(f"{planner} failed in none of {counted(result.searched, 'scene')} of {family}.")
        return
    told = ", ".join(f"{name}={value:g}" for name, value in result.sampled.parameters.items())
    echo(f"{planner} fails in {result.sampled.scene.name}{f' ({told})' if told else ''}: {_how(result.first)}")
    echo(f"It was scene {result.searched}; {_size(result.found)}.")
    if result.smallest is None or result.last is None:
        return
    ended = "" if result.done else ", where the budget ended"
    echo(f"What is left after {counted(result.shrunk, 'more episode')}{ended}: {_size(result.smallest)}.")
    echo(f"  {_how(result.last)}")
    for line in _listed(result.smallest):
        echo(f"  {line}")


def _how(record: EpisodeRecord) -> str:
    return f"{record.outcome} after {record.sim_time:.4g} s; {record.reason}"


def _size(draft: Draft) -> str:
    return f"{counted(len(draft.obstacles), 'thing')}, {math.dist(draft.start, draft.goal):.3g} m from start to goal"


def _listed(draft: Draft) -> list[str]:
    """Start, goal and the first things, each on a line."""
    from ..compare import Post

    lines = [f"start {_at(draft.start)}, goal {_at(draft.goal)}"]
    standing = {obstacle.name: obstacle for obstacle in draft.ground.obstacles}
    for name, place in list(draft.obstacles.items())[:_LISTED]:
        obstacle = standing.get(name)
        if obstacle is None:
            lines.append(f"{name}: a mover, from {_at(place)}")
        elif isinstance(obstacle, Post):
            lines.append(f"{name}: a cylinder of {2.0 * obstacle.radius:g} m at {_at(place)}")
        else:
            turn = f", turned by {math.degrees(obstacle.yaw):.3g} deg" if obstacle.yaw else ""
            lines.append(f"{name}: a box of {obstacle.length:g} x {obstacle.width:g} m at {_at(place)}{turn}")
    more = len(draft.obstacles) - _LISTED
    return [*lines, f"and {counted(more, 'more thing')}"] if more > 0 else lines


def _at(place: tuple[float, float]) -> str:
    return f"({place[0]:g}, {place[1]:g})"


def _tell_kept(planner: str, draft: Draft | None, folder: Path | None, files: tuple[Path, Path] | None) -> None:
    """Where the scene is, and what to type next."""
    from ..compare.search import play_command

    if draft is None:
        return
    if folder is None or files is None:
        echo("Try next: the same command with --keep FOLDER, which writes it into a project.")
        return
    inside = "" if folder.resolve() == Path.cwd() else f"cd {shlex.quote(str(folder))} && "
    echo(f"Kept: {files[0]}, and a test of it: {files[1]}")
    echo(f"Try next: {inside}{play_command(draft, planner)}")


def _plain(planner: str, space: SearchSpace, result: SearchResult) -> Mapping[str, Any]:
    """All of it as JSON, SI units."""
    told: dict[str, Any] = {
        "planner": planner,
        "family": space.family.name,
        "searched": result.searched,
        "shrunk": result.shrunk,
        "done": result.done,
        "drawn": None,
        "found": None,
        "smallest": None,
    }
    if result.sampled is not None:
        told["drawn"] = {"index": result.sampled.index, "parameters": dict(result.sampled.parameters)}
    for key, draft, record in (("found", result.found, result.first), ("smallest", result.smallest, result.last)):
        if draft is not None and record is not None:
            told[key] = {
                "outcome": record.outcome,
                "reason": record.reason,
                "sim_time": record.sim_time,
                "trajectory_hash": record.trajectory_hash,
                "things": len(draft.obstacles),
                "distance": math.dist(draft.start, draft.goal),
                "scenario": draft.scene.toml,
                "world": draft.scene.world,
            }
    return told
