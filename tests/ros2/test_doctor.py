"""`rocs-bt doctor --ros2` beside a plain publisher process, over DDS."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from rocs_bt.cli.main import call
from rocs_bt.ros2.network.connect import open_transport
from rocs_bt.ros2.network.dds import DdsTransport
from rocs_bt.ros2.network.qos import QoS
from rocs_bt.ros2.settings import Ros2Settings

from .. import needs

needs.package("cyclonedds")

ROBOT = """\
format = "robot/3"
base = "pioneer_p3dx"
doc = "A robot for the doctor."
[ros2]
transport = "dds"
[[sensor]]
name = "sonar"
driver = "ros2"
topics = ["range", "nothing"]
type = "sensor_msgs/msg/Range"
[[sensor]]
name = "position"
driver = "ros2"
topic = "odom"
type = "nav_msgs/msg/Odometry"
[[sensor]]
name = "orientation"
driver = "ros2"
topic = "odom"
type = "nav_msgs/msg/Odometry"
reliability = "reliable"
[[sensor]]
name = "encoders"
driver = "ros2"
optional = true
topic = "wheels"
type = "sensor_msgs/msg/JointState"
joints = ["left", "right"]
[[actuator]]
name = "wheels"
driver = "ros2"
topic = "cmd_vel"
type = "geometry_msgs/msg/TwistStamped"
"""


@pytest.fixture
def publisher(ros_environment: dict[str, str]) -> Iterator[None]:
    command = [sys.executable, str(Path(__file__).with_name("plain_publisher.py")), "0.2"]
    with subprocess.Popen(command, env=ros_environment, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        yield
        process.kill()


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    file = tmp_path / "robots" / "mine" / "robot.toml"
    file.parent.mkdir(parents=True)
    file.write_text(ROBOT)
    return file


def examined(
    capsys: pytest.CaptureFixture[str], *robot: str, whole: Callable[[str, str], bool]
) -> tuple[int, str, str]:
    """Exit code, output and errors of the doctor; for a longer time, until the whole network was discovered."""
    for duration in (2, 4, 8, 16):
        code = call(["doctor", "--ros2", *robot, "--for", str(duration)])
        out, err = capsys.readouterr()
        if whole(out, err):
            break
    return code, out, err


def discovered(out: str, err: str) -> bool:
    """Whether the doctor has seen all endpoints of the publisher."""
    return out.count("good") == 2 and "robot.toml requests" in err and "which is another type" in err


@pytest.mark.usefixtures("publisher")
def test_each_topic_is_described_and_each_mismatch_told_with_both_sides(
    robot: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "160")
    code, out, err = examined(capsys, str(robot), whole=discovered)
    assert code == 1
    rows = {tuple(cells[:2]): cells[2:] for line in out.splitlines() if len(cells := re.split(r"\s{2,}", line)) > 6}
    node, rate, age, header, values, good = rows["sonar", "/range"]
    assert (node, values, good) == ("/plain", "1", "good")
    assert 1.0 < float(rate) < 51.0  # it publishes at most at 50 Hz
    assert 0.0 <= float(age) < 100.0
    assert 200.0 <= float(header) < 1000.0
    assert rows["position", "/odom"][4:] == ["3", "good"]
    assert rows["encoders", "/wheels"][-1] == "optional"
    assert [row[-1] for row in rows.values()].count("problem") == 3
    assert "nothing is published on '/nothing'" in err
    assert "does not match in reliability (offered best_effort, requested reliable)" in err
    assert "subscribes to geometry_msgs/msg/Twist, which is another type" in err
    assert "it offers best_effort, volatile, depth 5, robot.toml requests reliable, volatile, depth 5" in err


@pytest.mark.usefixtures("publisher")
@pytest.mark.parametrize(("ahead", "verdict"), [(0.1, "clock offset"), (0.4, "problem")])
def test_a_clock_that_is_ahead_is_told_and_beyond_the_validity_a_problem(
    robot: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], ahead: float, verdict: str
) -> None:
    monkeypatch.setenv("COLUMNS", "160")
    monkeypatch.setattr(DdsTransport, "now", lambda self: time.time() - ahead)
    told = re.compile(r"position: its stamps are 0\.\d\d s ahead of this computer's clock: synchronise")
    _, out, err = examined(capsys, str(robot), whole=lambda _, err: bool(told.search(err)))
    assert told.search(err)
    assert re.search(rf"^position .* {verdict} *$", out, re.MULTILINE)


@pytest.mark.usefixtures("publisher")
def test_without_a_robot_every_topic_is_listed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], domain: int
) -> None:
    monkeypatch.setenv("COLUMNS", "160")
    code, out, _ = examined(capsys, whole=lambda out, _: out.count("/plain") == 3)
    assert code == 0
    assert f"ROS domain {domain}, loopback" in out
    assert re.search(r"^/range +sensor_msgs/msg/Range +/plain +publishes +best_effort", out, re.MULTILINE)
    assert re.search(r"^/cmd_vel +geometry_msgs/msg/Twist +/plain +reads +reliable", out, re.MULTILINE)


@pytest.mark.parametrize(
    ("publishers", "remark"),
    [
        (["rocs_bt", "rocs_bt_wheels"], "a run of rocs_bt commands it (/rocs_bt, /rocs_bt_wheels)"),
        (
            ["rocs_bt", "rocs_bt", "rocs_bt_wheels", "teleop"],
            "also published by 2 publishers of /rocs_bt, /teleop: these commands override stops",
        ),
    ],
)
def test_publishers_of_the_commands_are_told_apart(
    robot: Path,
    ros_environment: dict[str, str],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    publishers: list[str],
    remark: str,
) -> None:
    monkeypatch.setenv("COLUMNS", "160")
    types = "geometry_msgs/msg/TwistStamped"
    with ExitStack() as stack:
        base = stack.enter_context(closing(open_transport(Ros2Settings(transport="dds"), "base")))
        base.reader("/cmd_vel", types, QoS.COMMAND)
        for name in publishers:
            transport = stack.enter_context(closing(open_transport(Ros2Settings(transport="dds"), name)))
            transport.writer("/cmd_vel", types, QoS.COMMAND)
        _, out, err = examined(capsys, str(robot), whole=lambda out, err: "1 matched" in out and remark in err)
    (verdict,) = [line.split()[-1] for line in out.splitlines() if line.startswith("wheels")]
    assert verdict == ("use" if "run" in remark else "publisher")
    assert [line for line in err.splitlines() if line.startswith("wheels")] == [f"wheels: {remark}"]


@pytest.mark.usefixtures("ros_environment")
def test_an_empty_network_is_told_with_what_to_compare(
    domain: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain + 100))  # no publisher of a former test is remembered there
    assert call(["doctor", "--ros2", "--for", "0.3"]) == 1
    assert "compare ROS_DOMAIN_ID" in capsys.readouterr().err


def test_a_robot_without_ros_2_and_a_robot_without_the_option_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert call(["doctor", "--ros2", "pioneer_p3dx"]) == 2
    assert "has no [ros2] table" in capsys.readouterr().err
    assert call(["doctor", "pioneer_p3dx"]) == 2
    assert "rocs-bt doctor --ros2 pioneer_p3dx" in capsys.readouterr().err
