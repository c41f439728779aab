"""`rocs-bt drive`: run a scenario on its real robots, with recording and report."""

from __future__ import annotations

from typing import Any

import click

from ..errors import DeviceError
from ..event import EventSink
from .drive_output import HoldOutput, PreflightOutput, show_notice
from .dry_run_output import DryRunOutput
from .enter_key import EnterKey
from .play_scenario import SharedOptions, play_scenario, scenario_options
from .terminal import echo


@click.command()
@scenario_options(
    click.option(
        "--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Seed of random choices of missions."
    ),
    click.option("--for", "duration", metavar="SECONDS", type=float, help="End this time after the start."),
    click.option(
        "--wait",
        metavar="SECONDS",
        type=click.FloatRange(min=0.0, max=1e6),
        default=10.0,
        show_default=True,
        help="Give up if a needed sensor has no fresh values for this time.",
    ),
    click.option(
        "--dry-run",
        "--dry",
        is_flag=True,
        help="Send nothing to any actuator; print each second what would be sent.",
    ),
    click.option("--confirm", is_flag=True, help="Start only when a person presses Enter."),
)
def command(wait: float, dry_run: bool, confirm: bool, **shared: Any) -> int:
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
    from .._run import drive

    changes: dict[str, Any] = {"wait": wait, "dry_run": dry_run, "confirm": confirm, "go": EnterKey()}
    changes |= {"preflight": PreflightOutput(), "notice": show_notice}
    unsent = DryRunOutput() if dry_run else None
    sinks: list[EventSink] = [HoldOutput(), *([] if unsent is None else [unsent])]
    progress = None if unsent is None else unsent.show
    if dry_run:
        echo("Dry run: nothing is sent to any actuator.", err=True)
    try:
        given = SharedOptions(**shared)
        return play_scenario(drive, given, changes, unit="s on hardware", keep=True, sinks=sinks, progress=progress)
    except DeviceError as error:
        echo(str(error), err=True)
        return 1
