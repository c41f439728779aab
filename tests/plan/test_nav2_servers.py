"""Nodes that call Nav2's action servers, on a fake connection: no wheel has nav2_msgs.

The types are a stand-in with the fields of nav2_msgs in Jazzy, as far as the nodes use them.
"""

import math

import pytest

from rocs_bt.actions import SetTwist
from rocs_bt.errors import InputError
from rocs_bt.geometry import Pose2
from rocs_bt.pipeline import Priority
from rocs_bt.plan import TreePlan, check_mission, mission_parameters, xml_mission
from rocs_bt.plan.nav2.goals import WaypointStatus
from rocs_bt.plan.ros2 import NAV2_SERVERS, nav2_servers
from rocs_bt.plan.ros2.nav2_topics import TOPICS
from rocs_bt.ros_link import GoalState, Received, RosField
from rocs_bt.trees.nodes import FAILURE, RUNNING, SUCCESS, Tree

from .ros_fake import TYPES, Link, Message

STAMPED, PATH, DURATION = "geometry_msgs/msg/PoseStamped", "nav_msgs/msg/Path", "builtin_interfaces/msg/Duration"
TEXT, NUMBER, TRUTH, WORD = RosField("string"), RosField("float32"), RosField("bool"), RosField("uint16")
LIKE_NAV2_MSGS = {
    STAMPED: {"header": RosField("std_msgs/msg/Header"), "pose": RosField("geometry_msgs/msg/Pose")},
    "std_msgs/msg/Header": {"stamp": RosField("builtin_interfaces/msg/Time"), "frame_id": TEXT},
    "geometry_msgs/msg/Pose": {
        "position": RosField("geometry_msgs/msg/Vector3"),
        "orientation": RosField("geometry_msgs/msg/Quaternion"),
    },
    "geometry_msgs/msg/Quaternion": {axis: RosField("float64") for axis in "xyzw"},
    PATH: {"header": RosField("std_msgs/msg/Header"), "poses": RosField(STAMPED, array=True)},
    DURATION: {"sec": RosField("int32"), "nanosec": RosField("uint32")},
    "nav_msgs/msg/Goals": {"header": RosField("std_msgs/msg/Header"), "goals": RosField(STAMPED, array=True)},
    "nav2_msgs/action/NavigateToPose_Goal": {"pose": RosField(STAMPED), "behavior_tree": TEXT},
    "nav2_msgs/action/NavigateToPose_Feedback": {"distance_remaining": NUMBER},
    "nav2_msgs/action/NavigateToPose_Result": {"error_code": WORD, "error_msg": TEXT},
    "nav2_msgs/action/NavigateThroughPoses_Goal": {"poses": RosField(STAMPED, array=True), "behavior_tree": TEXT},
    "nav2_msgs/action/ComputePathToPose_Goal": {
        "goal": RosField(STAMPED), "start": RosField(STAMPED), "planner_id": TEXT, "use_start": TRUTH,
    },
    "nav2_msgs/action/FollowPath_Goal": {"path": RosField(PATH), "controller_id": TEXT, "goal_checker_id": TEXT},
    "nav2_msgs/action/Spin_Goal": {"target_yaw": NUMBER, "time_allowance": RosField(DURATION)},
    "nav2_msgs/action/BackUp_Goal": {
        "target": RosField("geometry_msgs/msg/Vector3"), "speed": NUMBER, "time_allowance": RosField(DURATION),
        "disable_collision_checks": TRUTH,
    },
    "nav2_msgs/action/DriveOnHeading_Goal": {"target": RosField("geometry_msgs/msg/Vector3"), "speed": NUMBER},
    "nav2_msgs/action/Wait_Goal": {"time": RosField(DURATION)},
    "nav2_msgs/action/DockRobot_Goal": {
        "use_dock_id": TRUTH, "dock_id": TEXT, "dock_pose": RosField(STAMPED), "dock_type": TEXT,
        "max_staging_time": NUMBER, "navigate_to_staging_pose": TRUTH,
    },
    "nav2_msgs/action/UndockRobot_Goal": {"dock_type": TEXT, "max_undocking_time": NUMBER},
}  # fmt: skip  # a table

for _name in [name for name in LIKE_NAV2_MSGS if name.endswith("_Goal")]:
    LIKE_NAV2_MSGS.setdefault(_name.replace("_Goal", "_Feedback"), {})
    LIKE_NAV2_MSGS.setdefault(_name.replace("_Goal", "_Result"), {})


def pose(x, y, yaw=0.0):
    turned = {"z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}
    return {"header": {"frame_id": "map"}, "pose": {"position": {"x": x, "y": y}, "orientation": turned}}


@pytest.fixture
def link(mind, monkeypatch):
    for name, fields in LIKE_NAV2_MSGS.items():
        monkeypatch.setitem(TYPES, name, fields)
    mind.mission.ros = Link()
    mind.rig.knowledge.world.place("dock", Pose2(3.0, 4.0, math.pi), kind="goal")
    mind.rig.knowledge.world.place("near", Pose2(1.0, 0.0, 0.5), kind="goal")
    return mind.mission.ros


@pytest.fixture
def grow(mind, link):
    def grow(line, **keys):
        text = f'<root BTCPP_format="4"><BehaviorTree ID="M">{line}</BehaviorTree></root>'
        build = xml_mission(text, dialect="nav2_servers")
        for key, value in keys.items():
            mind.mission.board[key] = value
        return TreePlan(build(mind.mission), mind.mission).tree

    return grow


ALLOWED = {"sec": 10, "nanosec": 0}


@pytest.mark.parametrize(
    ("line", "server", "goal"),
    [
        ('<NavigateToPose goal="dock"/>', "navigate_to_pose", {"pose": pose(3, 4, math.pi), "behavior_tree": ""}),
        (
            '<NavigateThroughPoses goals="near;dock" server_name="/other/through"/>',
            "/other/through",
            {"poses": [pose(1, 0, 0.5), pose(3, 4, math.pi)], "behavior_tree": ""},
        ),
        (
            '<ComputePathToPose goal="dock" planner_id="Smac"/>',
            "compute_path_to_pose",
            {"goal": pose(3, 4, math.pi), "planner_id": "Smac", "use_start": False},
        ),
        (
            '<ComputePathToPose goal="dock" start="near"/>',
            "compute_path_to_pose",
            {"goal": pose(3, 4, math.pi), "start": pose(1, 0, 0.5), "planner_id": "", "use_start": True},
        ),
        ('<Spin spin_dist="-1.5"/>', "spin", {"target_yaw": -1.5, "time_allowance": ALLOWED}),
        (
            '<BackUp backup_dist="0.3" time_allowance="2.5"/>',
            "backup",
            {
                "target": {"x": 0.3},
                "speed": 0.025,
                "time_allowance": {"sec": 2, "nanosec": 500_000_000},
                "disable_collision_checks": False,
            },
        ),
        ('<DriveOnHeading dist_to_travel="1"/>', "drive_on_heading", {"target": {"x": 1.0}, "speed": 0.025}),
        ('<Wait wait_duration="0.5"/>', "wait", {"time": {"sec": 0, "nanosec": 500_000_000}}),
        (
            '<DockRobot dock_id="bay 2"/>',
            "dock_robot",
            {
                "use_dock_id": True,
                "dock_id": "bay 2",
                "dock_type": "",
                "max_staging_time": 1000.0,
                "navigate_to_staging_pose": True,
            },
        ),
        ("<UndockRobot/>", "undock_robot", {"dock_type": "", "max_undocking_time": 30.0}),
    ],
)
def test_the_goal_of_each_server(grow, link, line, server, goal):
    tree = grow(line)
    assert tree.tick() is RUNNING
    assert link.goals[0].values == goal
    assert [(kind, name) for kind, name, _ in link.opened] == [("action", server)]
    link.goals[0].state, link.goals[0].result = GoalState.SUCCEEDED, Message({"path": {"poses": []}})
    assert tree.tick() is SUCCESS


def test_goals_in_a_message_of_their_own_as_in_later_distributions(grow, link, monkeypatch):
    fields = {"poses": RosField("nav_msgs/msg/Goals"), "behavior_tree": TEXT}
    monkeypatch.setitem(TYPES, "nav2_msgs/action/NavigateThroughPoses_Goal", fields)
    grow('<NavigateThroughPoses goals="near"/>').tick()
    assert link.goals[0].values["poses"] == {"header": {"frame_id": "map"}, "goals": [pose(1, 0, 0.5)]}


def test_a_path_of_nav2_for_its_controller_and_for_our_own_actions(grow, link):
    tree = grow(
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


def test_feedback_result_and_error_code(grow, link):
    tree = grow(
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


def test_a_result_without_error_code_as_in_earlier_distributions(grow, link):
    tree = grow('<Spin error_code_id="{code}"/>')
    tree.tick()
    link.goals[0].state, link.goals[0].result = GoalState.ABORTED, Message({})
    assert tree.tick() is FAILURE
    assert tree.board["code"] == 0
    assert tree.root.feedback_message == "REFUSED: the server of 'spin' aborted the goal"


@pytest.mark.parametrize(("line", "cancelled"), [("<Spin/>", 1), ("<Wait/>", 0), ('<Spin cancel_on_reflex="0"/>', 0)])
def test_reflexes_have_priority_over_what_moves_the_robot(mind, grow, link, line, cancelled):
    tree = grow(line)
    tree.tick()
    link.goals[0].state = GoalState.ACCEPTED
    mind.rig.pipeline.hold(True)
    assert tree.tick() is RUNNING
    assert link.goals[0].cancelled == cancelled


@pytest.mark.parametrize("more", ["", 'cancel_on_reflex="0"', 'cmd_vel="cmd_vel_nav"'])
def test_a_held_gate_cancels_what_moves_the_robot_until_its_release(mind, grow, link, more):
    gate = mind.rig.gate
    tree = grow(f"<Spin {more}/>")
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


def test_a_held_gate_leaves_the_other_servers_alone(mind, grow, link):
    mind.rig.gate.hold("emergency stop")
    grow("<Wait/>").tick()
    assert link.goals[0].cancelled == 0


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


def test_any_heading_is_that_of_the_straight_line(mind, grow, link):
    mind.rig.run()
    grow('<NavigateToPose goal="{post}"/>', post=Pose2(0.0, 2.0, math.nan)).tick()
    turned = link.goals[0].values["pose"]["pose"]["orientation"]
    assert 2 * math.atan2(turned["z"], turned["w"]) == pytest.approx(math.pi / 2, abs=0.05)


@pytest.mark.parametrize(
    ("line", "keys", "says"),
    [
        ('<NavigateToPose goal="{g}"/>', {"g": "dok"}, "the pose of 'dok' is not known"),
        ('<FollowPath path="{p}"/>', {"p": []}, "[] is no path"),
        ('<FollowPath path="{p}"/>', {"p": "route"}, "'route' is no path"),
    ],
)
def test_a_goal_that_cannot_be_made_fails(grow, link, line, keys, says):
    tree = grow(line, **keys)
    assert tree.tick() is FAILURE
    assert says in tree.root.feedback_message
    assert link.goals == []


class TestDialect:
    MISSION = '<root BTCPP_format="4"><BehaviorTree ID="M"><NavigateToPose/></BehaviorTree></root>'

    def test_the_goal_is_a_parameter_of_the_mission(self, mind, link):
        build = xml_mission(self.MISSION, dialect="nav2_servers")
        assert list(mission_parameters(build)) == ["goal"]
        tree = TreePlan(build(mind.mission, goal="dock"), mind.mission).tree
        assert tree.tick() is RUNNING
        assert link.goals[0].values["pose"] == pose(3, 4, math.pi)

    def test_an_unknown_place_is_found_by_a_check(self, mind, link):
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

    def test_a_python_mission_makes_them_from_their_classes(self, mind, link):
        root = nav2_servers.NavigateToPose("go", goal="dock", cancel_on_reflex=False)
        tree = Tree(root, clock=mind.rig.clock, owner=mind.mission)
        assert tree.tick() is RUNNING
        assert link.goals[0].values["pose"] == pose(3, 4, math.pi)

    def test_without_ros_they_fail(self, mind):
        root = nav2_servers.Spin("spin")
        tree = Tree(root, clock=mind.rig.clock, owner=mind.mission)
        assert tree.tick() is FAILURE
        assert "rocs-bt drive" in root.feedback_message


class TestRelay:
    LINE = '<NavigateToPose goal="dock" cmd_vel="cmd_vel_nav" {}/>'

    def begun(self, mind, grow, link, more=""):
        self.tree = grow(self.LINE.replace("{}", more))
        self.tree.tick()
        link.goals[0].state = GoalState.ACCEPTED
        return self.tree

    def drive(self, mind, link, twist=(0.2, 0.0), age=0.0, stamped=True, periods=10):
        for _ in range(periods):
            values = {"linear": {"x": twist[0], "y": 0.0, "z": 0.0}, "angular": {"z": twist[1]}}
            link.newest = Received(Message({"twist": values} if stamped else values), age, 1)
            self.tree.tick()
            mind.rig.run()

    def test_the_commands_pass_the_gate_while_the_goal_is_pursued(self, mind, grow, link):
        tree = self.begun(mind, grow, link)
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
    def test_no_recent_or_no_finite_command_is_rest(self, mind, grow, link, how):
        self.begun(mind, grow, link)
        self.drive(mind, link, **how)
        assert mind.rig.pose.x == 0.0
        assert self.tree.root.status is RUNNING

    def test_a_twist_without_header(self, mind, grow, link):
        self.begun(mind, grow, link, 'cmd_vel_type="geometry_msgs/msg/Twist"')
        self.drive(mind, link, stamped=False)
        assert mind.rig.pose.x > 0.02

    @pytest.mark.parametrize("cancel", ["true", "false"])
    def test_a_reflex_pre_empts_it_and_it_goes_on_afterwards(self, mind, grow, link, cancel):
        tree = self.begun(mind, grow, link, f'cancel_on_reflex="{cancel}"')
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

    def test_another_type_is_refused(self, mind, grow, link):
        with pytest.raises(InputError, match="no type of twists is named 'geometry_msgs/msg/Pose'"):
            grow(self.LINE.replace("{}", 'cmd_vel_type="geometry_msgs/msg/Pose"'))


MESSAGES = {
    "nav2_msgs/action/ComputePathThroughPoses_Goal": {
        "goals": RosField("nav_msgs/msg/Goals"), "start": RosField(STAMPED), "planner_id": TEXT, "use_start": TRUTH,
    },
    "nav2_msgs/action/SmoothPath_Goal": {
        "path": RosField(PATH), "smoother_id": TEXT, "max_smoothing_duration": RosField(DURATION),
        "check_for_collisions": TRUTH,
    },
    "nav2_msgs/action/AssistedTeleop_Goal": {"time_allowance": RosField(DURATION)},
    **{
        f"nav2_msgs/action/{name}_Goal": {
            "start_id": WORD, "start": RosField(STAMPED), "goal_id": WORD, "goal": RosField(STAMPED),
            "use_start": TRUTH, "use_poses": TRUTH,
        }
        for name in ("ComputeRoute", "ComputeAndTrackRoute")
    },
    "nav2_msgs/action/FollowObject_Goal": {
        "pose_topic": TEXT, "max_duration": RosField(DURATION), "tracked_frame": TEXT,
    },
    "action_msgs/srv/CancelGoal_Request": {"goal_info": RosField("action_msgs/msg/GoalInfo")},
    "action_msgs/msg/GoalInfo": {"stamp": RosField("builtin_interfaces/msg/Time")},
    "std_srvs/srv/Empty_Request": {},
    "nav2_msgs/srv/Toggle_Request": {"enable": TRUTH},
    "nav2_msgs/srv/GetCosts_Request": {"use_footprint": TRUTH, "poses": RosField(STAMPED, array=True)},
    "nav2_msgs/srv/IsPathValid_Request": {"path": RosField(PATH), "max_cost": WORD, "layer_name": TEXT},
    "nav2_msgs/srv/ClearEntireCostmap_Request": {"plugins": RosField("string", array=True)},
    "nav2_msgs/srv/ClearCostmapExceptRegion_Request": {"reset_distance": NUMBER},
    "nav2_msgs/srv/ClearCostmapAroundRobot_Request": {"reset_distance": NUMBER},
    "nav2_msgs/srv/ClearCostmapAroundPose_Request": {"pose": RosField(STAMPED), "reset_distance": NUMBER},
}  # fmt: skip  # a table
PATH_VALUES = {"header": {"frame_id": "map"}, "poses": [pose(0, 0), pose(3, 0)]}
TEN, ONE = {"sec": 10, "nanosec": 0}, {"sec": 1, "nanosec": 500_000_000}
IDS = {"start_id": 1, "goal_id": 2, "use_start": False, "use_poses": False}
CALLS = {
    # line, name of the action or service, goal or request, result or response, outputs
    "NavigateToPose": ('goal="near"', "navigate_to_pose", {"pose": pose(1, 0, 0.5), "behavior_tree": ""}, {}, {}),
    "NavigateThroughPoses": (
        'goals="near"', "navigate_through_poses", {"poses": [pose(1, 0, 0.5)], "behavior_tree": ""}, {}, {},
    ),
    "ComputePathToPose": (
        'goal="near" use_start="false" start="dock"', "compute_path_to_pose",
        {"goal": pose(1, 0, 0.5), "planner_id": "", "use_start": False}, {"path": PATH_VALUES}, {"path": PATH_VALUES},
    ),
    "ComputePathThroughPoses": (
        'goals="near;dock" start="near"', "compute_path_through_poses",
        {
            "goals": {"header": {"frame_id": "map"}, "goals": [pose(1, 0, 0.5), pose(3, 4, math.pi)]},
            "start": pose(1, 0, 0.5), "planner_id": "", "use_start": True,
        },
        {"path": PATH_VALUES, "last_reached_index": 1}, {"path": PATH_VALUES, "last_reached_index": 1},
    ),
    "SmoothPath": (
        'unsmoothed_path="{given}"', "smooth_path",
        {"path": PATH_VALUES, "smoother_id": "", "max_smoothing_duration": {"sec": 3, "nanosec": 0},
         "check_for_collisions": False},
        {"path": PATH_VALUES, "smoothing_duration": ONE, "was_completed": True},
        {"smoothed_path": PATH_VALUES, "smoothing_duration": 1.5, "was_completed": True},
    ),
    "FollowPath": (
        'path="{given}"', "follow_path", {"path": PATH_VALUES, "controller_id": "", "goal_checker_id": ""}, {}, {},
    ),
    "Spin": ("", "spin", {"target_yaw": 1.57, "time_allowance": TEN}, {}, {}),
    "BackUp": (
        "", "backup",
        {"target": {"x": 0.15}, "speed": 0.025, "time_allowance": TEN, "disable_collision_checks": False}, {}, {},
    ),
    "DriveOnHeading": ("", "drive_on_heading", {"target": {"x": 0.15}, "speed": 0.025}, {}, {}),
    "Wait": ("", "wait", {"time": {"sec": 1, "nanosec": 0}}, {}, {}),
    "AssistedTeleop": ("", "assisted_teleop", {"time_allowance": TEN}, {}, {}),
    "ComputeRoute": (
        'start_id="1" goal_id="2" goal="near"', "compute_route", IDS,
        {"route": {"nodes": []}, "path": PATH_VALUES, "planning_time": ONE},
        {"route": {"nodes": []}, "path": PATH_VALUES, "planning_time": 1.5},
    ),
    "ComputeAndTrackRoute": (
        'use_poses="true" goal="near"', "compute_and_track_route",
        {"start_id": 0, "goal_id": 0, "use_start": False, "use_poses": True, "goal": pose(1, 0, 0.5)},
        {"execution_duration": ONE}, {"execution_duration": 1.5},
    ),
    "DockRobot": (
        'dock_pose="near" use_dock_id="false"', "dock_robot",
        {"use_dock_id": False, "dock_id": "", "dock_pose": pose(1, 0, 0.5), "dock_type": "", "max_staging_time": 1000.0,
         "navigate_to_staging_pose": True},
        {"success": True, "num_retries": 2}, {"success": True, "num_retries": 2},
    ),
    "UndockRobot": (
        "", "undock_robot", {"dock_type": "", "max_undocking_time": 30.0}, {"success": True}, {"success": True},
    ),
    "FollowObject": (
        "", "follow_object",
        {"pose_topic": "dynamic_pose", "max_duration": {"sec": 0, "nanosec": 0}, "tracked_frame": ""},
        {"total_elapsed_time": ONE}, {"total_elapsed_time": 1.5},
    ),
    "ClearEntireCostmap": (
        'service_name="c/clear" plugins="a; b"', "c/clear", {"plugins": ["a", "b"]}, {"success": True}, {},
    ),
    "ClearCostmapExceptRegion": ('service_name="c"', "c", {"reset_distance": 1.0}, {}, {}),
    "ClearCostmapAroundRobot": ('service_name="c"', "c", {"reset_distance": 1.0}, {}, {}),
    "ClearCostmapAroundPose": (
        'service_name="c" pose="near"', "c", {"reset_distance": 1.0, "pose": pose(1, 0, 0.5)}, {}, {},
    ),
    "ReinitializeGlobalLocalization": ("", "reinitialize_global_localization", {}, {}, {}),
    "ToggleCollisionMonitor": ('enable="false"', "collision_monitor/toggle", {"enable": False}, {}, {}),
    "ValidatePath": (
        'path="{given}"', "is_path_valid", {"path": PATH_VALUES, "max_cost": 254, "layer_name": ""},
        {"is_valid": True, "invalid_pose_indices": [1]}, {"collision_poses": [Pose2(3.0, 0.0, 0.0)]},
    ),
    "IsPathValid": ('path="{given}"', "is_path_valid", {"path": PATH_VALUES, "max_cost": 253}, {"is_valid": True}, {}),
    "CheckPoseOccupancy": (
        'pose="near"', "/global_costmap/get_cost_global_costmap",
        {"use_footprint": True, "poses": [pose(1, 0, 0.5)]}, {"costs": [254.0]}, {},
    ),
    "RemoveInCollisionGoals": (
        'input_goals="near;dock"', "/global_costmap/get_cost_global_costmap",
        {"use_footprint": True, "poses": [pose(1, 0, 0.5), pose(3, 4, math.pi)]},
        {"costs": [254.0, 255.0]}, {"output_goals": ["dock"]},
    ),
    **{
        f"Cancel{node}": ("", f"{server}/_action/cancel_goal", {}, {}, {})
        for node, server in {
            "Control": "follow_path", "BackUp": "backup", "DriveOnHeading": "drive_on_heading", "Spin": "spin",
            "AssistedTeleop": "assisted_teleop", "Wait": "wait", "ComputeAndTrackRoute": "compute_and_track_route",
            "FollowObject": "follow_object",
        }.items()
    },
}  # fmt: skip  # a table


@pytest.fixture
def call(grow, link, monkeypatch):
    for name, fields in MESSAGES.items():
        monkeypatch.setitem(TYPES, name, fields)
        for part in ("Feedback", "Result") if name.endswith("_Goal") else ():
            monkeypatch.setitem(TYPES, name.replace("_Goal", f"_{part}"), {})

    def call(tag, more=""):
        inside, *rest = CALLS[tag]
        outputs = rest[-1] if "=" not in more else {}
        ports = " ".join(f'{name}="{{{name}}}"' for name in outputs)
        return grow(f"<{tag} {inside} {ports} {more}/>", given=PATH_VALUES), *rest

    return call


def test_the_table_has_every_node_that_calls_nav2():
    assert CALLS.keys() | {node.tag for node in TOPICS} == {node.tag for node in NAV2_SERVERS}


@pytest.mark.parametrize("tag", CALLS)
def test_each_call_has_the_fields_of_its_ports_and_writes_those_of_its_result(call, link, tag):
    tree, name, request, received, outputs = call(tag)
    assert tree.tick() is RUNNING
    (made,) = [*link.goals, *link.calls]
    assert (made.values, link.opened[0][1]) == (request, name)
    if link.goals:
        made.state, made.result = GoalState.SUCCEEDED, Message(received)
    else:
        made.response = Message(received)
    assert tree.tick() is SUCCESS
    assert {port: tree.board[port] for port in outputs} == outputs


@pytest.mark.parametrize("tag", CALLS)
def test_each_call_fails_without_a_server_and_without_success(call, link, mind, tag):
    link.here = False
    tree, *_ = call(tag)
    while (outcome := tree.tick()) is RUNNING:
        mind.rig.run()
    assert (outcome, "UNHEARD" in tree.root.feedback_message) == (FAILURE, True)
    link.here = True
    assert tree.tick() is RUNNING
    (made,) = [*link.goals, *link.calls]
    if link.goals:
        made.state, made.result = GoalState.ABORTED, Message({"error_code": 7})
    else:
        made.response = Message({"success": False, "is_valid": False, "costs": []})
    outcome = SUCCESS if tag == "AssistedTeleop" else FAILURE
    assert tree.tick() is outcome


def test_goals_in_collision_are_marked_and_kept_if_the_service_fails(grow, call, link):
    statuses = [WaypointStatus("near"), WaypointStatus("dock", waypoint_index=1)]
    more = 'input_waypoint_statuses="{s}" output_waypoint_statuses="{s}" output_goals="{o}"'
    tree, *_ = call("RemoveInCollisionGoals", more)
    tree.board["s"] = statuses
    tree.tick()
    link.calls[0].response = Message({"success": True, "costs": [254.0, 10.0]})
    assert tree.tick() is SUCCESS
    assert (tree.board["o"], [s.waypoint_status for s in tree.board["s"]]) == (["dock"], [2, 0])
    tree.tick()
    link.calls[1].response = Message({"success": False})
    assert (tree.tick(), tree.board["o"]) == (FAILURE, ["near", "dock"])
    assert grow('<RemoveInCollisionGoals input_goals="{none}"/>').tick() is FAILURE


def newest(value, count=1):
    return Received(Message(value), 0.0, count)


@pytest.mark.parametrize("tag", [node.tag for node in TOPICS if node.tag.endswith("Selector")])
def test_a_selector_writes_the_last_text_of_its_topic(grow, link, tag):
    what = "".join(f"_{c.lower()}" if c.isupper() else c for c in tag.removesuffix("Selector")).strip("_")
    tree = grow(f'<{tag} default_{what}="a" selected_{what}="{{out}}"/>')
    assert (tree.tick(), tree.board["out"]) == (SUCCESS, "a")
    assert ("subscription", f"{what}_selector", "std_msgs/msg/String", "latched") in link.opened
    link.topics[f"{what}_selector"] = newest({"data": "b"})
    assert (tree.tick(), tree.board["out"]) == (SUCCESS, "b")


@pytest.mark.parametrize(
    ("line", "state", "outcome"),
    [
        ('<IsBatteryLow min_battery="0.2"/>', {"percentage": 0.2, "voltage": 12.0}, SUCCESS),
        ('<IsBatteryLow min_battery="0.2"/>', {"percentage": 0.3, "voltage": 12.0}, FAILURE),
        ('<IsBatteryLow min_battery="11.5" is_voltage="true"/>', {"percentage": 1.0, "voltage": 11.4}, SUCCESS),
        ("<IsBatteryCharging/>", {"power_supply_status": 1}, SUCCESS),
        ("<IsBatteryCharging/>", {"power_supply_status": 2}, FAILURE),
    ],
)
def test_a_battery_is_read_from_its_topic(grow, link, line, state, outcome):
    tree = grow(line)
    assert tree.tick() is FAILURE
    link.topics["/battery_status"] = newest(state)
    assert tree.tick() is outcome


def test_a_newer_goal_of_the_topic_replaces_the_given_one(grow, link):
    tree = grow('<GoalUpdater input_goal="{in}" output_goal="{out}"><AlwaysSuccess/></GoalUpdater>', **{"in": "near"})
    assert (tree.tick(), tree.board["out"]) == (SUCCESS, pose(1, 0, 0.5))
    assert [opened[1] for opened in link.opened] == ["goal_update"]
    message = {"header": {"stamp": {"sec": 5, "nanosec": 1}, "frame_id": "map"}, "pose": {"position": {"x": 2.0}}}
    link.topics["goal_update"] = newest(message)
    assert (tree.tick(), tree.board["out"]) == (SUCCESS, message)
    for stamp, out in (((5, 1), message), ((6, 0), None)):  # an equal stamp counts, an older one does not
        given = {**message, "header": {"stamp": dict(zip(("sec", "nanosec"), stamp, strict=True))}}
        tree.board["in"] = given
        assert (tree.tick(), tree.board["out"]) == (SUCCESS, out or given)


def test_a_controller_is_paused_and_resumed_by_its_services(grow, link):
    tree = grow(
        '<PauseResumeController pause_service_name="pause" resume_service_name="resume"><KeepRunningUntilFailure>'
        "<Script code=\"at := 'run'\"/></KeepRunningUntilFailure><KeepRunningUntilFailure>"
        "<Script code=\"at := 'paused'\"/></KeepRunningUntilFailure></PauseResumeController>"
    )
    assert [(kind, name) for kind, name in link.opened] == [("trigger", "pause"), ("trigger", "resume")]

    def at(ticks=3):
        for _ in range(ticks):
            assert tree.tick() is RUNNING
        return tree.board["at"]

    assert at() == "run"
    link.triggered = {"pause"}
    assert (at(), at()) == ("paused", "paused")
    link.triggered = {"resume"}
    assert (at(), at()) == ("run", "run")
