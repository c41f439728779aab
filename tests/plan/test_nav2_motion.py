"""Nodes with which Nav2 moves the robot: reflexes and the safety gate have priority, and may pass on its commands."""

import math

import pytest

from rocs_bt.actions import SetTwist
from rocs_bt.interfaces.pipeline import Priority
from rocs_bt.plan import xml_mission
from rocs_bt.ros2.ros_link import GoalState, Received
from rocs_bt.trees.nodes import RUNNING, SUCCESS

from .checking import check_mission
from .ros_fake import Message


@pytest.mark.parametrize(("line", "cancelled"), [("<Spin/>", 1), ("<Wait/>", 0), ('<Spin cancel_on_reflex="0"/>', 0)])
def test_reflexes_have_priority_over_what_moves_the_robot(mind, served, link, line, cancelled):
    tree = served(line)
    tree.tick()
    link.goals[0].state = GoalState.ACCEPTED
    mind.rig.pipeline.hold(True)
    assert tree.tick() is RUNNING
    assert link.goals[0].cancelled == cancelled


@pytest.mark.parametrize("more", ["", 'cancel_on_reflex="0"', 'cmd_vel="cmd_vel_nav"'])
def test_a_held_gate_cancels_what_moves_the_robot_until_its_release(mind, served, link, more):
    gate = mind.rig.gate
    tree = served(f"<Spin {more}/>")
    tree.tick()
    link.goals[0].state = GoalState.ACCEPTED
    gate.hold("emergency stop")
    assert tree.tick() is RUNNING
    assert link.goals[0].cancelled == 1
    link.goals[0].state = GoalState.CANCELED
    for _ in range(2):
        assert tree.tick() is RUNNING
        assert tree.root.feedback_message == "'spin' waits: the robot is held (emergency stop)"
    assert len(link.goals) == 1
    gate.release()
    assert tree.tick() is RUNNING
    assert len(link.goals) == 2
    assert link.goals[1].cancelled == 0


@pytest.mark.parametrize(
    ("line", "warns"), [("<Spin/>", True), ('<Spin cmd_vel="cmd_vel_nav"/>', False), ("<Wait/>", False)]
)
def test_a_check_warns_of_commands_past_the_gate(mind, link, line, warns):
    text = f'<root BTCPP_format="4"><BehaviorTree ID="M">\n{line}</BehaviorTree></root>'
    build = xml_mission(text, dialect="nav2_servers")
    rig = mind.rig
    faults = check_mission(build, actions=rig.actions, knowledge=rig.knowledge, clock=rig.clock, later=())
    found = [f for f in faults if "Nav2 commands the base past the safety gate" in f.message]
    assert [(f.line, f.warning, "Give it cmd_vel" in f.hint) for f in found] == [(2, True, True)] * warns


class TestRelay:
    LINE = '<NavigateToPose goal="dock" cmd_vel="cmd_vel_nav" {}/>'

    def begun(self, mind, served, link, more=""):
        self.tree = served(self.LINE.replace("{}", more))
        self.tree.tick()
        link.goals[0].state = GoalState.ACCEPTED
        return self.tree

    def drive(self, mind, link, twist=(0.2, 0.0), age=0.0, stamped=True, periods=10):
        for _ in range(periods):
            values = {"linear": {"x": twist[0], "y": 0.0, "z": 0.0}, "angular": {"z": twist[1]}}
            link.newest = Received(Message({"twist": values} if stamped else values), age, 1)
            self.tree.tick()
            mind.rig.run()

    def test_the_commands_pass_the_gate_while_the_goal_is_pursued(self, mind, served, link):
        tree = self.begun(mind, served, link)
        assert ("subscription", "cmd_vel_nav", "geometry_msgs/msg/TwistStamped", "reliable") in link.opened
        self.drive(mind, link)
        assert mind.rig.pose.x > 0.02
        link.goals[0].state = GoalState.SUCCEEDED
        assert tree.tick() is SUCCESS
        mind.rig.run()
        x = mind.rig.pose.x
        for _ in range(20):
            mind.rig.run()
        assert mind.rig.pose.x - x < 0.05, "the robot stops with the goal"

    @pytest.mark.parametrize("how", [{"age": 0.6}, {"twist": (math.nan, 0.0)}])
    def test_no_recent_or_no_finite_command_is_rest(self, mind, served, link, how):
        self.begun(mind, served, link)
        self.drive(mind, link, **how)
        assert mind.rig.pose.x == 0.0
        assert self.tree.root.status is RUNNING

    def test_a_twist_without_header(self, mind, served, link):
        self.begun(mind, served, link, 'cmd_vel_type="geometry_msgs/msg/Twist"')
        self.drive(mind, link, stamped=False)
        assert mind.rig.pose.x > 0.02

    @pytest.mark.parametrize("cancel", ["true", "false"])
    def test_a_reflex_pre_empts_it_and_it_goes_on_afterwards(self, mind, served, link, cancel):
        tree = self.begun(mind, served, link, f'cancel_on_reflex="{cancel}"')
        self.drive(mind, link, periods=2)
        mind.rig.pipeline.hold(True)
        mind.rig.pipeline.submit(SetTwist(turn=0.5, duration=0.5), Priority.HIGH, by="rules/Flinch")
        tree.tick()
        if cancel == "true":
            link.goals[0].state = GoalState.CANCELED
        self.drive(mind, link, periods=10)
        x = mind.rig.pose.x
        self.drive(mind, link, periods=5)
        assert mind.rig.pose.x == pytest.approx(x, abs=0.02)
        mind.rig.pipeline.hold(False)
        for _ in range(2):
            tree.tick()
        link.goals[-1].state = GoalState.ACCEPTED
        self.drive(mind, link)
        assert mind.rig.pose.x > x + 0.02
        assert len(link.goals) == (2 if cancel == "true" else 1)
