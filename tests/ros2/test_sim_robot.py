"""Simulated robots on ROS 2, without a network: what they publish is the world's truth, and they obey cmd_vel."""

import math
from collections import defaultdict, deque

import numpy as np
import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose3
from rocs_bt.catalog import Catalog
from rocs_bt.event import CommandExpired, ContactBegan, ListSink
from rocs_bt.ros2.messages.frames import Frames
from rocs_bt.ros2.messages.type_store import TypeStore
from rocs_bt.ros2.network.qos import QoS
from rocs_bt.ros2.network.transport import Sample
from rocs_bt.ros2.sim.outputs import SENSORS
from rocs_bt.ros2.sim.simulation import Ros2Simulation

TYPES = TypeStore()
SCENARIO = """
format = "scenario/2"
world = "{world}"
duration = "60 s"
[[place]]
name = "goal"
kind = "goal"
x = "0 m"
y = "0 m"
"""
AGENT = """
[[agent]]
name = "{name}"
robot = "{robot}"
mission = "go_to"
x = "{x} m"
y = "{y} m"
yaw = "{yaw} rad"
parameters = {{ goal = "goal" }}
"""


class Wire:
    """Transport that keeps what is written, and hands over what a test sends."""

    types, name = TYPES, "wire"

    def __init__(self):
        self.written, self.qos, self.waiting = defaultdict(list), {}, defaultdict(deque)
        self.others = []

    def writer(self, topic, type, qos):
        assert topic not in self.qos, "two publishers"
        self.qos[topic] = qos
        return _Writer(self.written[topic], type)

    def reader(self, topic, type, qos):
        return _Reader(self.waiting[topic], type)

    def endpoints(self):
        return self.others

    def command(self, topic, forward, turn=0.0, left=0.0):
        twist = {"linear": {"x": forward, "y": left}, "angular": {"z": turn}}
        message = TYPES.make("geometry_msgs/msg/TwistStamped", twist=twist)
        self.waiting[topic].append(Sample(TYPES.serialize(message), 0.0))


class _Writer:
    def __init__(self, written, type):
        self.written, self.type = written, type

    def write(self, data):
        self.written.append(TYPES.deserialize(data, self.type))


class _Reader:
    def __init__(self, waiting, type):
        self.waiting, self.type = waiting, type

    def take(self):
        newest = self.waiting[-1] if self.waiting else None
        self.waiting.clear()
        return newest


class Stage:
    """A simulation of some robots on a wire.

    Args:
        folder: Folder for the scenario.
        robots: Robots with x, y, yaw, by the agent's name.
    """

    def __init__(self, folder, robots, world="arena_box", **options):
        (folder / "scenarios").mkdir(exist_ok=True)
        agents = (AGENT.format(name=n, robot=r, x=x, y=y, yaw=yaw) for n, (r, x, y, yaw) in robots.items())
        (folder / "scenarios/stage.toml").write_text(SCENARIO.format(world=world) + "".join(agents))
        catalog = Catalog.here(folder)
        self.wire, self.sink = Wire(), ListSink()
        spec = catalog.load_scenario("stage")
        self.simulation = Ros2Simulation(spec, catalog, self.wire, self.sink, rate=0.0, **options)
        self.world = self.simulation.simulated.world

    def run(self, until):
        return self.simulation.run(until)

    def last(self, topic):
        return self.wire.written[topic][-1]

    def events(self, kind):
        return [event for event in self.sink.events if isinstance(event, kind)]


def time_of(stamp):
    return stamp.sec + 1e-9 * stamp.nanosec


def pose_of(position, q):
    return Pose3.from_quaternion((position.x, position.y, position.z), (q.w, q.x, q.y, q.z))


def frames_of(*messages):
    """Frames of transform messages."""
    frames = Frames()
    for message in messages:
        frames.add(message, 0.0)
    return frames


def test_odometry_and_tf_of_ideal_sensors_are_the_truth(project):
    stage = Stage(project, {"R2": ("jackal", -1.5, -1.0, 0.5)})
    stage.wire.command("/cmd_vel", 0.4, 0.5)
    truth = {}
    output = stage.simulation.robots[0].outputs[0]
    publish = output.publish

    def watched():
        truth[round(stage.world.stamp, 6)] = stage.world.pose3("R2"), stage.world.twist3("R2")
        publish()

    output.publish = watched
    stage.run(0.5)
    messages = stage.wire.written["/odom"]
    assert len(messages) == 10  # 20 Hz
    moves = [m for m in stage.wire.written["/tf"] if m.transforms[0].header.frame_id == "odom"]
    for odom, tf in zip(messages, moves, strict=True):
        pose, twist = truth[round(time_of(odom.header.stamp), 6)]
        assert (odom.header.frame_id, odom.child_frame_id) == ("odom", "base_link")
        assert pose_of(odom.pose.pose.position, odom.pose.pose.orientation) == pytest.approx(pose, abs=1e-9)
        assert odom.twist.twist.linear.x == pytest.approx(twist.forward)
        assert odom.twist.twist.angular.z == pytest.approx(twist.turn)
        (each,) = tf.transforms
        assert (each.header.frame_id, each.child_frame_id) == ("odom", "base_footprint")
        assert each.header.stamp == odom.header.stamp
        chain = frames_of(tf, stage.last("/tf_static"))
        place, turn, _ = chain.pose("odom", "base_link")
        assert Pose3.from_quaternion(place, turn) == pytest.approx(pose, abs=1e-9)
    assert messages[-1].twist.twist.linear.x > 0.2
    assert messages[-1].twist.twist.angular.z > 0.2
    clocks = [time_of(m.clock) for m in stage.wire.written["/clock"]]
    assert clocks == pytest.approx([0.01 * i for i in range(1, 51)])
    joints = stage.last("/joint_states")
    assert all(speed > 1.0 for speed in joints.velocity)
    assert len(joints.name) == 4


def test_encoders_of_a_robot_without_ground_truth_are_odometry_that_begins_at_zero(project):
    stage = Stage(project, {"R2": ("summit_xl_localised", -1.5, -1.5, 0.7)})
    start = stage.world.pose("R2")
    stage.wire.command("/cmd_vel", 0.3, 0.3)
    stage.run(0.55)
    first, last = stage.wire.written["/odom"][0].pose.pose, stage.wire.written["/odom"][-1].pose.pose
    assert (first.position.x, first.position.y, first.orientation.w) == (0.0, 0.0, 1.0)
    assert first.position.z == pytest.approx(stage.world.pose3("R2").z, abs=2e-3)
    now = start.compose(pose_of(last.position, last.orientation).plane)
    assert now.distance(stage.world.pose("R2")) < 0.02
    assert start.distance(now) > 0.05
    assert stage.last("/imu").angular_velocity.z == pytest.approx(0.3, abs=0.15)
    assert stage.last("/imu").orientation_covariance[0] == -1.0
    fix = stage.last("/pose")  # 2 Hz, with noise
    assert len(stage.wire.written["/pose"]) == 2
    assert fix.header.frame_id == "map"
    assert "odom" not in [t.child_frame_id for t in stage.last("/tf_static").transforms]
    assert len(stage.last("/joint_states").name) == 4  # once, although two sensors measure these wheels


def test_a_robot_obeys_its_limits_and_stops_without_commands(project):
    stage = Stage(project, {"R2": ("jackal", -1.5, -1.0, 0.0)}, timeout=0.5)
    stage.wire.command("/cmd_vel", 50.0)  # beyond its limit, which the gate applies
    stage.run(2.0)
    limit = stage.simulation.simulated.robots["R2"].actuators[0].limits.largest
    assert 0.3 < max(odom.twist.twist.linear.x for odom in stage.wire.written["/odom"]) < limit * 1.02
    (expired,) = stage.events(CommandExpired)
    assert expired.t == pytest.approx(0.51, abs=0.011)
    assert abs(stage.world.twist("R2").forward) < 1e-3
    assert (stage.simulation.robots[0].commands, stage.simulation.robots[0].expired) == (1, 1)


@pytest.mark.parametrize("forward", [math.nan, math.inf])
def test_a_command_that_is_no_number_is_refused_and_the_last_one_does_not_live_on(project, forward):
    stage = Stage(project, {"R2": ("jackal", -1.5, -1.0, 0.0)}, timeout=0.3)
    stage.wire.command("/cmd_vel", forward)
    stage.run(0.2)
    assert abs(stage.world.twist("R2").forward) < 1e-3
    assert "not finite" in stage.simulation.robots[0].faults["/cmd_vel"]
    stage.wire.waiting["/cmd_vel"].append(Sample(b"\0\1\0\0abc", 0.0))
    stage.run(0.3)
    assert "no geometry_msgs/msg/TwistStamped" in stage.simulation.robots[0].faults["/cmd_vel"]


def test_bodies_that_go_sideways_take_all_axes(project):
    stage = Stage(project, {"R2": ("robotino", -1.5, -1.0, 0.0)})
    stage.wire.command("/cmd_vel", 0.1, 0.0, 0.2)
    stage.run(0.5)
    twist = stage.world.twist("R2")
    assert (twist.forward, twist.left) == pytest.approx((0.1, 0.2), abs=0.03)


def test_several_robots_have_namespaces_and_one_tree_of_frames(project):
    stage = Stage(project, {"R1": ("jackal", -1.5, -1.0, 0.0), "R2": ("jackal", 1.0, 1.0, 0.0)})
    stage.wire.command("/r1/cmd_vel", 0.3)
    stage.run(0.5)
    assert stage.world.twist("R1").forward > 0.2
    assert abs(stage.world.twist("R2").forward) < 1e-3
    frames = {t.child_frame_id: t.header.frame_id for t in stage.last("/tf_static").transforms}
    frames |= {t.child_frame_id: t.header.frame_id for m in stage.wire.written["/tf"] for t in m.transforms}
    for robot in ("r1", "r2"):
        assert stage.last(f"/{robot}/scan").header.frame_id == f"{robot}/lidar"
        at, path = f"{robot}/lidar", []
        while at in frames:
            at = frames[at]
            path.append(at)
        assert path == [f"{robot}/base_link", f"{robot}/base_footprint", f"{robot}/odom", "map"]
    assert {"/clock", "/tf", "/tf_static"} <= set(stage.wire.written)
    with pytest.raises(InputError, match=r"the robots R1 and r1 would have the same namespace 'x/r1'"):
        Stage(project, {"R1": ("jackal", -1.5, -1.0, 0.0), "r1": ("jackal", 1.0, 1.0, 0.0)}, namespace="/x/")


def test_a_given_namespace_holds_for_one_robot(project):
    stage = Stage(project, {"R2": ("jackal", 0.0, 0.0, 0.0)}, namespace="alpha")
    stage.run(0.05)
    assert set(stage.wire.written) - {"/clock", "/tf", "/tf_static"} == {
        "/alpha/odom",
        "/alpha/scan",
        "/alpha/joint_states",
        "/alpha/robot_description",
    }
    assert stage.last("/alpha/odom").child_frame_id == "alpha/base_link"


def test_the_quality_of_service_is_what_subscriptions_expect(project):
    stage = Stage(project, {"R2": ("summit_xl_localised", 0.0, 0.0, 0.0)})
    offered = stage.wire.qos
    assert offered["/tf_static"] == offered["/robot_description"] == QoS.LATCHED
    assert offered["/imu"] == offered["/range/" + next(t for t in offered if "range" in t)[7:]] == SENSORS
    assert {offered[topic].reliability for topic in ("/clock", "/tf", "/odom", "/joint_states")} == {"reliable"}


def test_a_collision_is_reported(project):
    stage = Stage(project, {"R2": ("jackal", 1.5, -1.0, 0.0)})
    for t in np.arange(0.0, 3.0, 0.2):
        stage.wire.command("/cmd_vel", 1.0)
        stage.run(t + 0.2)
    assert {(event.agent, event.kind) for event in stage.events(ContactBegan)} == {("R2", "collision")}


def test_a_sensor_that_raises_falls_silent_and_the_others_go_on(project):
    stage = Stage(project, {"R2": ("jackal", 0.0, 0.0, 0.0)})

    def broken():
        raise RuntimeError("no light")

    stage.simulation.simulated.sensors["R2"]["lidar"].read = broken
    stage.run(0.2)
    assert not stage.wire.written["/scan"]
    assert len(stage.wire.written["/odom"]) == 4
    assert "no light" in stage.simulation.robots[0].faults["lidar"]
