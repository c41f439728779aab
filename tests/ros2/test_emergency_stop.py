"""Emergency stop of the robot in plain rclpy: neutral until it is released and a person says go."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from rocs_bt import ListSink, RunResult, drive
from rocs_bt.base.errors import DeviceError
from rocs_bt.catalog import Catalog
from rocs_bt.event import MotionHeld, MotionReleased, OtherPublisherFound
from rocs_bt.ros2.network.connect import open_transport
from rocs_bt.ros2.network.qos import QoS
from rocs_bt.ros2.settings import Ros2Settings
from rocs_bt.running import StopSignals
from rocs_bt.running.preflight import PreflightReport

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


HEARTBEAT = """
import time
from rocs_bt.ros2.network.connect import open_transport
from rocs_bt.ros2.network.qos import QoS
from rocs_bt.ros2.settings import Ros2Settings
transport = open_transport(Ros2Settings(transport="dds"), "button")
writer = transport.writer("/r1/stop", "std_msgs/msg/Bool", QoS.COMMAND)
while True:
    writer.write(transport.types.serialize(transport.types.make(writer.type, data=False)))
    time.sleep(0.1)
"""


def test_a_killed_emergency_stop_and_another_publisher_of_the_commands(counterpart, tmp_path):
    robot = counterpart(*OPTIONS, *start_of(1), distribution="jazzy")
    catalog, sink, notices = with_stop(tmp_path, "stop"), ListSink(), list[str]()
    signals = StopSignals()
    options = {"duration": 60.0, "sinks": [sink], "notice": notices.append, "signals": signals}
    with closing(open_transport(Ros2Settings(transport="dds"), "teleop")) as teleop:
        teleop.writer("/r1/cmd_vel", "geometry_msgs/msg/TwistStamped", QoS.COMMAND)
        button = subprocess.Popen([sys.executable, "-c", HEARTBEAT])
        thread = threading.Thread(target=lambda: drive("real", catalog, **options))
        thread.start()
        robot.until("speeds[0] > 0.1")
        button.kill()
        button.wait()
        robot.follow(lambda _: any(isinstance(event, MotionHeld) for event in sink.events))
        robot.until("speeds == [0.0, 0.0]")
        robot.follow(lambda _: notices)
        signals.received = signal.SIGTERM
        thread.join(60.0)
    reason = next(event.reason for event in sink.events if isinstance(event, MotionHeld))
    assert re.fullmatch(r"emergency stop: no message on /r1/stop for \d\.\d s, which were repeated before", reason)
    found = [event for event in sink.events if isinstance(event, OtherPublisherFound)]
    assert [(event.agent, event.actuator, event.topic, event.node) for event in found] == [
        ("R2", "wheels", "/r1/cmd_vel", "the node '/teleop'")
    ]
    assert notices == [f"R2: {found[0].sentence}."]


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
    # A busy machine can hold the robot too, for another reason.
    held = [event.reason for event in sink.events if isinstance(event, MotionHeld)]
    reasons = [reason for reason in held if reason.startswith("emergency stop")]
    assert reasons[0] == "emergency stop: topic /r1/emergency_stop"
    assert reasons[-1] == "emergency stop released, waiting for go"


def test_a_robot_does_not_start_before_the_release_and_a_go(counterpart, tmp_path):
    robot = counterpart(*OPTIONS, *start_of(1), distribution="jazzy")
    catalog, seen = with_stop(tmp_path, "emergency_stop"), list[str]()
    stopped, waiting = "emergency stop: topic /r1/emergency_stop", "emergency stop released, waiting for go"

    def show(report: PreflightReport) -> None:
        if report.paused not in seen[-1:]:
            seen.append(report.paused)
        if waiting not in seen:
            robot.tell("released" if stopped in seen else "emergency_stop")

    drive("real", catalog, duration=1.0, preflight=show, go=lambda: waiting in seen)
    assert seen[-3:] == [stopped, waiting, ""]
