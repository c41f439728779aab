"""`rocs-bt search`: search for a scene in which a planner fails, and reduce it to a minimal one."""

from __future__ import annotations

import json
import math
import re
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import click

from ..base.errors import Fault, InputError
from ..base.files import is_file, write_whole
from ..base.units import Bounds, Count
from ..base.words import counted
from ..cli.content import json_option, no_code_option
from ..cli.options import EpisodeOptions, declared_options
from ..cli.progress import ProgressBar
from ..cli.terminal import echo, show_warnings
from ..declare import Option

if TYPE_CHECKING:
    from ..compare.record import EpisodeRecord
    from .draft import Draft
    from .run_search import SearchResult
    from .space import SearchSpace


_LISTED = 12  # maximum number of listed obstacles


class CommandOptions(EpisodeOptions):
    """Options of the command."""

    family: Annotated[str, "Family of the searched scenes.", Option(("--family",))]
    given: Annotated[tuple[str, ...], "Fix a parameter of the family.", Option(("--set",), "NAME=VALUE")] = ()
    vary: Annotated[
        tuple[str, ...],
        "Range of a parameter; by default half to twice its value.",
        Option(("--vary",), "NAME=LOW..HIGH"),
    ] = ()
    failure: Annotated[
        Literal["any", "collision", "fell", "failed", "stuck", "timeout", "error"],
        "Outcome to search for.",
        Option(("--failure",)),
    ] = "any"
    budget: Annotated[int, Bounds(1), "Maximum number of episodes.", Option(("--budget",))] = 300
    seed: Annotated[Count, "Seed of the sampled scenes.", Option(("--seed",))] = 1
    out: Annotated[
        Path | None, "Project folder to write the scene and a test to.", Option(("--out",), path="folder")
    ] = None
    name: Annotated[str, "Name of the scene there; by default PLANNER_in_FAMILY.", Option(("--name",))] = ""


@click.command()
@click.argument("planner")
@declared_options(CommandOptions)
@json_option("Print JSON, including scenario and world of the scene.")
@no_code_option
def command(planner: str, as_json: bool, no_code: bool, **options: Any) -> int:
    """Search the scenes of a family for one in which PLANNER fails, and reduce it to a minimal one.

    An interrupted search continues where it stopped when called again. Exits with 1 if it found a failure, else 0.
    """
    from ..catalog import Catalog
    from ..compare import EpisodeStore, load_family
    from ..compare.replay import parse_value
    from .run_search import FAILURES, SearchOptions, default_name, search
    from .space import SearchSpace

    given, catalog = CommandOptions(**options), Catalog.here(code=not no_code)
    spec, folder = catalog.load_planner(planner), given.out
    fixed = {key: parse_value(value) for key, value in _pairs("--set", given.given).items()}
    space = SearchSpace.of(load_family(catalog, given.family, fixed), fixed, _pairs("--vary", given.vary))
    scene_name = given.name or default_name(spec, space)
    if folder is not None:
        refuse_existing(folder, scene_name)
    how = SearchOptions(
        name=scene_name,
        failures=FAILURES if given.failure == "any" else (given.failure,),
        budget=given.budget,
        seed=given.seed,
        workers=given.jobs,
        wall_limit=given.wall_limit,
        warned=show_warnings,
    )
    with (
        EpisodeStore(given.store) as kept,
        ProgressBar(f"{spec.name} in {given.family}", given.budget, "episodes") as progress,
    ):
        result = search(spec, space, how, catalog=catalog, store=kept, progress=progress)
    files = None
    if folder is not None and result.smallest is not None:
        files = keep(result.smallest, planner, folder)
    if as_json:
        echo(json.dumps(_plain(spec.name, space, result), indent=1, sort_keys=True))
    else:
        _print(planner, space, result)
        _print_files(planner, result.smallest, folder, files)
    return int(result.found is not None)


def _pairs(option: str, texts: Sequence[str]) -> dict[str, str]:
    found = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals:
            raise InputError(Fault(f"{option} takes NAME=..., found '{text}'."))
        found[name.strip()] = value.strip()
    return found


def _print(planner: str, space: SearchSpace, result: SearchResult) -> None:
    """Print the failure that was found, and the reduced scene."""
    family = space.family.name
    if result.sampled is None or result.found is None or result.first is None:
        echo(f"{planner} failed in none of {counted(result.searched, 'scene')} of {family}.")
        return
    parameters = ", ".join(f"{name}={value:g}" for name, value in result.sampled.parameters.items())
    suffix = f" ({parameters})" if parameters else ""
    echo(f"{planner} fails in {result.sampled.scene.name}{suffix}: {_how(result.first)}")
    echo(f"It was scene {result.searched}; {_size(result.found)}.")
    if result.smallest is None or result.last is None:
        return
    ended = "" if result.done else " (budget exhausted)"
    echo(f"Reduced in {counted(result.shrunk, 'more episode')}{ended}: {_size(result.smallest)}.")
    echo(f"  {_how(result.last)}")
    for line in _listed(result.smallest):
        echo(f"  {line}")


def _how(record: EpisodeRecord) -> str:
    return f"{record.outcome} after {record.sim_time:.4g} s; {record.reason}"


def _size(draft: Draft) -> str:
    return f"{counted(len(draft.obstacles), 'obstacle')}, {math.dist(draft.start, draft.goal):.3g} m from start to goal"


def _listed(draft: Draft) -> list[str]:
    """Lines with start and goal, and with the first obstacles."""
    from ..compare import Post

    lines = [f"start {_at(draft.start)}, goal {_at(draft.goal)}"]
    static = {obstacle.name: obstacle for obstacle in draft.floor.obstacles}
    for name, position in list(draft.obstacles.items())[:_LISTED]:
        obstacle = static.get(name)
        if obstacle is None:
            lines.append(f"{name}: a scripted actor, from {_at(position)}")
        elif isinstance(obstacle, Post):
            lines.append(f"{name}: a cylinder of {2.0 * obstacle.radius:g} m at {_at(position)}")
        else:
            turn = f", turned by {math.degrees(obstacle.yaw):.3g} deg" if obstacle.yaw else ""
            lines.append(f"{name}: a box of {obstacle.length:g} x {obstacle.width:g} m at {_at(position)}{turn}")
    more = len(draft.obstacles) - _LISTED
    return [*lines, f"and {counted(more, 'more obstacle')}"] if more > 0 else lines


def _at(position: tuple[float, float]) -> str:
    return f"({position[0]:g}, {position[1]:g})"


def _print_files(planner: str, draft: Draft | None, folder: Path | None, files: tuple[Path, Path] | None) -> None:
    """Print the files of the scene and the next command."""
    if draft is None:
        return
    if folder is None or files is None:
        echo("Try next: the same command with --out FOLDER, which writes the scene to a project.")
        return
    inside = "" if folder.resolve() == Path.cwd() else f"cd {shlex.quote(str(folder))} && "
    echo(f"Scenario: {files[0]}\nTest: {files[1]}")
    echo(f"Try next: {inside}{play_command(draft, planner)}")


def _plain(planner: str, space: SearchSpace, result: SearchResult) -> Mapping[str, Any]:
    """Result as plain data, SI units."""
    plain: dict[str, Any] = {
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
        plain["drawn"] = {"index": result.sampled.index, "parameters": dict(result.sampled.parameters)}
    for key, draft, record in (("found", result.found, result.first), ("smallest", result.smallest, result.last)):
        if draft is not None and record is not None:
            plain[key] = {
                "outcome": record.outcome,
                "reason": record.reason,
                "sim_time": record.sim_time,
                "trajectory_hash": record.trajectory_hash,
                "things": len(draft.obstacles),
                "distance": math.dist(draft.start, draft.goal),
                "scenario": draft.scene.toml,
                "world": draft.scene.world,
            }
    return plain


_TEST = '''"""A scene, found by a search, in which {planner} fails. The test fails until the planner is fixed."""

import pytest


@pytest.mark.planners("{planner}")
@pytest.mark.scenarios("{name}")
def {function}(comparison):
    assert comparison.comparison.outcomes("{planner}") == {{"success": 1}}
'''


def refuse_existing(folder: Path, name: str) -> None:
    """Check that saving a scene under a name would not overwrite a file.

    Raises:
        InputError: A file of this name exists, the folder is a file, or the name is not valid for a scenario.
    """
    if is_file(folder):
        raise InputError(Fault(f"'{folder}' is no folder.", hint="Choose another one with --out."))
    if not re.fullmatch(r"\w[\w-]*", name):
        raise InputError(Fault(f"'{name}' is not a valid scenario name.", hint="Use letters, digits, '_' and '-'."))
    for file in (folder / "scenarios" / f"{name}.toml", _test_of(name, folder)):
        if file.exists():
            raise InputError(Fault(f"'{name}' already exists.", file, hint="Choose another name with --name."))


def keep(draft: Draft, planner: str, folder: Path) -> tuple[Path, Path]:
    """Write a scene, and a test that the planner succeeds in it, into a project."""
    scenario = draft.scene.write(folder)
    test = _test_of(draft.name, folder)
    test.parent.mkdir(parents=True, exist_ok=True)
    write_whole(test, _TEST.format(planner=planner, name=draft.name, function=test.stem))
    return scenario, test


def play_command(draft: Draft, planner: str) -> str:
    """Shell command that plays a planner in the saved scene again."""
    from ..compare.replay import episode_command
    from .player import SEED

    return f"{episode_command(planner, draft.name)} --seed {SEED}"


def _test_of(name: str, folder: Path) -> Path:
    plain = re.sub(r"\W", "_", name)
    return folder / "tests" / f"test_{plain}.py"
