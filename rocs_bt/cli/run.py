"""`rocs-bt run`: run a scenario in simulation, with recording and report."""

from __future__ import annotations

from typing import Any

import click

from .play_scenario import play_scenario, scenario_options


@click.command()
@scenario_options("simulation")
@click.option(
    "--planner",
    default="",
    metavar="NAME",
    help="Planner that controls the agent, as in a comparison; SCENARIO may then be a scene, such as barn_like-17.",
)
def command(scenario: str, **given: Any) -> int:
    """Run SCENARIO, a name or a file, and print the outcome of each agent.

    Writes summary.json, run.mcap and report.html, also if Ctrl-C, SIGTERM or SIGHUP ends the run; a second signal ends
    it at once. Exits with 0 if every agent succeeded, 1 if one did not or a file could not be written, 2 if the input
    is invalid, 3 if the engine failed, 128 + signal if a signal ended the run.
    """
    return play_scenario(scenario, unit="s simulated", **given)
