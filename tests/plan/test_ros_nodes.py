"""The nodes for ROS 2 on a fake connection: what they send, write to keys, wait for, and say when it fails."""

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.plan import TreePlan, xml_mission
from rocs_bt.ros2.ros_link import Received
from rocs_bt.trees.examine import examine
from rocs_bt.trees.nodes import FAILURE, RUNNING, SUCCESS, Tree

from .checking import check_mission
from .ros_fake import Link, Message, Types, after


class TestPublish:
    @pytest.mark.parametrize(
        ("type", "values", "sent"),
        [
            ("std_msgs/msg/String", "data = 'hello; you'", {"data": "hello; you"}),
            ("std_msgs/String", "data = 5", {"data": "5"}),
            ("geometry_msgs/msg/Twist", "linear.x = 20 cm/s", {"linear": {"x": 0.2}}),
            (
                "geometry_msgs/msg/Twist",
                "linear={whole};angular.z={turn}",
                {"linear": {"x": 1.0}, "angular": {"z": 0.5}},
            ),
            ("geometry_msgs/msg/Vector3", "{whole}", {"x": 1.0}),
            ("geometry_msgs/msg/Polygon", "points[1].x = 2", {"points": [{}, {"x": 2.0}]}),
            ("sensor_msgs/msg/Scan", "ranges = [1, {turn}, inf]", {"ranges": [1.0, 0.5, float("inf")]}),
            ("sensor_msgs/msg/Scan", "covariance[1] = 3", {"covariance": [0, 3.0, 0, 0]}),
            ("sensor_msgs/msg/Scan", "names = [a, 'b, c']; valid = true", {"names": ["a", "b, c"], "valid": True}),
            ("sensor_msgs/msg/Scan", "stamp = 1.5 s", {"stamp": {"sec": 1, "nanosec": 500_000_000}}),
            ("sensor_msgs/msg/Scan", "stamp.sec = 7", {"stamp": {"sec": 7}}),
            ("std_msgs/msg/String", "", {}),
        ],
    )
    def test_fields_of_any_type(self, grow, link, type, values, sent):
        tree = grow(f'<RosPublish topic="t" type="{type}" values="{values}"/>', turn=0.5, whole={"x": 1})
        assert tree.tick() is SUCCESS
        assert link.sent == [sent]

    def test_the_publisher_is_opened_before_the_first_tick_and_closed_with_the_plan(self, mind, link):
        say = {"topic": "/say", "type": "std_msgs/msg/String", "qos": "latched"}
        root = mind.mission.node("RosPublish", values={"data": "a"}, **say)
        plan = mind.start(root)
        assert link.opened == [("publisher", "/say", "std_msgs/msg/String", "latched")]
        mind.run()
        assert link.sent == [{"data": "a"}]
        plan.close()
        assert link.closed == link.opened

    def test_it_waits_for_a_subscription_only_as_long_as_it_shall(self, mind, grow, link):
        link.matched = 0
        tree = grow('<RosPublish topic="t" type="std_msgs/msg/String" wait="1 s"/>')
        assert tree.tick() is RUNNING
        assert "waits for a subscription" in tree.root.feedback_message
        after(mind, 1.0)
        assert tree.tick() is SUCCESS
        link.matched, link.sent = 1, []
        assert tree.tick() is SUCCESS
        assert link.sent == [{}]

    def test_a_topic_from_a_key_is_opened_in_the_tick(self, grow, link):
        tree = grow('<RosPublish topic="{where}" type="std_msgs/msg/String"/>', where="a")
        assert link.opened == []
        assert tree.tick() is SUCCESS
        tree.board["where"] = "b"
        assert tree.tick() is SUCCESS
        assert [name for _, name, *_ in link.opened] == ["a", "b"]
        assert [name for _, name, *_ in link.closed] == ["a"]

    @pytest.mark.parametrize(
        ("type", "values", "keys", "reason"),
        [
            ("std_msgs/msg/Int8", "data = {n}", {"n": 200}, "whole number from -128 to 127"),
            ("std_msgs/msg/Int8", "data = {n}", {"n": "few"}, "data is of type int8, found 'few'"),
            ("geometry_msgs/msg/Twist", "{n}", {"n": {"linar": {}}}, "Did you mean 'linear'"),
            ("geometry_msgs/msg/Twist", "linear = {n}", {"n": 3}, "is a message (geometry_msgs/msg/Vector3)"),
            ("std_msgs/msg/String", "data = {none}", {}, "none"),
        ],
    )
    def test_a_key_that_does_not_fit_fails_with_the_reason(self, grow, link, type, values, keys, reason):
        tree = grow(f'<RosPublish topic="t" type="{type}" values="{values}"/>', **keys)
        assert tree.tick() is FAILURE
        assert reason in tree.root.feedback_message
        assert link.sent == []

    def test_a_network_that_fails_is_a_failure_of_the_node(self, grow, link):
        tree, link.here = grow('<RosPublish topic="t" type="std_msgs/msg/String"/>'), False
        assert tree.tick() is FAILURE
        assert tree.root.feedback_message == "REFUSED: the network is down"


class TestSubscribe:
    LINE = '<RosSubscribe topic="scan" type="sensor_msgs/msg/Scan" values="ranges[1] -> {left}; . -> {all}" {}/>'

    def line(self, more=""):
        return self.LINE.replace("{}", more)

    def message(self, age=0.0, count=1):
        return Received(Message({"ranges": [1.0, 2.0]}), age, count)

    def test_it_runs_until_there_is_a_message_and_writes_its_fields(self, grow, link):
        tree = grow(self.line())
        assert link.opened == [("subscription", "scan", "sensor_msgs/msg/Scan", "reliable")]
        assert tree.tick() is RUNNING
        link.newest = self.message()
        assert tree.tick() is SUCCESS
        assert (tree.board["left"], tree.board["all"]) == (2.0, {"ranges": [1.0, 2.0]})

    def test_a_message_may_be_too_old_and_a_condition_does_not_wait(self, grow, link):
        tree = grow(self.line('max_age="1 s" timeout="0 s"'))
        assert tree.tick() is FAILURE
        assert tree.root.feedback_message == "TIMEOUT: no message on 'scan' within 0 s"
        link.newest = self.message(age=1.5)
        assert tree.tick() is FAILURE
        assert "the newest message is 1.5 s old" in tree.root.feedback_message
        link.newest = self.message(age=0.9)
        assert tree.tick() is SUCCESS

    def test_a_new_message_is_one_after_the_start_of_the_node(self, mind, grow, link):
        link.newest = self.message()
        tree = grow(self.line('new="true" timeout="1 s"'))
        assert tree.tick() is RUNNING
        link.newest = self.message(count=2)
        assert tree.tick() is SUCCESS
        assert tree.tick() is RUNNING, "seen already"
        after(mind, 1.0)
        assert tree.tick() is FAILURE

    def test_a_field_that_the_message_does_not_have_is_a_failure(self, grow, link):
        link.newest = Received(Message({"ranges": [1.0]}), 0.0, 1)
        tree = grow(self.line())
        assert tree.tick() is FAILURE
        assert "the message has no 'ranges[1]'" in tree.root.feedback_message


class TestService:
    LINE = (
        '<RosService service="lamp" type="std_srvs/srv/SetBool" request="data = true" '
        'response="success -> {done}; message -> {text}" wait="1 s" timeout="2 s"/>'
    )

    def test_a_call(self, grow, link):
        tree = grow(self.LINE)
        assert tree.tick() is RUNNING
        assert link.calls[0].values == {"data": True}
        assert tree.tick() is RUNNING
        link.calls[0].response = Message({"success": False, "message": "no bulb"})
        assert tree.tick() is SUCCESS
        assert (tree.board["done"], tree.board["text"]) == (False, "no bulb")
        assert len(link.calls) == 1

    def test_no_server_no_response_and_an_error(self, mind, grow, link):
        tree, link.here = grow(self.LINE), False
        assert tree.tick() is RUNNING
        after(mind, 1.0)
        assert tree.tick() is FAILURE
        assert tree.root.feedback_message == "UNHEARD: no server of the service 'lamp' within 1 s"
        link.here = True
        assert tree.tick() is RUNNING
        after(mind, 2.0)
        assert tree.tick() is FAILURE
        assert tree.root.feedback_message == "TIMEOUT: no response of the service 'lamp' within 2 s"
        assert link.calls[0].forgotten
        tree.tick()
        link.calls[1].error = "it raised"
        assert tree.tick() is FAILURE
        assert tree.root.feedback_message == "REFUSED: the service 'lamp' failed: it raised"

    def test_a_halt_forgets_the_call(self, grow, link):
        tree = grow(self.LINE)
        tree.tick()
        tree.halt()
        assert link.calls[0].forgotten


LINES = {
    "RosPublish": '<RosPublish topic="t" type="std_msgs/msg/String"/>',
    "RosSubscribe": '<RosSubscribe topic="t" type="std_msgs/msg/String"/>',
    "RosService": '<RosService service="s" type="std_srvs/srv/SetBool"/>',
    "RosAction": '<RosAction action="a" type="test_msgs/action/Fibonacci"/>',
    "RosActionServer": '<RosActionServer action="a" type="test_msgs/action/Fibonacci"><Stop/></RosActionServer>',
}


@pytest.mark.parametrize("tag", LINES)
class TestConnection:
    def test_without_one_it_fails_and_says_what_to_do(self, grow, tag):
        tree = grow(LINES[tag])
        assert tree.tick() is FAILURE
        assert tree.root.feedback_message.startswith("CANNOT: this robot has no ROS connection")
        assert "rocs-bt drive" in tree.root.feedback_message

    def test_what_it_cannot_do_is_refused_before_the_run_at_its_line(self, mind, tag):
        mind.mission.services = {"ros2": Link()}
        mind.mission.services["ros2"].refuses = "actions need rclpy."
        build = xml_mission(f'<root BTCPP_format="4"><BehaviorTree ID="M">\n  {LINES[tag]}</BehaviorTree></root>')
        with pytest.raises(InputError, match="actions need rclpy") as caught:
            TreePlan(build(mind.mission), mind.mission)
        assert caught.value.faults[0].line == 2


class TestCheck:
    @pytest.fixture(autouse=True)
    def installed(self, monkeypatch):
        monkeypatch.setattr("rocs_bt.ros2.nodes.uses_ros.installed_types", lambda settings: Types())

    def faults(self, mind, line, **more):
        text = f'<root BTCPP_format="4"><BehaviorTree ID="M">\n{line}</BehaviorTree></root>'
        return check_mission(
            xml_mission(text),
            actions=mind.rig.actions,
            knowledge=mind.rig.knowledge,
            clock=mind.rig.clock,
            tables={"ros2": None},
            **more,
        )

    def test_every_kind_of_node_passes(self, mind):
        for line in LINES.values():
            assert self.faults(mind, line) == []

    def test_a_wrong_field_of_a_goal_has_its_position(self, mind):
        line = '<RosAction action="a" type="test_msgs/action/Fibonacci" goal="ordr = 1"/>'
        (fault,) = self.faults(mind, line)
        assert (fault.line, fault.column, fault.warning) == (2, line.index("ordr") + 1, False)
        assert "no field" in fault.message
        assert "order" in fault.hint

    def test_types_of_a_package_that_is_not_installed_are_not_checked(self, mind):
        assert self.faults(mind, '<RosPublish topic="t" type="my_msgs/msg/Any" values="a.b[3] = x"/>') == []

    def test_keys_in_fields_are_part_of_the_data_flow(self, mind):
        line = '<Sequence><RosSubscribe topic="t" type="std_msgs/msg/String" values="data -> {x}"/>{}</Sequence>'
        say = '<RosPublish topic="u" type="std_msgs/msg/String" values="data = {KEY}"/>'
        assert self.faults(mind, line.replace("{}", say.replace("KEY", "x"))) == []
        (fault,) = self.faults(mind, line.replace("{}", say.replace("KEY", "y")))
        assert (fault.message, fault.warning) == ("'RosPublish': the key 'y' is read, but no node writes it.", True)
        assert fault.column == line.index("{}") + say.index("{KEY}") + 1


def test_a_key_of_a_field_goes_through_the_remapping_of_a_subtree(mind, link):
    text = """<root BTCPP_format="4" main_tree_to_execute="M">
      <BehaviorTree ID="M"><SubTree ID="S" data="{outside}" word="hello"/></BehaviorTree>
      <BehaviorTree ID="S"><Sequence>
        <RosSubscribe topic="t" type="std_msgs/msg/String" values="data -> {data}"/>
        <RosPublish topic="t" type="std_msgs/msg/String" values="data = {word}"/>
      </Sequence></BehaviorTree></root>"""
    link.newest = Received(Message({"data": "found"}), 0.0, 1)
    tree = TreePlan(xml_mission(text)(mind.mission), mind.mission).tree
    assert tree.tick() is SUCCESS
    assert tree.board["outside"] == "found"
    assert link.sent == [{"data": "hello"}]


def test_a_python_mission_of_a_project_uses_them_by_name(mind, link):
    mind.mission.content = Catalog()
    mind.rig.knowledge.world.place("g", Pose2(1.0, 0.0), kind="goal")
    root = mind.mission.node(
        "Sequence",
        mind.mission.node("RosSubscribe", topic="go", type="std_msgs/msg/String", values="data -> {order}"),
        mind.mission.node("RosPublish", topic="say", type="std_msgs/msg/String", values="data = {order}"),
    )
    link.newest = Received(Message({"data": "now"}), 0.0, 1)
    tree = Tree(root, board=mind.mission.board, clock=mind.rig.clock, owner=mind.mission)
    assert list(examine(tree)) == []
    assert tree.tick() is SUCCESS
    assert link.sent == [{"data": "now"}]
