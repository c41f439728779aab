"""EXP1's mission, rule file and scenario in three ways: in process, on the simulator over ROS 2, on a robot of rclpy.

The third way is test_exp1.py, with the same files. Only the tables of drivers differ between the first and the others.
"""

from __future__ import annotations

import pytest

import rocs_bt
from benchmarks.paper.reuse import diff
from rocs_bt.declare import fields_of, values_of
from rocs_bt.ros2.devices.parameters import Ros2ActuatorParameters, Ros2SensorParameters

from .exp1 import ROBOT, SCENARIO, drive_exp1, write_project

OF_ROS = {f.key for cls in (Ros2SensorParameters, Ros2ActuatorParameters) for f in fields_of(cls)}
KEYS = {"driver", "isolated", *OF_ROS} - {"rays", "span"}  # those also belong to a simulated scanner
CHANGES = {"transport": "dds", "lidar_stamp": "source"}  # the stamps of headers are simulated time
DRIVERS = {
    "lidar": 'driver = "lidar"\nsite = "lidar"\nrange = ["0.05 m", "8 m"]\n',
    "position": 'driver = "position"\n',
    "orientation": 'driver = "orientation"\n',
    "encoders": 'driver = "wheel_speed"\nmotors = ["left_motor", "right_motor"]\nwheel_radius = "0.0975 m"\n',
    "wheels": 'driver = "velocity"\nmotors = ["left_motor", "right_motor"]\nwheel_radius = "0.0975 m"\n',
}
SITE = '<site name="lidar" pos="0 0 0.11"/>'  # above the wheels, and below the deck of another robot


def simulated():
    """robot.toml with the drivers of MuJoCo in place of those of ROS 2."""
    head, *tables = ROBOT.split("\n[")
    kept = [head.replace('doc = "', 'model = "robot.xml"\ndoc = "')]
    for table in tables:
        name = next((n for n in DRIVERS if f'\nname = "{n}"' in table and 'driver = "ros2"' in table), None)
        if name is not None:
            lines = [line for line in table.splitlines() if line.partition(" = ")[0] not in KEYS]
            table = "\n".join(lines) + "\n" + DRIVERS[name]
        if not table.startswith("ros2]"):
            kept.append(table)
    return "\n[".join(kept)


@pytest.fixture
def catalog(tmp_path):
    catalog = write_project(tmp_path, **CHANGES)
    model = catalog.load_robot("pioneer_p3dx").model.read_text()
    (tmp_path / "robots/own_simulated").mkdir()
    (tmp_path / "robots/own_simulated/robot.toml").write_text(simulated())
    (tmp_path / "robots/own_simulated/robot.xml").write_text(
        model.replace('<site name="sonar0"', f'{SITE}<site name="sonar0"')
    )
    (tmp_path / "scenarios/simulated.toml").write_text(SCENARIO.replace('"own"', '"own_simulated"'))
    return rocs_bt.Catalog(tmp_path)


def test_only_the_tables_of_drivers_differ(catalog):
    ros, mujoco = (catalog.load_robot(name) for name in ("own", "own_simulated"))
    for name in ("motion", "body"):
        assert getattr(ros, name) == getattr(mujoco, name)
    of_driver = ("driver", "parameters", "line", "positions", "isolated", "size")
    for kind in ("sensors", "monitors", "analyzers", "actuators"):
        for one, other in zip(getattr(ros, kind), getattr(mujoco, kind), strict=True):
            fields = [name for name in values_of(one) if not (hasattr(one, "driver") and name in of_driver)]
            assert [getattr(one, name) for name in fields] == [getattr(other, name) for name in fields]
    assert {device.driver for device in (*ros.sensors, *ros.actuators)} == {"ros2"}


def test_the_diff_shows_only_other_drivers(catalog):
    found = diff(*(catalog.load_scenario(name) for name in ("simulated", "real")), catalog)
    assert [share.kind for share in found.content if not share.same] == ["scenario", "robot"]
    assert [share.kind for share in found.code if not share.same] == ["devices", "ros2"]
    assert {setting.what for setting in found.settings if not setting.same} == set()
    assert [robot.differing() for robot in found.robots] == [("robot",), ()]


def test_the_mission_succeeds_in_process_and_on_the_simulator(catalog, simulator, tmp_path):
    in_process = rocs_bt.run("simulated", catalog).summary.agents["R2"]
    process = simulator("simulated", "--namespace", "r1")
    over_ros = drive_exp1(tmp_path, **CHANGES).summary.agents["R2"]
    process.end()
    assert (in_process.outcome, over_ros.outcome) == ("success", "success")
    assert (in_process.collisions, over_ros.collisions) == (0, None)
    assert "collision" not in process.errors
    assert (in_process.mission, in_process.rules) == (over_ros.mission, over_ros.rules)
