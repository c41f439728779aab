"""Short forms of message types: what a sensor takes from a message."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from rocs_bt.base.errors import DeviceError, InputError
from rocs_bt.ros2.devices.parameters import TAKES, TRANSFORMS, Ros2SensorParameters
from rocs_bt.ros2.messages.forms import make_take
from rocs_bt.ros2.messages.message_types import MessageTypes

TYPES = MessageTypes()
SCAN = "sensor_msgs/msg/LaserScan"


def take(type, fields, **keys):
    wanted = Ros2SensorParameters(type=type, topic="t", **keys)
    message = TYPES.deserialize(TYPES.serialize(TYPES.make(type, **fields)), type)
    return make_take(TYPES, wanted)(message)


def scan(ranges, first, step, rays, span, low=0.1, high=10.0):
    fields = {"angle_min": first, "angle_increment": step, "ranges": ranges, "range_min": low, "range_max": high}
    return take(SCAN, fields, rays=rays, span=span)


@st.composite
def scanners(draw):
    """A scanner and the rays that are wanted of it, which it covers."""
    count = draw(st.integers(40, 400))
    span = math.radians(draw(st.integers(90, 359)))
    step = span / (count - 1)
    rays = draw(st.integers(10, 200))
    wanted = span * draw(st.floats(0.3, 1.0))
    ranges = draw(st.lists(st.sampled_from([0.5, 1.0, 3.0, math.inf, math.nan]), min_size=count, max_size=count))
    turned = draw(st.booleans())
    first = 0.5 * span if turned else -0.5 * span
    return ranges, first, -step if turned else step, rays, wanted


@given(scanners())
def test_a_ray_has_the_smallest_valid_range_of_the_beams_nearest_to_it(case):
    ranges, first, step, rays, span = case
    found = scan(ranges, first, step, rays, span)
    spacing = span / (rays - 1)
    beams = [first + step * i for i in range(len(ranges))]
    for ray, value in enumerate(found):
        bearing = ray * spacing - 0.5 * span
        off = [abs(beam - bearing) for beam in beams]
        near = [r for r, o in zip(ranges, off, strict=True) if o < 0.5 * spacing - 1e-5]
        inside = [r for r, o in zip(ranges, off, strict=True) if o < max(0.5 * spacing, abs(step)) + 1e-5]
        valid = [r for r in near if not math.isnan(r)]
        if valid and math.isfinite(min(valid)):  # no echo of the sector may be lost
            assert value <= min(valid) + 1e-5
        if math.isnan(value):  # an invalid beam, and no echo
            assert any(map(math.isnan, inside))
            assert not any(map(math.isfinite, near))
        else:
            assert any(abs(value - r) < 1e-5 or value == r for r in inside)
            assert math.isfinite(value) or not any(map(math.isnan, near))


def test_a_scan_from_0_to_360_degrees_is_turned_to_the_rays_around_the_robot():
    ranges = [2.0] * 360
    ranges[90] = 0.5  # to the left
    found = scan(ranges, 0.0, math.radians(1.0), 360, math.radians(359.0))
    bearings = np.linspace(-179.5, 179.5, 360)
    assert set(np.round(bearings[np.array(found) < 1.0])) <= {89.0, 90.0, 91.0}
    assert min(found) == 0.5


def test_ranges_outside_of_the_limits():
    assert scan([0.05, 0.0, 11.0, math.inf, math.nan], -0.2, 0.1, 5, 0.4) == pytest.approx(
        [0.1, 0.1, math.inf, math.inf, math.nan], nan_ok=True
    )


@pytest.mark.parametrize(("zero", "value"), [("minimum", 0.1), ("no_echo", math.inf), ("invalid", math.nan)])
def test_a_range_of_0_means_what_robot_toml_says(zero, value):
    fields = {"angle_min": -0.1, "angle_increment": 0.1, "ranges": [0.0] * 3, "range_min": 0.1, "range_max": 5.0}
    assert take(SCAN, fields, rays=3, span=0.2, zero=zero) == pytest.approx([value] * 3, nan_ok=True)


@given(st.sampled_from(["invalid", "no_echo"]), st.lists(st.sampled_from([0.5, 3.0, math.nan]), min_size=3, max_size=3))
def test_a_range_of_nan_means_what_robot_toml_says(nan, ranges):
    meaning = math.inf if nan == "no_echo" else math.nan
    expected = [meaning if math.isnan(value) else value for value in ranges]
    fields = {"angle_min": -0.1, "angle_increment": 0.1, "ranges": ranges, "range_min": 0.1, "range_max": 5.0}
    assert take(SCAN, fields, rays=3, span=0.2, nan=nan) == pytest.approx(expected, nan_ok=True)
    for value, wanted in zip(ranges, expected, strict=True):
        fields = {"range": value, "min_range": 0.1, "max_range": 5.0}
        assert take("sensor_msgs/msg/Range", fields, nan=nan) == pytest.approx([wanted], nan_ok=True)


@pytest.mark.parametrize(("zero", "value"), [("minimum", 0.1), ("no_echo", math.inf), ("invalid", math.nan)])
def test_a_single_range_of_0_means_what_robot_toml_says(zero, value):
    fields = {"range": 0.0, "min_range": 0.1, "max_range": 5.0}
    assert take("sensor_msgs/msg/Range", fields, zero=zero) == pytest.approx([value], nan_ok=True)


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        ({"angle_min": -0.5, "angle_increment": 0.1, "ranges": [1.0] * 11}, "covers -29 to 29 deg, not the ray at -"),
        ({"angle_min": -0.5, "angle_increment": 0.0, "ranges": [1.0] * 11}, "11 beams"),
        ({"angle_min": 0.0, "angle_increment": 0.1, "ranges": []}, "0 beams"),
    ],
)
def test_a_scan_that_does_not_fit_is_a_fault(fields, text):
    with pytest.raises(DeviceError, match=text):
        take(SCAN, fields, rays=180, span=math.pi)


angles = st.floats(-3.0, 3.0)


@given(angles, st.floats(-1.5, 1.5), angles)
def test_poses_agree_with_scipy(roll, pitch, yaw):
    x, y, z, w = Rotation.from_euler("xyz", [roll, pitch, yaw]).as_quat()
    pose = {"position": {"x": 1.0, "y": -2.0, "z": 0.5}, "orientation": {"x": x, "y": y, "z": z, "w": w}}
    odometry = {"pose": {"pose": pose}}
    assert take("nav_msgs/msg/Odometry", odometry, take="position") == [1.0, -2.0, 0.5]
    assert take("geometry_msgs/msg/PoseStamped", {"pose": pose}, take="orientation") == pytest.approx([yaw], abs=1e-6)
    assert take("geometry_msgs/msg/PoseWithCovarianceStamped", odometry, take="attitude") == pytest.approx(
        [roll, pitch], abs=1e-6
    )


IMU = {"orientation": {"w": 1.0}, "angular_velocity": {"z": 0.3}, "linear_acceleration": {"z": 9.8}}


@pytest.mark.parametrize(
    ("type", "fields", "keys", "values"),
    [
        ("sensor_msgs/msg/Range", {"range": 0.4, "min_range": 0.1, "max_range": 4.0}, {}, [0.4]),
        ("sensor_msgs/msg/Range", {"range": 0.05, "min_range": 0.1, "max_range": 4.0}, {}, [0.1]),
        ("sensor_msgs/msg/Range", {"range": 4.5, "min_range": 0.1, "max_range": 4.0}, {}, [math.inf]),
        ("sensor_msgs/msg/Imu", IMU, {}, [0.3]),
        ("sensor_msgs/msg/Imu", IMU, {"take": "acceleration"}, [0.0, 0.0, 9.8]),
        ("sensor_msgs/msg/Imu", IMU, {"take": "orientation"}, [0.0]),
        (
            "nav_msgs/msg/Odometry",
            {"twist": {"twist": {"linear": {"x": 0.5, "y": 0.1}, "angular": {"z": -0.2}}}},
            {"take": "twist"},
            [0.5, 0.1, 0.0, -0.2],
        ),
        (
            "sensor_msgs/msg/JointState",
            {"name": ["a", "left", "right"], "velocity": [9.0, 2.0, 4.0]},
            {"joints": ("right", "left"), "wheel_radius": 0.1},
            [0.4, 0.2],
        ),
        ("sensor_msgs/msg/BatteryState", {"percentage": 0.5, "voltage": 12.0}, {}, [0.5]),
        ("sensor_msgs/msg/BatteryState", {"percentage": 0.5, "voltage": 12.0}, {"take": "voltage"}, [12.0]),
        ("std_msgs/msg/Bool", {"data": True}, {}, [1.0]),
        ("std_msgs/msg/Float64", {"data": 0.25}, {}, [0.25]),
        ("std_msgs/msg/String", {"data": "docked"}, {"words": ("idle", "docked")}, [1.0]),
        ("std_msgs/msg/String", {"data": "?"}, {"words": ("idle", "docked")}, [math.nan]),
        (
            "diagnostic_msgs/msg/DiagnosticArray",
            {"status": [{"name": "motor left", "level": 2}, {"name": "battery", "level": 1}]},
            {"status": "batt"},
            [1.0],
        ),
        (
            "geometry_msgs/msg/PoseWithCovarianceStamped",
            {"pose": {"covariance": [0.04, *[0.0] * 6, 0.01, *[0.0] * 28]}},
            {"take": "spread"},
            [0.2],
        ),
        ("geometry_msgs/msg/Polygon", {"points": [{"x": 1.0}, {"x": 7.0}]}, {"values": ("points[1].x",)}, [7.0]),
        ("std_msgs/msg/Float64MultiArray", {"data": [1.0, 2.0]}, {"values": ("data",)}, [1.0, 2.0]),
    ],
)
def test_values(type, fields, keys, values):
    assert take(type, fields, **keys) == pytest.approx(values, rel=1e-6, nan_ok=True)


@pytest.mark.parametrize(
    ("type", "fields", "keys", "text"),
    [
        ("nav_msgs/msg/Odometry", {}, {}, "no unit quaternion"),
        ("sensor_msgs/msg/JointState", {"name": ["a", "c"]}, {"joints": ("a", "b")}, "no joint 'b', but a, c"),
        ("sensor_msgs/msg/JointState", {"name": ["a"]}, {"joints": ("a",)}, "velocity has 0 values for 1 joints"),
        ("sensor_msgs/msg/Imu", {"orientation_covariance": [-1.0] + [0.0] * 8}, {"take": "attitude"}, "does not estim"),
        ("geometry_msgs/msg/Polygon", {"points": []}, {"values": ("points[1].x",)}, "the array has 0 elements"),
        ("std_msgs/msg/String", {"data": "a"}, {"values": ("data",)}, "has no numbers, found 'a'"),
    ],
)
def test_a_message_without_the_values_is_a_fault(type, fields, keys, text):
    with pytest.raises(DeviceError, match=text):
        take(type, fields, **keys)


@pytest.mark.parametrize(
    ("path", "text"),
    [
        ("rangs", r"no field is named 'rangs'\. Did you mean 'ranges'"),
        ("header.stamp.sec.x", "has no fields"),
        ("angle_min[0]", "is no array"),
    ],
)
def test_a_path_is_checked_against_the_type(path, text):
    with pytest.raises(InputError, match=text):
        make_take(TYPES, Ros2SensorParameters(type=SCAN, topic="t", values=(path,)))


@pytest.mark.parametrize(("type", "name"), [(t, n) for t, takes in TAKES.items() for n in takes if t != TRANSFORMS])
def test_every_short_form_has_the_declared_number_of_values(type, name):
    keys = {"rays": 4, "span": 0.3, "joints": ("a", "b"), "words": ("a",)}
    own = {SCAN: ("rays", "span"), "sensor_msgs/msg/JointState": ("joints",), "std_msgs/msg/String": ("words",)}
    given = {key: keys[key] for key in own.get(type, ())}
    fields = {
        SCAN: {"angle_min": -0.15, "angle_increment": 0.1, "ranges": [1.0] * 4},
        "sensor_msgs/msg/JointState": {"name": ["a", "b"], name: [1.0, 2.0]},
    }.get(type, {})
    unit = {"orientation": {"w": 1.0}}
    if "Pose" in type or "Odometry" in type:
        fields = {"pose": unit if type.endswith("PoseStamped") else {"pose": unit}}
    if type.endswith("Imu"):
        fields = unit
    expected = Ros2SensorParameters(type=type, topic="t", take=name, **given).size
    assert len(take(type, fields, take=name, **given)) == expected
