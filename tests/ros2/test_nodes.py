"""SensorNode and ActuatorNode on a network in memory: stamps, silence, faults, commands."""

from __future__ import annotations

import math
import threading
import time

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rocs_bt.base.clock import Clock
from rocs_bt.base.errors import DeviceError, InputError
from rocs_bt.cli.drive import show_sensors
from rocs_bt.control.locomotion_kinds import Axis, TurnAxis, make_locomotion
from rocs_bt.ros2.devices.actuator_node import ActuatorNode
from rocs_bt.ros2.devices.parameters import ARRAY, TWIST, TWIST_STAMPED, Ros2ActuatorParameters, Ros2SensorParameters
from rocs_bt.ros2.devices.sensor_node import SensorNode
from rocs_bt.ros2.messages.type_store import TypeStore
from rocs_bt.ros2.network.node import RosNode
from rocs_bt.ros2.network.qos import QoS, mismatch
from rocs_bt.ros2.network.transport import Endpoint
from rocs_bt.ros2.settings import Ros2Settings
from rocs_bt.running.preflight import PreflightSensor, SensorState

from ..waiting import until
from .network import START, Network

TYPES = TypeStore()
ODOMETRY = "nav_msgs/msg/Odometry"
SCAN = "sensor_msgs/msg/LaserScan"
TF = "tf2_msgs/msg/TFMessage"


class NetworkClock(Clock):
    """Clock of a run that began 100 s before the network's time 0."""

    def __init__(self, network):
        self._network = network

    def now(self):
        return 100.0 + self._network.time


@pytest.fixture
def network():
    return Network(TYPES)


@pytest.fixture
def node(network):
    return RosNode(Ros2Settings(namespace="r1", domain=0), NetworkClock(network), transport=network)


def sensor(node, max_age=math.inf, **keys):
    return SensorNode("s", node, Ros2SensorParameters(**keys), max_age=max_age)


def odometry(x):
    return {"pose": {"pose": {"position": {"x": x}, "orientation": {"w": 1.0}}}}


def test_only_the_newest_message_counts_and_has_the_time_of_its_publication(network, node):
    pose = sensor(node, type=ODOMETRY, topic="odom")
    network.time = 5.0
    network.send("/r1/odom", ODOMETRY, age=0.3, **odometry(1.0))
    network.send("/r1/odom", ODOMETRY, age=0.2, **odometry(2.0))
    reading = pose.read()
    assert list(reading.values) == [2.0, 0.0, 0.0]
    assert reading.stamp == pytest.approx(104.8)


def test_silence_repeats_the_old_stamp(network, node):
    pose = sensor(node, type=ODOMETRY, topic="/odom")
    network.send("/odom", ODOMETRY, **odometry(1.0))
    first = pose.read()
    network.time = 3.0
    assert pose.read() == first


def test_a_read_without_messages_neither_looks_nor_starts_a_thread(network, monkeypatch):
    """A look at the network takes a tenth of a second on a busy machine: one thread does it, for the node's life."""
    looked, go = [], threading.Event()
    find = network.endpoints
    monkeypatch.setattr(network, "endpoints", lambda: (looked.append(threading.current_thread()), go.wait(), find())[2])
    node = RosNode(Ros2Settings(namespace="r1", domain=0), NetworkClock(network), transport=network)
    silent = [sensor(node, type=ODOMETRY, topic=topic) for topic in ("odom", "other")]
    threads = set(threading.enumerate())
    for _ in range(100):
        for each in silent:
            with pytest.raises(DeviceError, match="nothing was received"):
                each.read()
    assert set(threading.enumerate()) <= threads
    until(lambda: looked)
    go.set()
    node.close()
    assert set(looked) <= threads - {threading.current_thread()}
    assert len(set(looked)) == 1
    assert not set(looked) & set(threading.enumerate())


def test_before_the_first_message_the_reason_of_the_silence_is_told(network, node):
    scan = sensor(node, type=SCAN, topic="scan", rays=4, span=1.0, reliability="reliable")

    def told(end):
        """The reason, once the publishers were looked up again."""
        latest = time.monotonic() + 30.0
        while True:
            with pytest.raises(DeviceError) as error:
                scan.read()
            if str(error.value).endswith(end) or time.monotonic() > latest:
                return str(error.value)
            time.sleep(0.02)

    domain = "no topic of this type was discovered in the ROS domain 0 (loopback)"
    assert told(domain) == f"nothing is published on '/r1/scan' (sensor_msgs/msg/LaserScan); {domain}"
    for endpoint, end in [
        (Endpoint("/scan", SCAN, "/lidar", True, QoS.SENSOR), "topics of this type: /scan"),
        (
            Endpoint("/r1/scan", "std_msgs/msg/String", "/lidar", True, QoS.SENSOR),
            "the node '/lidar' publishes std_msgs/msg/String, which is another type; "
            'write type = "std_msgs/msg/String", or change the other node',
        ),
        (
            Endpoint("/r1/scan", SCAN, "/lidar", True, QoS.SENSOR),
            "'/r1/scan' (sensor_msgs/msg/LaserScan): the quality of service of the node '/lidar' does not match in "
            "reliability (offered best_effort, requested reliable): it offers best_effort, volatile, depth 5, "
            'robot.toml requests reliable, volatile, depth 5; write reliability = "best_effort", '
            "or change the other node",
        ),
        (Endpoint("/r1/scan", SCAN, "/lidar", True, QoS()), "the node '/lidar' has published nothing yet"),
    ]:
        network.peers = [endpoint]
        assert told(end).endswith(end)


def test_a_slow_look_up_of_publishers_does_not_delay_the_period(network, node, monkeypatch):
    asked = threading.Event()

    def endpoints():
        asked.wait(10.0)
        return []

    monkeypatch.setattr(network, "endpoints", endpoints)
    scan = sensor(node, type=SCAN, topic="scan", rays=4, span=1.0)
    for _ in range(3):
        with pytest.raises(DeviceError, match="nothing was received on '/r1/scan'"):
            scan.read()
    asked.set()
    node.close()


def test_faulty_messages_are_counted_and_keep_the_old_reading(network, node):
    scan = sensor(node, type=SCAN, topic="scan", rays=4, span=0.3)
    good = {"angle_min": -0.15, "angle_increment": 0.1, "ranges": [1.0] * 4, "range_min": 0.1, "range_max": 5.0}
    network.send("/r1/scan", SCAN, **good)
    first = scan.read()
    network.send_raw("/r1/scan", b"\0\1\0\0abc")
    with pytest.raises(DeviceError, match="/r1/scan: 7 bytes are no sensor_msgs/msg/LaserScan"):
        scan.read()
    assert scan.read() == first
    network.send("/r1/scan", SCAN, **{**good, "ranges": [1.0] * 2})
    with pytest.raises(DeviceError, match=r"not the ray at .* \(2 faulty messages so far\)"):
        scan.read()
    network.send("/r1/scan", SCAN, age=-7.0, **good)
    with pytest.raises(DeviceError, match=r"its stamp is 7\.00 s in the future: synchronise the clocks"):
        scan.read()
    network.send("/r1/scan", SCAN, **{**good, "ranges": [1.0, math.nan, 1.0, 1.0]})
    assert math.isnan(scan.read().values[1])
    assert node.faults == {"/r1/scan": {"malformed": 1, "values": 1, "stamp": 1, "NaN": 1}}


@pytest.mark.parametrize(("max_age", "ahead"), [(0.15, 0.2), (math.inf, 0.6)])
def test_a_stamp_in_the_future_by_more_than_the_validity_is_the_reason_of_the_silence(network, node, max_age, ahead):
    pose = sensor(node, max_age, type=ODOMETRY, topic="odom")
    network.send("/r1/odom", ODOMETRY, age=-ahead, **odometry(1.0))
    for _ in range(2):  # also when no further message comes
        with pytest.raises(DeviceError, match=rf"/r1/odom: its stamp is {ahead:.2f} s in the future"):
            pose.read()
    network.send("/r1/odom", ODOMETRY, age=0.1 - ahead, **odometry(2.0))
    assert pose.read().stamp == pytest.approx(100.0)
    assert pose.clock_ahead == pytest.approx(ahead - 0.1)


@pytest.mark.parametrize(("ahead", "shown"), [(0.04, False), (0.1, True)])
def test_the_preflight_check_shows_a_clock_that_is_ahead(network, node, capsys, ahead, shown):
    pose = sensor(node, 0.15, type=ODOMETRY, topic="odom")
    known = SensorState(
        agent="R1", sensor="position", driver="ros2", source="/r1/odom", needed_for=("pose",), optional=False
    )
    network.send("/r1/odom", ODOMETRY, age=-ahead, **odometry(1.0))
    state = PreflightSensor(pose, known, 0.15).state(node.received)
    assert not state.problem
    show_sensors((state,))
    assert (f"0.00 s, clock {ahead:.2f} s ahead" in capsys.readouterr().err) is shown


def test_the_number_of_values_may_not_change(network, node):
    many = sensor(node, type=ARRAY, topic="a", paths=("data",))
    network.send("/r1/a", ARRAY, data=[1.0, 2.0])
    assert list(many.read().values) == [1.0, 2.0]
    network.send("/r1/a", ARRAY, data=[1.0])
    with pytest.raises(DeviceError, match="it has 1 values, not 2"):
        many.read()


@pytest.mark.parametrize(
    ("keys", "good", "fields"),
    [
        ({"type": ARRAY, "paths": ("data",), "length": 2}, [1.0, 2.0], {"data": [1.0]}),
        ({"type": ARRAY, "paths": ("data",), "length": 2}, [1.0, 2.0], {"data": [1.0] * 3}),
        ({"type": ARRAY, "paths": ("data[1]", "layout.data_offset")}, [2.0, 0.0], {"data": [1.0]}),
    ],
)
def test_the_declared_number_of_values_holds_from_the_first_message(network, node, keys, good, fields):
    many = sensor(node, topic="a", **keys)
    network.send("/r1/a", ARRAY, **fields)
    with pytest.raises(DeviceError, match=r"/r1/a: (it has \d values, not 2|'data\[1\]': the array has 1 elements)"):
        many.read()
    network.send("/r1/a", ARRAY, data=[1.0, 2.0])
    assert list(many.read().values) == good
    assert sum(node.faults["/r1/a"].values()) == 1


@pytest.mark.parametrize(
    ("type", "values", "length", "size"),
    [
        (ODOMETRY, ("pose.covariance", "pose.pose.position.x"), 0, 37),
        (ARRAY, ("data",), 0, None),
        (ARRAY, ("data", "layout.data_offset"), 5, 5),
    ],
)
def test_the_number_of_values_of_fields_comes_from_their_types(type, values, length, size):
    given = Ros2SensorParameters(type=type, topic="a", paths=values, length=length)
    assert given.message_size(TYPES) == size


def test_a_wrong_number_of_values_is_refused():
    given = Ros2SensorParameters(type=ODOMETRY, topic="a", paths=("pose.covariance",), length=6)
    with pytest.raises(InputError, match="length is 6, but the fields of nav_msgs/msg/Odometry have 36 values"):
        given.message_size(TYPES)


def test_values_of_several_topics_have_the_oldest_stamp(network, node):
    kind = "sensor_msgs/msg/Range"
    both = sensor(node, type=kind, topics=("left", "right"))
    network.time = 10.0
    network.send("/r1/left", kind, age=1.0, range=0.5, max_range=4.0)
    with pytest.raises(DeviceError, match="nothing was received on '/r1/right'"):
        both.read()
    network.send("/r1/right", kind, range=0.7, max_range=4.0)
    reading = both.read()
    assert (list(reading.values), reading.stamp) == (pytest.approx([0.5, 0.7]), pytest.approx(109.0))


@pytest.mark.parametrize(("seconds", "stamp"), [(START + 4.0, 104.0), (0, None), (START + 9.0, None)])
def test_stamps_of_headers(network, node, seconds, stamp):
    pose = sensor(node, type=ODOMETRY, topic="odom", stamp="header")
    network.time = 5.0
    network.send("/r1/odom", ODOMETRY, header={"stamp": {"sec": int(seconds)}}, **odometry(1.0))
    if stamp is None:
        with pytest.raises(DeviceError, match=r"/r1/odom: .*stamp"):
            pose.read()
    else:
        assert pose.read().stamp == pytest.approx(stamp)


def transform(parent, child, pose):
    x, y, z, w = pose[1].as_quat()
    place = dict(zip("xyz", pose[0], strict=True))
    return {
        "header": {"frame_id": parent},
        "child_frame_id": child,
        "transform": {"translation": place, "rotation": {"x": x, "y": y, "z": z, "w": w}},
    }


def send_tf(network, topic, *transforms, age=0.0):
    kind = "geometry_msgs/msg/TransformStamped"
    network.send(topic, TF, age=age, transforms=[TYPES.make(kind, **each) for each in transforms])


def test_poses_through_transforms_agree_with_scipy(network, node):
    rng = np.random.default_rng(3)
    chain = [(rng.normal(size=3), Rotation.random(random_state=i)) for i in range(3)]
    place = sensor(node, type=TF, topic="/tf", frame="map", child="base_link")
    yaw = sensor(node, type=TF, topic="/tf", frame="map", child="base_link", take="orientation")
    network.time = 4.0
    send_tf(network, "/tf", transform("map", "odom", chain[0]), age=2.0)
    with pytest.raises(DeviceError, match="no transforms lead from 'map' to 'base_link'; frames with transforms: odom"):
        place.read()
    send_tf(network, "/tf_static", transform("base", "base_link", chain[2]), age=3.0)
    send_tf(network, "/tf", transform("odom", "base", chain[1]))
    at = np.zeros(3)
    for move, turn in reversed(chain):
        at = move + turn.apply(at)
    whole = chain[0][1] * chain[1][1] * chain[2][1]
    assert list(place.read().values) == pytest.approx(at)
    assert list(yaw.read().values) == pytest.approx([whole.as_euler("xyz")[2]])
    assert place.read().stamp == pytest.approx(102.0)  # of the oldest moving transform


def test_transforms_that_are_dated_ahead_count_as_of_now(network, node):
    place = sensor(node, type=TF, topic="/tf", frame="map", child="base_link", stamp="header")
    network.time = 4.0
    ahead = transform("map", "base_link", (np.ones(3), Rotation.identity()))
    ahead["header"]["stamp"] = {"sec": int(START) + 5}
    send_tf(network, "/tf", ahead)
    reading = place.read()
    assert (list(reading.values), reading.stamp) == ([1.0, 1.0, 1.0], pytest.approx(104.0))


def test_one_faulty_message_with_transforms_does_not_hide_the_others(network, node):
    place = sensor(node, type=TF, topic="/tf", frame="map", child="base_link")
    network.send_raw("/tf", b"\0\1\0\0a")
    send_tf(network, "/tf", transform("map", "base_link", (np.ones(3), Rotation.identity())))
    assert list(place.read().values) == [1.0, 1.0, 1.0]
    assert node.faults == {"/tf": {"malformed": 1}}


def test_joints_of_another_device_on_the_same_topic_are_ignored(network, node):
    kind = "sensor_msgs/msg/JointState"
    wheels = sensor(node, type=kind, topic="joint_states", joints=("left", "right"))
    network.send("/r1/joint_states", kind, name=["elbow"], velocity=[9.0])
    with pytest.raises(DeviceError, match="no message so far is about left, right"):
        wheels.read()
    network.send("/r1/joint_states", kind, name=["left", "right"], velocity=[1.0, 2.0])
    network.send("/r1/joint_states", kind, name=["elbow"], velocity=[9.0])
    assert list(wheels.read().values) == [1.0, 2.0]
    assert node.faults == {}


def test_diagnostics_of_several_nodes_count_together_and_become_stale(network, node):
    kind = "diagnostic_msgs/msg/DiagnosticArray"
    level = sensor(node, type=kind, topic="/diagnostics")
    for name, value, sec in (("motor", 2, 10), ("battery", 0, 11), ("battery", 0, 16)):
        status = TYPES.make("diagnostic_msgs/msg/DiagnosticStatus", name=name, level=value)
        network.send("/diagnostics", kind, header={"stamp": {"sec": sec}}, status=[status])
        if sec == 11:
            assert list(level.read().values) == [2.0]
    assert list(level.read().values) == [3.0]


WHEELS = make_locomotion("differential", wheel_separation=0.4, max_wheel_speed=1.0, max_wheel_acceleration=1.0)
AXES = make_locomotion(
    "twist",
    vx=Axis(max_speed=1.0, max_acceleration=1.0),
    vy=Axis(max_speed=1.0, max_acceleration=1.0),
    wz=TurnAxis(max_speed=2.0, max_acceleration=2.0),
)


def actuator(node, locomotion, **keys):
    return ActuatorNode("wheels", node, Ros2ActuatorParameters(topic="cmd_vel", **keys), locomotion)


def test_wheels_are_published_as_the_twist_that_they_realise(network, node):
    actuator(node, WHEELS, type=TWIST).command([0.2, 0.4])
    (message,) = network.published["/r1/cmd_vel"]
    assert (message.linear.x, message.angular.z) == pytest.approx((0.3, 0.5))


def test_a_twist_is_published_with_stamp_and_frame(network, node):
    network.time = 2.5
    actuator(node, AXES, type=TWIST_STAMPED, frame="base").command([0.1, 0.2, 0.3])
    (message,) = network.published["/r1/cmd_vel"]
    assert (message.twist.linear.x, message.twist.linear.y, message.twist.angular.z) == (0.1, 0.2, 0.3)
    assert message.header.frame_id == "base"
    assert message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec == pytest.approx(START + 2.5)


def test_an_array_has_the_values_of_the_command(network, node):
    actuator(node, WHEELS, type=ARRAY, scale=10.0).command([0.2, 0.4])
    assert list(network.published["/r1/cmd_vel"][0].data) == [2.0, 4.0]


def test_the_end_publishes_neutral_several_times(network, node):
    wheels = actuator(node, WHEELS, type=TWIST)
    wheels.command([1.0, 1.0])
    wheels.neutral()
    wheels.close()
    assert [m.linear.x for m in network.published["/r1/cmd_vel"]] == [1.0, 0.0, 0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("offered", "requested", "found"),
    [
        (QoS.SENSOR, QoS.SENSOR, ""),
        (QoS.LATCHED, QoS.SENSOR, ""),
        (QoS.SENSOR, QoS.COMMAND, "reliability (offered best_effort, requested reliable)"),
        (QoS.COMMAND, QoS.LATCHED, "durability (offered volatile, requested transient_local)"),
    ],
)
def test_quality_of_service_matches_as_in_dds(offered, requested, found):
    assert mismatch(offered, requested) == found


@pytest.mark.parametrize(
    ("namespace", "name", "full"), [("", "scan", "/scan"), ("/r1", "scan", "/r1/scan"), ("r1", "/scan", "/scan")]
)
def test_relative_topics_are_in_the_namespace(namespace, name, full):
    assert Ros2Settings(namespace=namespace).topic(name) == full


def test_the_domain_of_the_environment(monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "42")
    assert Ros2Settings().domain_id == 42
    assert Ros2Settings(domain=7).domain_id == 7
    monkeypatch.setenv("ROS_DOMAIN_ID", "many")
    with pytest.raises(InputError, match="ROS_DOMAIN_ID must be a number from 0 to 232, found 'many'"):
        _ = Ros2Settings().domain_id
