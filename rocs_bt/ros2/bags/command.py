"""`rocs-bt export`: a recording as a bag; `rocs-bt replay --bag`: rules on a bag."""

from __future__ import annotations

import shlex
from pathlib import Path

import click

from ...base.words import counted
from ...cli.content import catalog_for, open_recording
from ...cli.terminal import echo


@click.command()
@click.argument("run", type=click.Path(path_type=Path))
@click.option(
    "--rosbag", "out", required=True, type=click.Path(path_type=Path), help="Folder of the bag; it must not exist."
)
@click.option(
    "--storage",
    type=click.Choice(["mcap", "sqlite3"]),
    default="mcap",
    show_default=True,
    help="Storage format of the bag.",
)
@click.option(
    "--start",
    metavar="TIME",
    default="0",
    show_default=True,
    help="Time of the bag at the start of the run: seconds since 1970, or a date as 2026-11-20T10:00:00+01:00.",
)
def command(run: Path, out: Path, storage: str, start: str) -> None:
    """Write RUN, a run's folder or its run.mcap, as a rosbag2 folder for rviz, PlotJuggler, Foxglove and `ros2 bag`.

    A recording that was cut off or damaged is exported up to there. Several agents have a namespace each.
    """
    from .export import export_rosbag, start_time

    recording = open_recording(run)
    bag = export_rosbag(recording, out, storage=storage, start=start_time(start))
    width = max(map(len, bag.topics))
    for topic, (kind, count) in bag.topics.items():
        echo(f"  {topic:<{width}}  {count:>7}  {kind}")
    for robot in bag.unknown_robots:
        echo(f"Without cmd_vel and the topics of drivers: this project has no robot '{robot}'.", err=True)
    count = sum(count for _, count in bag.topics.values())
    echo(f"{bag.folder}: {count} messages on {len(bag.topics)} topics, {bag.duration:.1f} s.")
    echo(f"Try next: ros2 bag play {shlex.quote(str(bag.folder))}   (nodes with use_sim_time:=true)")


def replay_bag_file(
    bag: Path,
    robot: str,
    rules: tuple[str, ...],
    out: Path | None,
    begin: float,
    duration: float,
    rate: float,
    no_code: bool,
) -> None:
    """Replay rules on the topics of a bag, and print the reflexes that fire; `rocs-bt replay --bag`."""
    from ...cli.rules import replay_rules_on
    from .replay import replay_bag

    catalog = catalog_for(robot, no_code=no_code)
    files = [catalog_for(file, no_code=no_code).find("rules", file).path for file in rules]
    folder = out or Path("runs") / bag.resolve().stem
    found = replay_bag(bag, catalog.load_robot(robot), catalog, folder, start=begin, duration=duration, control=rate)
    for sensor, topics in found.topics.items():
        named = topics if len(topics) < 4 else (topics[0], "...", topics[-1])
        count = counted(sum(found.counts[topic] for topic in topics), "message")
        echo(f"  {sensor}: {', '.join(named)} ({count})" if topics else f"  {sensor}: not in the bag, so it is invalid")
    for file in files:
        replay_rules_on(found.recording, file, catalog, folder / "rules")
    echo(f"Recording: {found.recording.path}")
    echo(f"Try next: rocs-bt rules tune FILE {folder} --rule RULE --threshold NAME   or   rocs-bt plot {folder}")
