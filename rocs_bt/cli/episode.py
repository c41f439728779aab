"""`rocs-bt episode`: play one episode of a comparison again, with recording and report."""

from __future__ import annotations

from pathlib import Path

import click

from ..catalog import Catalog
from .content import no_code_option
from .outcome import exit_code
from .terminal import echo, show_warnings


@click.command()
@click.argument("planner")
@click.argument("scene")
@click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Seed of the episode.")
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="Output folder; by default in runs.")
@no_code_option
def command(planner: str, scene: str, seed: int, out: Path | None, no_code: bool) -> int:
    """Play PLANNER in SCENE, as in a comparison, and write summary.json, run.mcap and report.html.

    SCENE is a scenario, or a scene of a family such as barn_like-17. Exit codes are those of `rocs-bt run`.
    """
    from ..compare.replay import episode_folder, replay_episode

    folder = out or episode_folder(planner, scene, seed)
    result = replay_episode(planner, scene, seed, Catalog.here(code=not no_code), folder)
    show_warnings(result.warnings)
    echo(str(result))
    if result.report is not None:
        echo(f"Report: {result.report}")
    return exit_code(result.summary, missing=bool(result.missing))
