"""Nodes of ROS 2 without a network: installed types, plain values of messages, dry runs, and the check of files."""

from __future__ import annotations

import time
from types import SimpleNamespace

import pytest

from rocs_bt.base.clock import Clock, WallClock
from rocs_bt.base.errors import DeviceError, InputError
from rocs_bt.event import NullSink
from rocs_bt.interfaces.pipeline import Pipeline
from rocs_bt.knowledge import Knowledge
from rocs_bt.plan import Mission, TreePlan, xml_mission
from rocs_bt.ros2.messages.known_types import KnownTypes
from rocs_bt.ros2.messages.plain import PlainMessage
from rocs_bt.ros2.messages.type_store import TypeStore
from rocs_bt.ros2.network.node import RosNode
from rocs_bt.ros2.network.qos import QoS
from rocs_bt.ros2.network.transport import Endpoint
from rocs_bt.ros2.nodes.dry_link import DryLink
from rocs_bt.ros2.nodes.link import NodeLink
from rocs_bt.ros2.ros_link import RosField
from rocs_bt.ros2.settings import Ros2Settings

from .network import Network

MESSAGES = TypeStore()
TYPES = KnownTypes(MESSAGES)


class TestTypes:
    def test_fields_of_messages(self):
        fields = TYPES.fields("nav_msgs/msg/Odometry")
        assert fields["pose"] == RosField("geometry_msgs/msg/PoseWithCovariance")
        assert TYPES.fields("geometry_msgs/msg/PoseWithCovariance")["covariance"] == RosField("float64", True, 36)
        assert TYPES.fields("nav_msgs/msg/Path")["poses"] == RosField("geometry_msgs/msg/PoseStamped", True)
        assert str(TYPES.fields("sensor_msgs/msg/JointState")["name"]) == "string[]"

    def test_a_name_that_a_known_package_does_not_have_is_an_error(self):
        with pytest.raises(InputError, match=r"Did you mean 'sensor_msgs/msg/LaserScan'"):
            TYPES.fields("sensor_msgs/msg/LaserScann")

    @pytest.mark.parametrize("type", ["my_msgs/msg/A", "my_msgs/srv/B_Request", "my_msgs/action/C_Goal"])
    def test_a_package_that_is_not_here_is_unknown(self, type):
        assert TYPES.fields(type) is None
        assert KnownTypes(None).fields(type) is None


class TestPlain:
    def test_fields_of_a_message(self):
        message = PlainMessage(
            MESSAGES.make(
                "nav_msgs/msg/Path",
                header={"frame_id": "map"},
                poses=[{"pose": {"position": {"x": 1.5}}}, {"header": {"stamp": {"sec": 3}}}],
            )
        )
        assert message.get(("poses", 0, "pose", "position", "x")) == 1.5
        assert message.get(("poses", 1, "header", "stamp")) == {"sec": 3, "nanosec": 0}
        assert message.get()["header"]["frame_id"] == "map"
        assert [pose["pose"]["position"]["x"] for pose in message.get(("poses",))] == [1.5, 0]

    def test_arrays_of_numbers_are_lists(self):
        data = MESSAGES.serialize(MESSAGES.make("sensor_msgs/msg/LaserScan", ranges=[1.0, 2.5]))
        message = PlainMessage(MESSAGES.deserialize(data, "sensor_msgs/msg/LaserScan"))
        assert message.get(("ranges",)) == [1.0, 2.5]
        assert message.get(("ranges", 1)) == 2.5
        assert type(message.get(("ranges", 1))) is float

    @pytest.mark.parametrize("path", [("ranges", 2), ("rangs",), ("range_min", "x")])
    def test_what_is_not_there(self, path):
        with pytest.raises(LookupError):
            PlainMessage(MESSAGES.make("sensor_msgs/msg/LaserScan", ranges=[1.0, 2.0])).get(path)


def test_a_dry_run_receives_and_sends_nothing():
    client = SimpleNamespace(ready=lambda: True, close=lambda: None, mismatch=str, servers=list)
    link = SimpleNamespace(
        types=TYPES, subscription=lambda *of: of, service=lambda *of: client, action=lambda *of: client
    )
    dry = DryLink(link)
    assert dry.types is TYPES
    assert dry.subscription("a", "b", "reliable") == ("a", "b", "reliable")
    dry.publisher("a", "std_msgs/msg/String", "reliable").publish({"data": "a"})  # `link` has no publisher
    for client, verb in ((dry.service("s", "t"), "call"), (dry.action("s", "t"), "send")):
        assert client.ready()
        with pytest.raises(DeviceError, match="dry run"):
            getattr(client, verb)({})
    server = dry.action_server("s", "t")
    server.open(True)
    assert server.goal() is None


class TestAge:
    TYPE = "std_msgs/msg/Float64"

    @pytest.fixture(autouse=True)
    def subscribe(self):
        self.network = Network(MESSAGES)
        clock = type("OfTheNetwork", (Clock,), {"now": lambda clock: self.network.time})()
        self.node = RosNode(Ros2Settings(namespace="r1"), clock, transport=self.network)
        self.subscription = NodeLink(lambda: self.node).subscription("speed", self.TYPE, "reliable")

    def newest(self):
        received = self.subscription.newest()
        return received and (received.message.get(("data",)), pytest.approx(received.age), received.count)

    def send(self, value, age):
        self.network.send("/r1/speed", self.TYPE, age=age, data=value)

    @pytest.mark.parametrize(("age", "ages"), [(0.3, (0.3, 0.9)), (0.0, (0.0, 0.6)), (-0.4, (0.0, 0.6))])
    def test_it_grows_from_the_receipt_also_if_the_clock_of_the_publisher_is_ahead(self, age, ages):
        self.send(1.0, age)
        assert self.newest() == (1.0, ages[0], 1)
        self.network.time = 0.6
        assert self.newest() == (1.0, ages[1], 1)

    def test_a_message_of_the_future_is_ignored_and_counted(self):
        self.send(1.0, -30.0)
        assert self.newest() is None
        assert "its stamp is 30.00 s in the future: synchronise the clocks" in self.subscription.ignored
        self.send(2.0, 0.0)
        assert self.newest() == (2.0, 0.0, 1)
        assert self.subscription.ignored == ""
        self.send(3.0, -30.0)
        self.network.time = 1.0
        assert self.newest() == (2.0, 1.0, 1)
        assert self.node.faults == {"/r1/speed": {"stamp": 2}}


def plan_of(line, network):
    """Plan with this node, and the connection of its robot."""
    clock = WallClock()
    node = RosNode(Ros2Settings(), clock, transport=network)
    knowledge, pipeline = Knowledge("R1", clock, NullSink()), Pipeline(clock, NullSink(), "R1")
    mission = Mission(
        "m", knowledge=knowledge, pipeline=pipeline, actions={}, services={"ros2": NodeLink(lambda: node)}
    )
    text = f'<root BTCPP_format="4"><BehaviorTree ID="M">{line}</BehaviorTree></root>'
    return TreePlan(xml_mission(text)(mission), mission), node


SPEED = "std_msgs/msg/Float64"
READS = f'<RosSubscribe topic="speed" type="{SPEED}" qos="{{}}" timeout="0 s"/>'
SAYS = f'<RosPublish topic="speed" type="{SPEED}" qos="{{}}"/>'
OTHER_TYPE = f"'/speed' ({SPEED}): the node '/n' {{}} std_msgs/msg/Int32, which is another type; "
OTHER_TYPE += 'write type="std_msgs/msg/Int32", or change the other node'
QUALITY = f"'/speed' ({SPEED}): the quality of service of the node '/n' does not match in {{}}: it {{}} {{}}, "
QUALITY += "the node {} {}{}"
RELIABILITY = "reliability (offered best_effort, requested reliable)"
DURABILITY = "durability (offered volatile, requested transient_local)"
CHANGE = '; write qos="{}", or change the other node'


@pytest.mark.parametrize(
    ("line", "qos", "type", "theirs", "reason"),
    [
        (READS, "reliable", "std_msgs/msg/Int32", QoS(), OTHER_TYPE.format("publishes")),
        (
            READS, "reliable", SPEED, QoS.SENSOR,
            QUALITY.format(
                RELIABILITY, "offers", QoS.SENSOR, "requests", QoS(depth=10), CHANGE.format("sensor_data")
            ),
        ),
        (
            READS, "latched", SPEED, QoS(),
            QUALITY.format(DURABILITY, "offers", QoS(), "requests", QoS.LATCHED, CHANGE.format("reliable")),
        ),
        (READS, "sensor_data", SPEED, QoS(), ""),
        (SAYS, "reliable", "std_msgs/msg/Int32", QoS(), OTHER_TYPE.format("subscribes to")),
        (
            SAYS, "sensor_data", SPEED, QoS(),
            QUALITY.format(RELIABILITY, "requests", QoS(), "offers", QoS.SENSOR, CHANGE.format("reliable")),
        ),
        (
            SAYS, "reliable", SPEED, QoS.LATCHED,
            QUALITY.format(DURABILITY, "requests", QoS.LATCHED, "offers", QoS(depth=10), CHANGE.format("latched")),
        ),
        (SAYS, "reliable", SPEED, QoS.SENSOR, ""),
    ],
)  # fmt: skip  # a reader or writer and its network share a line
def test_a_topic_that_does_not_match_is_named_with_both_sides_and_the_change(line, qos, type, theirs, reason):
    network = Network(MESSAGES)
    network.peers, network.matches = [Endpoint("/speed", type, "/n", line == READS, theirs)], int(not reason)
    plan, node = plan_of(line.format(qos), network)
    before = "TIMEOUT: no message on 'speed' within 0 s" if line == READS else "published on 'speed'"
    heard = ", where nothing receives it" if reason and line == SAYS else ""
    wanted = f"{before}{heard}: {reason}" if reason else before
    for _ in range(1000):  # the endpoints are looked up in a thread
        plan.tree.tick()
        if plan.root.feedback_message == wanted:
            break
        time.sleep(0.01)
    assert plan.root.feedback_message == wanted
    node.close()


def test_a_subscription_that_ignores_messages_says_why():
    network = Network(MESSAGES)
    plan, _ = plan_of(f'<RosSubscribe topic="speed" type="{SPEED}" timeout="0 s"/>', network)
    network.send("/speed", "std_msgs/msg/Float64", age=-30.0, data=1.0)
    plan.tree.tick()
    assert "(ignored: /speed: its stamp is 30.00 s in the future" in plan.root.feedback_message


MISSION = """<root BTCPP_format="4"><BehaviorTree ID="M"><Sequence>
  <RosPublish topic="say" type="std_msgs/msg/String" values="dta = 'hello'"/>
  <RosAction action="go" type="my_msgs/action/Go" goal="any.field = 1" result=". -> {x}"/>
</Sequence></BehaviorTree></root>"""
