"""Short forms of message types: what a sensor takes from a message is what was made into it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.base.errors import DeviceError, InputError
from rocs_bt.base.geometry import Pose3
from rocs_bt.ros2.devices.parameters import Ros2SensorParameters
from rocs_bt.ros2.messages.message_types import MESSAGES, SCAN, Channel, pose_values
from rocs_bt.ros2.messages.type_store import TypeStore

TYPES = TypeStore()
KEYS = {"rays": 5, "span": 1.0, "joints": ("a", "b"), "words": ("idle", "docked")}
CHANNEL = Channel("map", "base_link", -0.5, 0.25, names=("a", "b"), words=KEYS["words"])
DOMAINS = {  # of random values; others are normal numbers
    "ranges": lambda rng, n: rng.choice([0.5, 3.25, math.inf, math.nan], n),
    "orientation": lambda rng, n: rng.uniform(-3.1, 3.1, n),
    "attitude": lambda rng, n: rng.uniform(-1.5, 1.5, n),
    "word": lambda rng, n: rng.integers(0, 2, n),
    "level": lambda rng, n: rng.integers(0, 3, n),
    **dict.fromkeys(("range", "spread"), lambda rng, n: rng.uniform(0.0, 5.0, n)),
}


def draw(rng, type, taken, size):
    """Random values that a sensor takes."""
    if type.endswith("Bool"):
        return rng.integers(0, 2, size).tolist()
    return DOMAINS.get(taken, lambda rng, n: rng.normal(0.0, 3.0, n))(rng, size)[-size:].tolist()


def sensor(type, **keys):
    return Ros2SensorParameters(type=type, topic="t", **{k: KEYS[k] for k in KEYS if k in MESSAGES[type].keys} | keys)


def take(type, fields, **keys):
    message = TYPES.deserialize(TYPES.serialize(TYPES.make(type, **fields)), type)
    return Ros2SensorParameters(type=type, topic="t", **keys).make_take(TYPES)(message)


@pytest.mark.parametrize("kind", MESSAGES.values(), ids=MESSAGES)
def test_what_is_taken_is_what_was_made(kind):
    rng = np.random.default_rng(0)
    sizes = {taken: sensor(kind.type, take=taken).size for taken in kind.sizes}
    for _ in range(20):
        values = {taken: draw(rng, kind.type, taken, size) for taken, size in sizes.items()}
        if "height" in values:
            values["height"] = values["position"][2:]
        if "level" in values:  # two statuses, of which the worst counts
            values["level"] = [0.0, *values["level"]]
        for made in (values, *({taken: each} for taken, each in values.items())):
            message = TYPES.make(kind.type, **kind.make(7.0, made, CHANNEL))
            message = TYPES.deserialize(TYPES.serialize(message), kind.type)
            assert not hasattr(message, "header") or message.header.stamp.sec == 7
            for taken, each in made.items():
                found = sensor(kind.type, take=taken).make_take(TYPES)(message)
                assert found == pytest.approx(each[-sizes[taken] :], rel=1e-6, abs=1e-6, nan_ok=True), taken


POSE = Pose3(1.0, -2.0, 0.5, 0.1, -0.2, 2.0)
W, *XYZ = POSE.quaternion
AT = {"position": {"x": 1.0, "y": -2.0, "z": 0.5}, "orientation": dict(zip("xyz", XYZ, strict=True), w=W)}
POSES = {"position": [1.0, -2.0, 0.5], "height": [0.5], "orientation": [2.0], "attitude": [0.1, -0.2]}
IMU = {"orientation": AT["orientation"], "angular_velocity": {"z": 0.3}, "linear_acceleration": {"y": 1.0, "z": 9.8}}
TWIST = {"linear": {"x": 0.5, "y": 0.1, "z": 0.3}, "angular": {"x": 9.0, "z": -0.2}}
EXAMPLES = {  # fields of a message by the definition of its type, and its values
    "sensor_msgs/msg/LaserScan": (
        {"angle_min": -0.5, "angle_increment": 0.25, "ranges": [1.0, 2.0, 3.0, 4.0, 5.0]},
        {"ranges": [1.0, 2.0, 3.0, 4.0, 5.0]},
    ),
    "sensor_msgs/msg/Range": ({"range": 0.4, "min_range": 0.1, "max_range": 4.0}, {"range": [0.4]}),
    "sensor_msgs/msg/Imu": (
        IMU,
        {"turn_rate": [0.3], "acceleration": [0.0, 1.0, 9.8], "orientation": [2.0], "attitude": [0.1, -0.2]},
    ),
    "nav_msgs/msg/Odometry": (
        {"pose": {"pose": AT}, "twist": {"twist": TWIST}},
        {**POSES, "twist": [0.5, 0.1, 0.3, -0.2]},
    ),
    "sensor_msgs/msg/JointState": (
        {"name": ["x", "b", "a"], "velocity": [9.0, 2.0, 4.0], "position": [0.0, 0.1, 0.2], "effort": [0.0, 7.0, 8.0]},
        {"velocity": [4.0, 2.0], "position": [0.2, 0.1], "effort": [8.0, 7.0]},
    ),
    "geometry_msgs/msg/PoseWithCovarianceStamped": (
        {"pose": {"pose": AT, "covariance": [0.04, *[0.0] * 6, 0.01, *[0.0] * 28]}},
        {**POSES, "spread": [0.2]},
    ),
    "geometry_msgs/msg/PoseStamped": ({"pose": AT}, POSES),
    "sensor_msgs/msg/BatteryState": (
        {"percentage": 0.5, "voltage": 12.0, "current": -1.5},
        {"percentage": [0.5], "voltage": [12.0], "current": [-1.5]},
    ),
    "diagnostic_msgs/msg/DiagnosticArray": (
        {"status": [{"name": "motor left", "level": 2}, {"name": "battery", "level": 1}]},
        {"level": [2.0]},
    ),
    "std_msgs/msg/Bool": ({"data": True}, {"data": [1.0]}),
    "std_msgs/msg/Float64": ({"data": 0.25}, {"data": [0.25]}),
    "std_msgs/msg/String": ({"data": "docked"}, {"word": [1.0]}),
    "tf2_msgs/msg/TFMessage": (
        {
            "transforms": [
                {
                    "header": {"frame_id": "map"},
                    "child_frame_id": "base_link",
                    "transform": {"translation": AT["position"], "rotation": AT["orientation"]},
                }
            ]
        },
        POSES,
    ),
}


def test_values_of_a_pose():
    assert {name: list(each) for name, each in pose_values(POSE).items()}.items() <= POSES.items()


@pytest.mark.parametrize("type", EXAMPLES)
def test_values_come_from_the_fields_that_the_definition_names(type):
    fields, values = EXAMPLES[type]
    assert values.keys() == MESSAGES[type].sizes.keys()
    message = TYPES.make(type, **fields)
    for taken, each in values.items():
        assert sensor(type, take=taken).make_take(TYPES)(message) == pytest.approx(each, rel=1e-6), taken


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


@pytest.mark.parametrize("zero", ["minimum", "no_echo", "invalid"])
@pytest.mark.parametrize("nan", ["no_echo", "invalid"])
def test_ranges_of_0_and_nan_mean_what_robot_toml_says(zero, nan):
    ranges, meaning = [0.5, 0.0, math.nan, 9.0, 0.05], {"minimum": 0.1, "no_echo": math.inf, "invalid": math.nan}
    expected = [0.5, meaning[zero], meaning[nan], math.inf, 0.1]
    fields = {"angle_min": -0.2, "angle_increment": 0.1, "ranges": ranges, "range_min": 0.1, "range_max": 5.0}
    found = take(SCAN, fields, zero=zero, nan=nan, rays=5, span=0.4)
    single = [{"range": value, "min_range": 0.1, "max_range": 5.0} for value in ranges]
    for each in (found, [take("sensor_msgs/msg/Range", fields, zero=zero, nan=nan)[0] for fields in single]):
        assert each == pytest.approx(expected, nan_ok=True)


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


@pytest.mark.parametrize(
    ("type", "fields", "keys", "text"),
    [
        ("nav_msgs/msg/Odometry", {}, {}, "no unit quaternion"),
        ("sensor_msgs/msg/JointState", {"name": ["a", "c"]}, {"joints": ("a", "b")}, "no joint 'b', but a, c"),
        ("sensor_msgs/msg/JointState", {"name": ["a"]}, {"joints": ("a",)}, "velocity has 0 values for 1 joints"),
        ("sensor_msgs/msg/Imu", {"orientation_covariance": [-1.0] + [0.0] * 8}, {"take": "attitude"}, "does not estim"),
        ("geometry_msgs/msg/Polygon", {"points": []}, {"paths": ("points[1].x",)}, "the array has 0 elements"),
        ("std_msgs/msg/String", {"data": "a"}, {"paths": ("data",)}, "has no numbers, found 'a'"),
    ],
)
def test_a_message_without_the_values_is_a_fault(type, fields, keys, text):
    with pytest.raises(DeviceError, match=text):
        take(type, fields, **keys)


@pytest.mark.parametrize(
    ("path", "text"),
    [
        ("rangs", r"no field is named 'rangs'\. Did you mean 'ranges'"),
        ("header.stamp.sec.x", "'header.stamp.sec' is of type int32 and has no field 'x'"),
        (r"angle_min[0]", "'angle_min' is of type float32, not an array"),
    ],
)
def test_a_path_is_checked_against_the_type(path, text):
    with pytest.raises(InputError, match=text):
        Ros2SensorParameters(type=SCAN, topic="t", paths=(path,)).make_take(TYPES)
