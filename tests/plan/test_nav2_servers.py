"""Goals, results and error codes of the nodes that call Nav2's action servers, on a fake connection."""

import math

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2
from rocs_bt.plan import TreePlan, mission_parameters, xml_mission
from rocs_bt.ros2.ros_link import GoalState, RosField
from rocs_bt.trees.nodes import FAILURE, RUNNING

from .checking import check_mission
from .nav2_msgs import TEXT, pose
from .ros_fake import TYPES, Message


def test_goals_in_a_message_of_their_own_as_in_later_distributions(served, link, monkeypatch):
    fields = {"poses": RosField("nav_msgs/msg/Goals"), "behavior_tree": TEXT}
    monkeypatch.setitem(TYPES, "nav2_msgs/action/NavigateThroughPoses_Goal", fields)
    served('<NavigateThroughPoses goals="near"/>').tick()
    assert link.goals[0].values["poses"] == {"header": {"frame_id": "map"}, "goals": [pose(1, 0, 0.5)]}


def test_a_path_of_nav2_for_its_controller_and_for_our_own_actions(served, link):
    tree = served(
        """<Sequence><ComputePathToPose goal="dock" path="{path}" corners="{corners}"/>
           <FollowPath path="{path}" controller_id="MPPI"/><FollowPath path="{corners}" frame="odom"/></Sequence>"""
    )
    tree.tick()
    path = {"header": {"frame_id": "map"}, "poses": [pose(0, 0), pose(3, 0, 1.0), pose(3, 4)]}
    for i, result in enumerate([{"path": path}, {}, {}]):
        link.goals[i].state, link.goals[i].result = GoalState.SUCCEEDED, Message(result)
        tree.tick()
    assert tree.board["corners"] == [(0.0, 0.0), (3.0, 0.0), (3.0, 4.0)]
    assert link.goals[1].values == {"path": path, "controller_id": "MPPI", "goal_checker_id": ""}
    made = link.goals[2].values["path"]
    assert made["header"] == {"frame_id": "odom"}
    headings = [2 * math.atan2(p["pose"]["orientation"]["z"], p["pose"]["orientation"]["w"]) for p in made["poses"]]
    assert headings == pytest.approx([0.0, math.pi / 2, math.pi / 2])


def test_feedback_result_and_error_code(served, link):
    tree = served(
        '<NavigateToPose goal="dock" feedback="distance_remaining -> {left}" result="error_msg -> {why}" '
        'error_code_id="{code}" error_msg="{text}"/>'
    )
    tree.tick()
    goal = link.goals[0]
    goal.feedback, goal.feedback_count = Message({"distance_remaining": 2.5}), 1
    assert tree.tick() is RUNNING
    assert (tree.board["left"], tree.board["code"]) == (2.5, 0)
    goal.state, goal.result = GoalState.ABORTED, Message({"error_code": 9002, "error_msg": "no transform"})
    assert tree.tick() is FAILURE
    assert [tree.board[key] for key in ("code", "text", "why")] == [9002, "no transform", "no transform"]
    assert tree.root.feedback_message == (
        "REFUSED: the server of 'navigate_to_pose' aborted the goal (error code 9002: no transform)"
    )


def test_a_result_without_error_code_as_in_earlier_distributions(served, link):
    tree = served('<Spin error_code_id="{code}"/>')
    tree.tick()
    link.goals[0].state, link.goals[0].result = GoalState.ABORTED, Message({})
    assert tree.tick() is FAILURE
    assert tree.board["code"] == 0
    assert tree.root.feedback_message == "REFUSED: the server of 'spin' aborted the goal"


def test_any_heading_is_that_of_the_straight_line(mind, served, link):
    mind.rig.run()
    served('<NavigateToPose goal="{post}"/>', post=Pose2(0.0, 2.0, math.nan)).tick()
    turned = link.goals[0].values["pose"]["pose"]["orientation"]
    assert 2 * math.atan2(turned["z"], turned["w"]) == pytest.approx(math.pi / 2, abs=0.05)


class TestDialect:
    MISSION = '<root BTCPP_format="4"><BehaviorTree ID="M"><NavigateToPose/></BehaviorTree></root>'

    def test_the_goal_is_a_parameter_of_the_mission(self, mind, link, served):
        build = xml_mission(self.MISSION, dialect="nav2_servers")
        assert list(mission_parameters(build)) == ["goal"]
        tree = TreePlan(build(mind.mission, goal="dock"), mind.mission).tree
        assert tree.tick() is RUNNING
        assert link.goals[0].values["pose"] == pose(3, 4, math.pi)

    def test_an_unknown_place_is_found_by_a_check(self, mind, link, served):
        build = xml_mission(
            self.MISSION.replace("<Nav", "\n<Nav").replace("/>", ' goal="dok"/>'), dialect="nav2_servers"
        )
        (_, fault) = check_mission(
            build, actions=mind.rig.actions, knowledge=mind.rig.knowledge, clock=mind.rig.clock, later=()
        )
        assert "no place is named 'dok'" in fault.message
        assert fault.line == 2

    def test_elsewhere_the_nodes_are_named_with_the_dialect(self, mind):
        with pytest.raises(InputError, match=r'is a node of Nav2. Write nodes = "nav2"'):
            xml_mission(self.MISSION, dialect="rocs")(mind.mission)
