"""`rocs-bt check` of a robot with `driver = "ros2"`: message types and fields, without a network and without MuJoCo."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.check import check_content, check_scenario
from rocs_bt.declare import replaced
from rocs_bt.ros2.devices.check import ros2_faults
from rocs_bt.ros2.messages.message_types import MESSAGES

from .. import needs

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
    needs.package("rosbags")
    assert faults(tmp_path, type="sensor_msgs/msg/Range", path="range") == []


@pytest.mark.parametrize(
    ("keys", "wanted"),
    [
        ({"type": "sensor_msgs/msg/Sonar", "path": "range"}, "no message type is named 'sensor_msgs/msg/Sonar'"),
        ({"type": "sensor_msgs/msg/Range", "path": "distance"}, "no field is named 'distance'"),
        ({"type": "sensor_msgs/msg/Range", "path": "range[0]"}, "'range' is of type float32, not an array"),
    ],
)
def test_unknown_types_and_fields_are_faults_at_the_sensor(tmp_path: Path, keys: dict[str, str], wanted: str) -> None:
    needs.package("rosbags")
    (fault,) = faults(tmp_path, **keys)
    assert fault.startswith(":4: ")
    assert wanted in fault


def test_a_sensor_of_each_type_that_has_a_short_form_is_checked(tmp_path: Path) -> None:
    needs.package("rosbags")
    robot = Catalog().load_robot("pioneer_p3dx")
    sensor = robot.sensors[0]
    for name, message in MESSAGES.items():
        for take in message.sizes:
            each = replaced(sensor, driver="ros2", parameters={"type": name, "take": take, "topic": "a"})
            for fault in ros2_faults(replaced(robot, sensors=(each,))):
                assert "need" in fault.message, (name, take, fault)  # a key of this type


SCENARIO = (
    'format = "scenario/2"\nbase = "exp1_ros2"\n[[agent]]\nname = "R2"\nrobot = "pioneer_p3dx_ros2"\nrules = {}\n'
)


def warnings(folder: Path, rules: str) -> list[str]:
    """Warnings of `rocs-bt drive`, which are also those of `rocs-bt check`, about agents with these rule files."""
    file = folder / "scenarios" / "mine.toml"
    file.parent.mkdir(exist_ok=True)
    file.write_text(SCENARIO.format(rules))
    catalog = Catalog.here(folder)
    found = [str(fault) for fault in check_scenario("mine", catalog).warnings if "stops the robot" in fault.message]
    assert [fault for fault in map(str, check_content([file]).faults) if "stops the robot" in fault] == found
    return found


def test_ranges_and_poses_without_which_no_rule_stops_the_robot_are_warned_of(tmp_path: Path) -> None:
    ranges, pose = warnings(tmp_path, "[]")
    assert "no rule of 'R2' stops the robot while 'sonar' is invalid, without sonar." in ranges
    assert "no rule of 'R2' stops the robot while 'pose' is invalid, without position, orientation." in pose
    rules = tmp_path / "rules" / "blind.toml"
    rules.parent.mkdir()
    written = [warning.partition("to a rule file: ")[2] for warning in (ranges, pose)]
    rules.write_text("\n".join(['format = "reflex/1"', 'doc = "Stops."', *written]))
    assert warnings(tmp_path, '["blind"]') == []
    rules.write_text(rules.read_text().replace('"trip"', '"clear"'))
    assert len(warnings(tmp_path, '["blind"]')) == 2


def test_the_shipped_scenario_stops_without_its_sensors(tmp_path: Path) -> None:
    assert warnings(tmp_path, '["avoid_collision"]') == []


def test_without_the_extra_the_rest_is_checked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rosbags", None)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert faults(tmp_path, type="sensor_msgs/msg/Range", path="nothing") == []
