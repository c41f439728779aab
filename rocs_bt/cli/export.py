"""`rocs-bt export`: a recording in the format of another tool."""

from __future__ import annotations

import shlex
from pathlib import Path

import click

from .content import open_recording
from .terminal import echo


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
    from ..ros2.bags.export import export_rosbag, start_time

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
