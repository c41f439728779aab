"""`rocs-bt run`: run a scenario in simulation, with recording and report."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..event import Event, SubtreeSwapped, SwapRefused
from .play_scenario import SharedOptions, play_scenario, scenario_options
from .terminal import echo


@click.command()
@scenario_options(
    click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Seed of the episode."),
    click.option(
        "--mode",
        type=click.Choice(["lockstep", "threaded"]),
        default="lockstep",
        show_default=True,
        help="lockstep: simulated time, repeatable; threaded: wall time, a thread per block.",
    ),
    click.option("--for", "duration", metavar="SECONDS", type=float, help="End after this simulated time."),
    click.option(
        "--swap",
        "swaps",
        metavar="NODE=FILE[:TREE]@TIME",
        multiple=True,
        help="Replace this subtree of the mission by that of an XML mission at this time [s]; may be repeated.",
    ),
    click.option("--view", is_flag=True, help="Watch in MuJoCo's viewer."),
    click.option("--video", type=click.Path(path_type=Path, dir_okay=False), help="Render a video to this file."),
    click.option("--follow", metavar="ROBOT", default="", help="The camera of the video follows this robot."),
)
def command(mode: str, swaps: tuple[str, ...], view: bool, video: Path | None, follow: str, **shared: Any) -> int:
    """Run SCENARIO, a name or a file, and print the outcome of each agent.

    Writes summary.json, run.mcap and report.html, also if Ctrl-C, SIGTERM or SIGHUP ends the run; a second signal ends
    it at once. Exits with 0 if every agent succeeded, 1 if one did not or a file could not be written, 2 if the input
    is invalid, 3 if the engine failed, 128 + signal if a signal ended the run.
    """
    from .._run import run
    from ..running import read_swap

    asked = [read_swap(text) for text in swaps]
    changes, made = {"mode": mode, "swaps": asked, "view": view, "video": video, "follow": follow}, _Swaps()
    sinks = [made] if asked else []
    code = play_scenario(run, SharedOptions(**shared), changes, unit="s simulated", sinks=sinks)
    for swap in sorted(asked, key=lambda swap: swap.at)[made.count :]:
        echo(f"'{swap}' was not made, because the run had ended.", err=True)
    return code


class _Swaps:
    """Event sink that prints the replacements of subtrees.

    Attributes:
        count: Number of replacements so far, with those that were refused.
    """

    def __init__(self) -> None:
        self.count = 0

    def emit(self, event: Event) -> None:
        """Print a SubtreeSwapped or SwapRefused event."""
        if isinstance(event, (SubtreeSwapped, SwapRefused)):
            self.count += 1
            echo(f"{event.t:.2f} s, {event.agent}: {event.sentence}", err=True)
