"""Emergency stop of the robot in plain rclpy: neutral until it is released and a person says go."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from rocs_bt import ListSink, RunResult, drive
from rocs_bt.catalog import Catalog
from rocs_bt.errors import DeviceError
from rocs_bt.event import MotionHeld, MotionReleased

from .exp1 import OPTIONS, start_of, write_project

pytestmark = pytest.mark.usefixtures("awake")


def with_stop(folder: Path, topic: str) -> Catalog:
    """The project, with a topic of an emergency stop."""
    catalog = write_project(folder, transport="dds")
    file = folder / "robots/own/robot.toml"
    file.write_text(file.read_text().replace("[ros2]\n", f'[ros2]\nemergency_stop = "{topic}"\n'))
    return catalog


def test_a_robot_does_not_start_while_nothing_publishes_its_emergency_stop(counterpart, tmp_path):
    counterpart(*OPTIONS, distribution="jazzy")
    catalog = with_stop(tmp_path, "stop")
    with pytest.raises(DeviceError, match=r"R2/emergency_stop: nothing is published on '/r1/stop'"):
        drive("real", catalog, duration=1.0, wait=2.0)


def test_neutral_until_a_release_and_a_go(counterpart, tmp_path):
    robot = counterpart(*OPTIONS, *start_of(1), distribution="jazzy")
    catalog = with_stop(tmp_path, "emergency_stop")
    sink, go, found = ListSink(), threading.Event(), list[RunResult]()

    def said() -> bool:
        now = go.is_set()
        go.clear()
        return now

    def run() -> None:
        found.append(drive("real", catalog, duration=60.0, sinks=[sink], go=said))

    def count(kind: type) -> Callable[[object], bool]:
        return lambda _: any(isinstance(event, kind) for event in sink.events)

    thread = threading.Thread(target=run)
    thread.start()
    robot.until("speeds[0] > 0.1")
    robot.tell("emergency_stop")
    robot.follow(count(MotionHeld))
    robot.follow(lambda lines: [each for each in lines if each.what == "command"][-1].rests)
    go.set()  # has no effect before the release
    held = len(robot.lines())
    robot.follow(lambda lines: len(lines) > held + 10)
    assert all(line.rests for line in robot.lines()[held:] if line.what == "command")
    robot.tell("released")
    held = len(robot.lines())
    robot.follow(lambda lines: len(lines) > held + 10)
    assert all(line.rests for line in robot.lines()[held:] if line.what == "command")
    assert not count(MotionReleased)(None)
    go.set()
    robot.until("speeds[0] > 0.1")
    thread.join(60.0)
    assert found[0].outcomes == {"R2": "success"}
    reasons = [event.reason for event in sink.events if isinstance(event, MotionHeld)]
    assert reasons[0] == "emergency stop: topic /r1/emergency_stop"
    assert reasons[-1] == "emergency stop released, waiting for go"
