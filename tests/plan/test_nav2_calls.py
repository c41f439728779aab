"""Each node that calls an action or a service of Nav2, or reads a topic, on a fake connection."""

import math

import pytest

from rocs_bt.base.geometry import Pose2
from rocs_bt.nav2.goals import WaypointStatus
from rocs_bt.ros2.nodes import NAV2_SERVERS
from rocs_bt.ros2.nodes.nav2_topics import TOPIC_NODES
from rocs_bt.ros2.ros_link import GoalState, Received
from rocs_bt.trees.nodes import FAILURE, RUNNING, SUCCESS

from .nav2_msgs import pose
from .ros_fake import Message

PATH_VALUES = {"header": {"frame_id": "map"}, "poses": [pose(0, 0), pose(3, 0)]}
TEN, ONE = {"sec": 10, "nanosec": 0}, {"sec": 1, "nanosec": 500_000_000}
IDS = {"start_id": 1, "goal_id": 2, "use_start": False, "use_poses": False}
CALLS = {
    # line, name of the action or service, goal or request, result or response, outputs
    "NavigateToPose": ('goal="near"', "navigate_to_pose", {"pose": pose(1, 0, 0.5), "behavior_tree": ""}, {}, {}),
    "NavigateThroughPoses": (
        'goals="near;dock" server_name="/other/through"', "/other/through",
        {"poses": [pose(1, 0, 0.5), pose(3, 4, math.pi)], "behavior_tree": ""}, {}, {},
    ),
    "ComputePathToPose": (
        'goal="near" use_start="false" start="dock" planner_id="Smac"', "compute_path_to_pose",
        {"goal": pose(1, 0, 0.5), "planner_id": "Smac", "use_start": False},
        {"path": PATH_VALUES}, {"path": PATH_VALUES},
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
    "Spin": ('spin_dist="-1.5"', "spin", {"target_yaw": -1.5, "time_allowance": TEN}, {}, {}),
    "BackUp": (
        'backup_dist="0.3" time_allowance="2.5"', "backup",
        {"target": {"x": 0.3}, "speed": 0.025, "time_allowance": {"sec": 2, "nanosec": 500_000_000},
         "disable_collision_checks": False}, {}, {},
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
}  # fmt: skip  # a request and its answer share lines


@pytest.fixture
def call(served):
    def call(tag, more=""):
        inside, *rest = CALLS[tag]
        outputs = rest[-1] if "=" not in more else {}
        ports = " ".join(f'{name}="{{{name}}}"' for name in outputs)
        return served(f"<{tag} {inside} {ports} {more}/>", given=PATH_VALUES), *rest

    return call


def test_the_table_has_every_node_that_calls_nav2():
    assert CALLS.keys() | {node.tag for node in TOPIC_NODES} == {node.tag for node in NAV2_SERVERS}


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


def test_goals_in_collision_are_marked_and_kept_if_the_service_fails(served, call, link):
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
    assert served('<RemoveInCollisionGoals input_goals="{none}"/>').tick() is FAILURE


def newest(value, count=1):
    return Received(Message(value), 0.0, count)


@pytest.mark.parametrize("tag", [node.tag for node in TOPIC_NODES if node.tag.endswith("Selector")])
def test_a_selector_writes_the_last_text_of_its_topic(served, link, tag):
    what = "".join(f"_{c.lower()}" if c.isupper() else c for c in tag.removesuffix("Selector")).strip("_")
    tree = served(f'<{tag} default_{what}="a" selected_{what}="{{out}}"/>')
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
def test_a_battery_is_read_from_its_topic(served, link, line, state, outcome):
    tree = served(line)
    assert tree.tick() is FAILURE
    link.topics["/battery_status"] = newest(state)
    assert tree.tick() is outcome


def test_a_newer_goal_of_the_topic_replaces_the_given_one(served, link):
    tree = served('<GoalUpdater input_goal="{in}" output_goal="{out}"><AlwaysSuccess/></GoalUpdater>', **{"in": "near"})
    assert (tree.tick(), tree.board["out"]) == (SUCCESS, pose(1, 0, 0.5))
    assert [opened[1] for opened in link.opened] == ["goal_update"]
    message = {"header": {"stamp": {"sec": 5, "nanosec": 1}, "frame_id": "map"}, "pose": {"position": {"x": 2.0}}}
    link.topics["goal_update"] = newest(message)
    assert (tree.tick(), tree.board["out"]) == (SUCCESS, message)
    for stamp, out in (((5, 1), message), ((6, 0), None)):  # an equal stamp counts, an older one does not
        given = {**message, "header": {"stamp": dict(zip(("sec", "nanosec"), stamp, strict=True))}}
        tree.board["in"] = given
        assert (tree.tick(), tree.board["out"]) == (SUCCESS, out or given)


def test_a_controller_is_paused_and_resumed_by_its_services(served, link):
    tree = served(
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
