"""`rocs-bt replay`: re-run agents on recorded sensor data, explain one moment of a run, or evaluate rules on a bag."""

from __future__ import annotations

import math
from pathlib import Path

import click

from ..base.registered import load
from ..base.units import FREQUENCY, NOT_NEGATIVE, POSITIVE
from ..catalog import Catalog
from .content import no_code_option, open_recording
from .options import QuantityType
from .terminal import echo


@click.command()
@click.argument("run", type=click.Path(path_type=Path), required=False)
@click.option("--why", type=QuantityType(), help="Explain the decision at this time.")
@click.option("--all", "everything", is_flag=True, help="Print all evidence, or the whole of the first difference.")
@click.option("--agent", help="Name of the agent; by default all.")
@click.option("--changed-content", is_flag=True, help="Compare although robots, rules or other files have changed.")
@click.option("--bag", type=click.Path(path_type=Path), help="ROS bag to replay in place of a run.")
@click.option("--robot", metavar="NAME", help="With --bag: robot with sensors that read its topics.")
@click.option("--rules", metavar="FILE|NAME", multiple=True, help="With --bag: rule file to evaluate; may be repeated.")
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    help="With --bag: output folder; by default runs/<name of the bag>.",
)
@click.option(
    "--from", "begin", type=QuantityType(bounds=NOT_NEGATIVE), help="With --bag: begin at this time in the bag."
)
@click.option("--for", "duration", type=QuantityType(bounds=POSITIVE), help="With --bag: end after this time.")
@click.option("--rate", type=QuantityType(FREQUENCY, POSITIVE), help="With --bag: control rate; by default 20 Hz.")
@no_code_option
def command(
    run: Path | None,
    why: float | None,
    everything: bool,
    agent: str | None,
    changed_content: bool,
    bag: Path | None,
    robot: str | None,
    rules: tuple[str, ...],
    out: Path | None,
    begin: float | None,
    duration: float | None,
    rate: float | None,
    no_code: bool,
) -> int:
    """Re-run the agents of RUN on its recorded sensor data, and compare their events with the recorded ones.

    Exits with 0 if all events are equal, with 1 at the first difference. With --why, the recording is only queried:
    the answer and at most ten lines of evidence; with --all, everything known.
    With --changed-content, the agents have the present content: it shows whether a change alters their decisions.

    With --bag, the sensors of --robot read a ROS bag: when would the reflexes of --rules have fired? Prints the tables
    of `rocs-bt rules replay`, and writes a recording for it and for `rules tune`, `plot` and `report`.
    """
    given = {"robot": robot, "rules": rules, "out": out, "begin": begin, "duration": duration, "rate": rate}
    if bag is not None:
        if run is not None or why is not None or agent is not None or everything or changed_content:
            raise click.UsageError("--bag excludes RUN, --why, --all, --agent and --changed-content.")
        if robot is None:
            raise click.UsageError("--bag needs --robot, a robot with sensors that read topics of ROS 2.")
        limit = math.inf if duration is None else duration
        over_bag = load("rocs_bt.commands", "replay.bag")
        over_bag(bag, robot, rules, out, begin or 0.0, limit, 20.0 if rate is None else rate, no_code)
        return 0
    if run is None:
        raise click.UsageError("Missing argument 'RUN', or --bag.")
    if any(given.values()):
        raise click.UsageError("--robot, --rules, --out, --from, --for and --rate need --bag.")
    return _replay_run(run, why, agent, everything, changed_content, no_code)


def _replay_run(
    run: Path, why: float | None, agent: str | None, everything: bool, changed_content: bool, no_code: bool
) -> int:
    recording = open_recording(run)
    if why is not None:
        from ..record import explain

        echo(explain(recording, why, agent).text(everything=everything))
        return 0
    from ..running import replay

    difference = replay(recording, Catalog.here(code=not no_code), agent=agent, changed_content=changed_content)
    if difference is None:
        echo("All events are equal.")
        return 0
    echo(difference.text(everything=everything))
    return 1
