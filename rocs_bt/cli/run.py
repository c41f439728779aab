"""`rocs-bt run`: run a scenario in simulation, with recording and report."""

from __future__ import annotations

from typing import Any

import click

from ..event import Event, SubtreeSwapped, SwapRefused
from .play_scenario import local_options, play_scenario, scenario_options
from .terminal import echo


@click.command()
@scenario_options("simulation")
@click.option(
    "--planner",
    default="",
    metavar="NAME",
    help="Planner that controls the agent, as in a comparison; SCENARIO may then be a scene, such as barn_like-17.",
)
def command(scenario: str, planner: str, **given: Any) -> int:
    """Run SCENARIO, a name or a file, and print the outcome of each agent.

    Writes summary.json, run.mcap and report.html, also if Ctrl-C, SIGTERM or SIGHUP ends the run; a second signal ends
    it at once. Exits with 0 if every agent succeeded, 1 if one did not or a file could not be written, 2 if the input
    is invalid, 3 if the engine failed, 128 + signal if a signal ended the run.
    """
    made, local = _Swaps(), local_options(given)
    given["sinks"] = [made]
    code = play_scenario(scenario, given, unit="s simulated", planner=planner, **local)
    for swap in sorted(given["swaps"], key=lambda swap: swap.at)[made.count :]:
        echo(f"'{swap}' was not made, because the run had ended.", err=True)
    return code


class _Swaps:
    """Event sink that prints the replacements of subtrees."""

    def __init__(self) -> None:
        self.count = 0

    def emit(self, event: Event) -> None:
        """Print a SubtreeSwapped or SwapRefused event."""
        if isinstance(event, (SubtreeSwapped, SwapRefused)):
            self.count += 1
            echo(f"{event.t:.2f} s, {event.agent}: {event.sentence}", err=True)
