"""`rocs-bt sim --ros2` as a process, observed and driven through DDS."""

import itertools
import math
import re
import signal
import time
from contextlib import closing

import pytest

from rocs_bt.base.geometry import Pose3
from rocs_bt.catalog import Catalog
from rocs_bt.cli.main import call
from rocs_bt.event import NullSink
from rocs_bt.ros2.network.connect import open_transport
from rocs_bt.ros2.network.qos import QoS
from rocs_bt.ros2.settings import Ros2Settings
from rocs_bt.simulation import build_world

from .test_sim_robot import AGENT, SCENARIO, frames_of, pose_of, time_of

PATIENCE = 30.0  # [s]
TYPES = {
    "clock": "rosgraph_msgs/msg/Clock",
    "tf": "tf2_msgs/msg/TFMessage",
    "tf_static": "tf2_msgs/msg/TFMessage",
    "odom": "nav_msgs/msg/Odometry",
    "scan": "sensor_msgs/msg/LaserScan",
}


class Client:
    """A program that drives simulated robots, and has their newest messages by topic.

    Args:
        topics: Topics that it reads.
        robots: Namespaces of the robots, with a slash at the end; one without by default.
    """

    def __init__(self, *topics, robots=("",)):
        self.transport, self.newest = open_transport(Ros2Settings(transport="dds"), "client"), {}
        self.readers = []
        for topic in topics:
            kind = TYPES.get(topic.rpartition("/")[2], "sensor_msgs/msg/Range")
            qos = QoS.LATCHED if topic == "tf_static" else QoS.SENSOR
            self.readers.append(self.transport.reader(f"/{topic}", kind, qos))
        stamped = "geometry_msgs/msg/TwistStamped"
        self.writers = {r: self.transport.writer(f"/{r}cmd_vel", stamped, QoS.COMMAND) for r in robots}

    def close(self):
        self.transport.close()

    def command(self, forward, turn=0.0, robot=""):
        twist = {"linear": {"x": forward}, "angular": {"z": turn}}
        types = self.transport.types
        self.writers[robot].write(types.serialize(types.make("geometry_msgs/msg/TwistStamped", twist=twist)))

    def look(self):
        for reader in self.readers:
            if (sample := reader.take()) is not None:
                self.newest[reader.topic[1:]] = self.transport.types.deserialize(sample.data, reader.type)

    def until(self, condition, each=lambda: None):
        """Look until a condition of the newest messages holds, with a call before each look."""
        end = time.monotonic() + PATIENCE
        for turn in itertools.count():
            self.look()
            if found := condition(self.newest):
                return found
            assert time.monotonic() < end, f"it never came: {sorted(self.newest)}"
            if turn % 10 == 0:
                each()
            time.sleep(0.005)
        raise AssertionError

    def pose(self, topic="odom"):
        self.newest.pop(topic, None)
        self.until(lambda newest: topic in newest)
        pose = self.newest[topic].pose.pose
        return pose_of(pose.position, pose.orientation)


def test_exp1_publishes_the_truth_of_its_world(simulator):
    truth = build_world(Catalog.here().load_scenario("exp1"), Catalog.here(), 3, NullSink())
    sonars = truth.sensors["R2"]["sonar"]
    sites = sonars.sites
    process = simulator("exp1", "--seed", "3")
    with closing(Client("clock", "odom", "tf", "tf_static", *(f"range/{site}" for site in sites))) as client:
        client.until(lambda newest: len(newest) == 4 + len(sites))  # the latched transforms, too
        pose = client.pose()
        assert pose.plane == pytest.approx(truth.starts["R2"], abs=2e-3)  # it settles on its wheels
        ranges = [client.newest[f"range/{site}"].range for site in sites]
        assert ranges == pytest.approx(list(sonars.read().values), abs=0.02)
        client.until(lambda newest: newest["tf"].transforms[0].header.frame_id == "odom")
        place, turn, _ = frames_of(client.newest["tf"], client.newest["tf_static"]).pose("map", "base_link")
        assert Pose3.from_quaternion(place, turn) == pytest.approx(pose, abs=2e-3)
        frames = {each.child_frame_id: each.header.frame_id for each in client.newest["tf_static"].transforms}
        assert frames == {"odom": "map", "base_link": "base_footprint", **dict.fromkeys(sites, "base_link")}
        client.until(lambda now: abs(time_of(now["clock"].clock) - time_of(now["odom"].header.stamp)) < 0.2)
    assert process.end(signal.SIGINT) == 130
    assert "not repeatable" in process.text
    assert "R2: 0 commands." in process.text
    assert "SIGINT" in process.errors


def test_a_robot_is_driven_and_stops_without_commands(simulator):
    process = simulator("exp1", "--command-timeout", "0.4")
    with closing(Client("odom")) as client:
        start = client.pose()
        client.until(lambda newest: newest["odom"].twist.twist.linear.x > 0.25, lambda: client.command(0.3))
        commanded = time_of(client.newest["odom"].header.stamp)
        client.until(lambda newest: abs(newest["odom"].twist.twist.linear.x) < 0.01)
        passed = time_of(client.newest["odom"].header.stamp) - commanded
        assert 0.25 < passed < 3.0  # the time-out, and braking; a command may be older than the odometry
        assert math.hypot(client.pose().x - start.x, client.pose().y - start.y) > 0.05
    assert process.end() == 143
    assert re.search(r"stopped [1-9]\d* times? without one", process.text)  # late commands on a loaded machine: more
    assert "R2: no command any more, stopped" in process.errors


def test_two_robots_by_namespace_at_twice_real_time(simulator, tmp_path):
    for folder in ("planners", "rules", "robots", "scenarios"):
        (tmp_path / folder).mkdir()
    agents = AGENT.format(name="R1", robot="jackal", x=-1.5, y=-1.0, yaw=0.0)
    agents += AGENT.format(name="R2", robot="jackal", x=1.0, y=1.0, yaw=0.0)
    (tmp_path / "scenarios/two.toml").write_text(SCENARIO.format(world="arena_box") + agents)
    process = simulator("two", "--rate", "2")
    topics = ("clock", "r1/odom", "r2/odom", "r1/scan", "r2/scan")
    with closing(Client(*topics, robots=("r1/", "r2/"))) as client:
        client.until(lambda newest: len(newest) == len(topics))
        assert [client.newest[f"{r}/scan"].header.frame_id for r in ("r1", "r2")] == ["r1/lidar", "r2/lidar"]
        assert client.newest["r2/odom"].child_frame_id == "r2/base_link"
        before, other = client.pose("r1/odom"), client.pose("r2/odom")
        client.until(
            lambda newest: newest["r1/odom"].pose.pose.position.x > before.x + 0.1,
            lambda: client.command(0.3, robot="r1/"),
        )
        assert Pose3(*client.pose("r2/odom")) == pytest.approx(other, abs=1e-3)
        took, end = math.inf, time.monotonic() + PATIENCE
        while not 0.4 < took < 0.8:  # a loaded machine is late, and catches up
            assert time.monotonic() < end, f"a simulated second takes {took:.2f} s"
            wall, simulated = time.monotonic(), time_of(client.newest["clock"].clock)
            client.until(lambda newest, until=simulated + 1.0: time_of(newest["clock"].clock) > until)
            took = time.monotonic() - wall
    process.end()
    assert "R1: " in process.text
    assert "R2: 0 commands." in process.text


def test_a_scenario_without_a_mission_and_a_publisher_of_another_type(simulator, tmp_path):
    (tmp_path / "scenarios").mkdir()
    agent = AGENT.format(name="R1", robot="jackal", x=0.0, y=0.0, yaw=0.0).replace('mission = "go_to"', "")
    (tmp_path / "scenarios/bare.toml").write_text(SCENARIO.format(world="arena_box") + agent)
    process = simulator("bare")
    with closing(Client("odom", robots=())) as client:
        client.transport.writer("/cmd_vel", "geometry_msgs/msg/Twist", QoS.COMMAND)
        process.until_said("Write --cmd-vel Twist.")
    process.end()


def test_it_ends_by_itself_after_its_time(simulator):
    process = simulator("exp1", "--for", "0.5", "--rate", "0")
    assert process.wait() == 0
    assert "Simulated 0.50 s" in process.text


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ([], "rocs-bt sim needs a network for the robots. Write: rocs-bt sim exp1 --ros2."),
        (["--ros2", "--for", "0"], "--for must be positive and finite, found 0 s."),
        (["--ros2", "--command-timeout", "inf"], "--command-timeout must be positive and finite, found inf s."),
        (["--ros2", "--rate", "-1"], "--rate must be 0 or more and finite, found -1."),
        (["--ros2", "--namespace", "2nd"], "'2nd' is not a valid namespace."),
        (["--ros2", "--distro", "foxy"], "no distribution of ROS 2 is named 'foxy'"),
    ],
)
def test_wrong_options_are_refused_with_what_to_do(options, said, ros_environment, capsys):
    assert call(["sim", "exp1", *options]) == 2
    assert said in capsys.readouterr().err
