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
from rocs_bt.plan.ros2 import nav2_servers
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
