"""`rocs-bt check` of a robot with `driver = "ros2"`: message types and fields, without a network and without MuJoCo."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from rocs_bt.check import check_content

ROBOT = """\
format = "robot/3"
base = "pioneer_p3dx"
[ros2]
[[sensor]]
name = "sonar"
driver = "ros2"
topics = ["a", "b"]
type = "{type}"
values = ["{path}"]
"""


def faults(folder: Path, **keys: str) -> list[str]:
    file = folder / "robots" / "mine" / "robot.toml"
    file.parent.mkdir(parents=True)
    file.write_text(ROBOT.format(**keys))
    return [str(fault).removeprefix(str(file)) for fault in check_content([file]).faults]


def test_types_and_fields_that_exist_are_fine(tmp_path: Path) -> None:
    pytest.importorskip("rosbags", reason="needs the extra ros2")
    assert faults(tmp_path, type="sensor_msgs/msg/Range", path="range") == []


@pytest.mark.parametrize(
    ("keys", "wanted"),
    [
        ({"type": "sensor_msgs/msg/Sonar", "path": "range"}, "no message type is named 'sensor_msgs/msg/Sonar'"),
        ({"type": "sensor_msgs/msg/Range", "path": "distance"}, "no field is named 'distance'"),
        ({"type": "sensor_msgs/msg/Range", "path": "range[0]"}, "the field before [0] is no array"),
    ],
)
def test_unknown_types_and_fields_are_faults_at_the_sensor(tmp_path: Path, keys: dict[str, str], wanted: str) -> None:
    pytest.importorskip("rosbags", reason="needs the extra ros2")
    (fault,) = faults(tmp_path, **keys)
    assert fault.startswith(":4: ")
    assert wanted in fault


def test_without_the_extra_the_rest_is_checked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rosbags", None)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert faults(tmp_path, type="sensor_msgs/msg/Range", path="nothing") == []
