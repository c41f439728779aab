"""`rocs-bt drive`: run a scenario on its real robots, with recording and report."""

from __future__ import annotations

from typing import Any

import click

from ..base.errors import DeviceError
from .drive_output import HoldOutput, PreflightOutput, show_notice
from .dry_run_output import DryRunOutput
from .enter_key import EnterKey
from .play_scenario import local_options, play_scenario, scenario_options
from .terminal import echo


@click.command()
@scenario_options("hardware")
def command(scenario: str, **given: Any) -> int:
    """Run SCENARIO, a name or a file, on its real robots, and print the outcome of each agent.

    First it shows a table of the sensors. The robots stay in neutral until every sensor gives fresh values, except
    those with `optional = true` in robot.toml. Without them it ends after --wait. After an emergency stop the robot
    stays in neutral until the stop is released and a person presses Enter.

    It writes summary.json, run.mcap and report.html. A run on hardware cannot be repeated, so the default folder is
    never that of an earlier run: the second one is runs/SCENARIO-SEED_2.

    Ctrl-C, SIGTERM and SIGHUP end the run: the robots go to neutral, then the files are written. Exits with 0 if every
    agent succeeded; 1 if one did not, if a sensor or actuator cannot be reached, or if a file could not be written; 2
    if the input is invalid; 3 if the engine failed; 128 + signal if a signal ended the run.
    """
    local, unsent = local_options(given), DryRunOutput() if given["dry_run"] else None
    sinks = [HoldOutput(), *([] if unsent is None else [unsent])]
    given |= {"go": EnterKey(), "preflight": PreflightOutput(), "notice": show_notice, "sinks": sinks}
    progress = None if unsent is None else unsent.show
    if unsent is not None:
        echo("Dry run: nothing is sent to any actuator.", err=True)
    try:
        return play_scenario(scenario, given, unit="s on hardware", on_hardware=True, progress=progress, **local)
    except DeviceError as error:
        echo(str(error), err=True)
        return 1
