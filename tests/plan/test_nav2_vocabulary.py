"""Every node of Nav2 is known in both dialects with its ports, and no value that is missing is an exception."""

# ruff: noqa: E501 - a document stands in one line

import math

import numpy as np
import pytest

from rocs_bt.actions import ACTIONS
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.interfaces.vocabulary import dialects
from rocs_bt.knowledge import OccupancyGrid
from rocs_bt.nav2.nodes import NAV2, OWN, nav2_nodes
from rocs_bt.nav2.vocabulary import VOCABULARY
from rocs_bt.plan import xml_mission
from rocs_bt.plan.dialects import elsewhere, shipped_nodes
from rocs_bt.trees.nodes import Tree
from rocs_bt.trees.status import FAILURE, RUNNING, SUCCESS
from rocs_bt.trees.xml import load_xml

from .checking import check_mission

SERVED = "server_name server_timeout error_code_id error_msg"
CANCEL, FRAMES, CODE = "server_name server_timeout", "global_frame robot_base_frame", "error_code"
CLEAR = "service_name server_timeout plugins"
PORTS = {
    "ComputePathToPose": f"goal start planner_id use_start viapoints path {SERVED}",
    "ComputePathThroughPoses": f"goals start planner_id path last_reached_index {SERVED}",
    "FollowPath": f"path controller_id goal_checker_id progress_checker_id path_handler_id tracking_feedback {SERVED}",
    "SmoothPath": f"unsmoothed_path max_smoothing_duration check_for_collisions smoother_id smoothed_path smoothing_duration was_completed {SERVED}",
    "NavigateToPose": f"goal behavior_tree {SERVED}",
    "NavigateThroughPoses": f"goals behavior_tree {SERVED}",
    "Spin": f"spin_dist time_allowance is_recovery disable_collision_checks {SERVED}",
    "BackUp": f"backup_dist backup_speed time_allowance disable_collision_checks {SERVED}",
    "DriveOnHeading": f"dist_to_travel speed time_allowance disable_collision_checks {SERVED}",
    "Wait": f"wait_duration {SERVED}",
    "AssistedTeleop": f"time_allowance is_recovery {SERVED}",
    "ComputeRoute": f"start goal start_id goal_id use_start use_poses route path planning_time {SERVED}",
    "ComputeAndTrackRoute": f"start goal start_id goal_id use_start use_poses execution_duration last_node_id next_node_id current_edge_id route path rerouted {SERVED}",
    "DockRobot": f"use_dock_id dock_id dock_pose dock_type max_staging_time navigate_to_staging_pose success num_retries {SERVED}",
    "UndockRobot": f"dock_type max_undocking_time success {SERVED}",
    "FollowObject": f"pose_topic max_duration tracked_frame total_elapsed_time {SERVED}",
    **{
        f"Cancel{name}": CANCEL
        for name in [
            "Control",
            "BackUp",
            "DriveOnHeading",
            "Spin",
            "AssistedTeleop",
            "Wait",
            "ComputeAndTrackRoute",
            "FollowObject",
        ]
    },
    "ClearEntireCostmap": CLEAR,
    "ClearCostmapExceptRegion": f"reset_distance {CLEAR}",
    "ClearCostmapAroundRobot": f"reset_distance {CLEAR}",
    "ClearCostmapAroundPose": f"pose reset_distance {CLEAR}",
    "ReinitializeGlobalLocalization": "service_name server_timeout",
    "ToggleCollisionMonitor": "enable service_name server_timeout",
    "IsPathValid": "path server_timeout max_cost consider_unknown_as_obstacle",
    "ValidatePath": "path max_cost consider_unknown_as_obstacle layer_name footprint stop_at_first_collision max_lookahead_distance collision_poses",
    "CheckPoseOccupancy": "pose cost_threshold use_footprint consider_unknown_as_obstacle",
    "RemoveInCollisionGoals": "input_goals cost_threshold use_footprint consider_unknown_as_obstacle input_waypoint_statuses output_goals output_waypoint_statuses",
    "TruncatePath": "input_path distance output_path",
    "TruncatePathLocal": "input_path distance_forward distance_backward transform_tolerance pose angular_distance_weight max_robot_pose_search_dist robot_frame robot_base_frame output_path",
    "RemovePassedGoals": "input_goals radius robot_base_frame global_frame input_waypoint_statuses output_goals output_waypoint_statuses",
    "GetNextFewGoals": "input_goals num_goals output_goals",
    "AppendGoalPoseToGoals": "goal_pose input_goals output_goals",
    "ExtractRouteNodesAsGoals": "route goals",
    "GetPoseFromPath": "path index pose",
    "GetCurrentPose": f"{FRAMES} current_pose",
    "ConcatenatePaths": "input_path1 input_path2 output_path",
    **{
        f"{what.title().replace('_', '')}Selector": f"topic_name default_{what} selected_{what}"
        for what in ["planner", "controller", "smoother", "goal_checker", "progress_checker", "path_handler"]
    },
    "CheckStopStatus": "velocity_threshold duration_stopped",
    "IsStopped": "velocity_threshold duration_stopped",
    "GoalReached": f"goal {FRAMES}",
    "GoalUpdated": "goal goals",
    "GlobalUpdatedGoal": "goal goals",
    "IsGoalNearby": f"path proximity_threshold max_robot_pose_search_dist {FRAMES}",
    "IsWithinPathTrackingBounds": "max_error_left max_error_right max_error_heading tracking_feedback",
    "ArePosesNear": "ref_pose target_pose global_frame tolerance",
    "DistanceTraveled": f"distance {FRAMES}",
    "TimeExpired": "seconds",
    "PathExpiringTimer": "seconds path",
    "AreErrorCodesPresent": "error_code error_codes_to_check",
    **{f"WouldA{name}RecoveryHelp": CODE for name in ("Planner", "Controller", "Smoother", "Route")},
    "InitialPoseReceived": "initial_pose_received",
    "TransformAvailable": "child parent",
    "IsBatteryLow": "min_battery battery_topic is_voltage",
    "IsBatteryCharging": "battery_topic",
    "IsStuck": "",
    "PipelineSequence": "",
    "RecoveryNode": "number_of_retries",
    "RoundRobin": "wrap_around",
    "NonblockingSequence": "",
    "PersistentSequence": "current_child_idx",
    "PauseResumeController": "pause_service_name resume_service_name",
    "RateController": "hz",
    "DistanceController": f"distance {FRAMES}",
    "SpeedController": "min_rate max_rate min_speed max_speed goal goals",
    "GoalUpdatedController": "goal goals",
    "GoalUpdater": "input_goal output_goal input_goals output_goals",
    "PathLongerOnApproach": "path prox_len length_factor",
    "SingleTrigger": "",
}


@pytest.mark.parametrize("dialect", [d for d in dialects() if d != "rocs"])
def test_every_node_has_the_ports_of_nav2(dialect):
    nodes = shipped_nodes(dialect)
    assert not {tag: missing for tag, ports in PORTS.items() if (missing := set(ports.split()) - set(nodes[tag].ports))}
    assert len(PORTS) >= 81


LEAVES = sorted(node.tag for node in OWN if not node.min_children)


@pytest.fixture
def grow(mind):
    mind.mission.content = Catalog()
    mind.mission.knowledge.world.place("goal", Pose2(2.0, 0.0, 0.0), "goal")

    def grow(inside, distribution="lyrical", **board):
        text = f'<root BTCPP_format="4"><BehaviorTree ID="Main">{inside}</BehaviorTree></root>'
        made = Tree(load_xml(text, nav2_nodes(distribution)), clock=mind.rig.clock, owner=mind.mission)
        made.board.update(board)
        return made

    return grow


@pytest.mark.parametrize("given", [None, "", []], ids=["missing", "empty text", "empty list"])
@pytest.mark.parametrize("tag", LEAVES)
def test_a_value_that_is_missing_is_no_exception(mind, grow, tag, given):
    """Every input port is a key without a value, or with an empty one: at most the node fails."""
    kinds = {str: "", object: given} if given is not None else {}
    inputs = [p for p in NAV2[tag].ports.values() if p.direction.name == "INPUT" and p.name != "max_preemptions"]
    keys = " ".join(f'{p.name}="{{{p.name}}}"' for p in inputs)
    filled = {p.name: value for p in inputs if (value := kinds.get(p.kind if p.kind is str else object)) is not None}
    filled = {name: value for name, value in filled.items() if NAV2[tag].ports[name].kind not in (int, float, bool)}
    made = grow(f"<{tag} {keys}/>", **({} if given is None else {n: v for n, v in filled.items() if n != "plugins"}))
    assert made.tick() in (SUCCESS, FAILURE, RUNNING)
    made.halt()


@pytest.mark.parametrize(("distribution", "code"), [("humble", 0), ("jazzy", 103), ("kilted", 103), ("lyrical", 1)])
@pytest.mark.parametrize("board", [{}, {"path": []}, {"path": {"poses": []}}])
def test_no_path_to_follow_is_a_failure_with_the_code_of_the_distribution(grow, distribution, code, board):
    made = grow("<FollowPath path='{path}' error_code_id='{code}' error_msg='{why}'/>", distribution, **board)
    assert made.tick() is FAILURE
    assert (made.board["code"], made.board["why"]) == (code, "CANNOT: the path is empty")


@pytest.mark.parametrize(
    ("tag", "code"),
    [("ComputePathToPose goal", 202), ("ComputePathThroughPoses goals", 309), ("ComputeRoute goal", 403)],
)
def test_no_goal_is_a_failure_with_a_code_and_an_empty_path(grow, tag, code):
    made = grow(f"<{tag}='{{gaol}}' path='{{path}}' error_code_id='{{code}}' error_msg='{{why}}'/>", path=[(0.0, 0.0)])
    assert (made.tick(), made.board["code"], list(made.board["path"])) == (FAILURE, code, [])
    assert made.board["why"]


def test_a_cancelled_goal_is_a_success(mind, grow):
    text = "<Parallel success_count='2'><FollowPath path='{path}' error_code_id='{code}'/><Sequence><Delay delay_msec='300'><AlwaysSuccess/></Delay><CancelControl/></Sequence></Parallel>"
    root = grow(text).root
    mind.mission.board["path"] = [(0.0, 0.0), (5.0, 0.0)]
    mind.start(root)
    mind.until_done()
    assert (mind.plan.status, mind.mission.board["code"]) == ("SUCCESS", 0)
    assert mind.mission.knowledge.robot.pose(mind.rig.clock.now()).x < 1.0


LINE = [Pose2(0.5 * i, 0.0, 0.0) for i in range(11)]


@pytest.mark.parametrize(
    ("attributes", "distribution", "wanted"),
    [
        ("distance_forward='1' distance_backward='0.6'", "lyrical", (0.5, 2.0)),
        ("distance_forward='-1' distance_backward='0'", "lyrical", (1.0, 5.0)),
        ("distance_forward='-1' distance_backward='0'", "jazzy", (1.0, 1.0)),
        ("distance_forward='0.99' distance_backward='-1'", "lyrical", (1.0, 1.5)),
    ],
)
def test_the_part_of_a_path_around_a_pose(grow, attributes, distribution, wanted):
    node = (
        f"<TruncatePathLocal input_path='{{path}}' output_path='{{out}}' pose='0;map;1.1;0.2;0;0;0;0;1' {attributes}/>"
    )
    made = grow(node, distribution, path=LINE)
    assert made.tick() is SUCCESS
    assert (made.board["out"][0].x, made.board["out"][-1].x) == wanted


def test_a_path_is_valid_until_an_obstacle_is_on_it(mind, grow):
    """The path ahead of the robot counts, not the part behind it, and with a look-ahead not the end."""
    world = mind.mission.knowledge.world
    nodes = "<{}/>", "<{} max_lookahead_distance='1.0'/>"
    whole, ahead, before = (
        (grow(n.format("ValidatePath"), path=LINE) for n in nodes),
        None,
        grow("<IsPathValid/>", path=LINE),
    )
    whole, ahead = whole
    assert [t.tick() for t in (whole, ahead, before)] == [SUCCESS] * 3
    world.place("box", Pose2(3.0, 0.0, 0.0), "object", length=0.5, width=0.5)
    assert [t.tick() for t in (whole, ahead, before)] == [FAILURE, SUCCESS, FAILURE]
    mind.mission.knowledge.robot.pose = lambda *_: Pose2(4.5, 0.0, 0.0)
    assert [t.tick() for t in (whole, ahead, before)] == [SUCCESS] * 3
    mind.mission.knowledge.robot.pose = lambda *_: Pose2(math.nan, math.nan, math.nan)
    assert [t.tick() for t in (whole, ahead, before)] == [FAILURE, FAILURE, SUCCESS]


@pytest.mark.parametrize("body", [{"length": 0.5, "width": 0.4}, {"radius": 0.25}], ids=["box", "round"])
@pytest.mark.parametrize(
    ("gap", "seen", "attributes", "outcome"),
    [
        (0.0, True, "", FAILURE),
        (1.2, True, "", SUCCESS),
        (0.3, True, "", FAILURE),  # the middle of the gap is free, but not for the hull
        (1.2, False, "", SUCCESS),
        (1.2, False, "consider_unknown_as_obstacle='true'", FAILURE),
        (1.2, True, "consider_unknown_as_obstacle='true'", SUCCESS),
        (1.0, True, "max_cost='1'", FAILURE),  # within the inflation of the wall
    ],
)
@pytest.mark.parametrize("tag", ["ValidatePath", "IsPathValid"])
def test_a_path_is_judged_by_a_wall_that_is_only_in_the_map(mind, grow, tag, gap, seen, attributes, outcome, body):
    knowledge = mind.mission.knowledge
    knowledge.graph.set(knowledge.agent, **body)
    grid = knowledge.world.occupancy = OccupancyGrid(0.05, 20.0)
    wall = [(3.0, side * y) for side in (-1.0, 1.0) for y in np.arange(0.5 * gap, 3.0, 0.04)]
    free = grid.cells(np.array([(x, y) for x in np.arange(-1.0, 6.0, 0.04) for y in np.arange(-1.0, 1.0, 0.04)]))
    grid.add_scan(np.array(wall), np.unique(free, axis=0) if seen else np.empty((0, 2), dtype=np.intp))
    made = grow(f"<{tag} {attributes}/>", path=LINE)
    assert made.tick() is outcome
    assert not list(knowledge.world.objects())


def test_goals_in_obstacles_are_removed(mind, grow):
    mind.mission.knowledge.world.place("box", Pose2(3.0, 0.0, 0.0), "object", length=0.5, width=0.5)
    made = grow("<RemoveInCollisionGoals input_goals='{in}' output_goals='{out}'/>", **{"in": LINE[::3]})
    assert made.tick() is SUCCESS
    assert [pose.x for pose in made.board["out"]] == [0.0, 1.5, 4.5]
    assert grow("<CheckPoseOccupancy pose='0;map;3;0;0;0;0;0;1'/>").tick() is SUCCESS
    assert grow("<CheckPoseOccupancy pose='0;map;1;0;0;0;0;0;1'/>").tick() is FAILURE


@pytest.mark.parametrize("dialect", ["nav2", "nav2_servers", "nav2:humble", "nav2_servers:kilted"])
def test_a_mission_with_every_leaf_loads(mind, dialect):
    """One mission in the words of Nav2's files, with every leaf and the ports that these files use."""

    def line(tag):
        node = shipped_nodes(dialect)[tag]
        given = {n: f"{{{tag}_{n}}}" for n in PORTS[tag].split()}
        given |= {
            n: v
            for n, v in {"server_name": "a/b", "service_name": "a/b", "error_codes_to_check": "1;2"}.items()
            if n in given
        }
        assert set(given) <= set(node.ports)
        return f"<{tag} " + " ".join(f'{n}="{v}"' for n, v in given.items()) + "/>"

    leaves = "".join(line(tag) for tag in PORTS if not shipped_nodes(dialect)[tag].min_children)
    text = f'<root BTCPP_format="4"><BehaviorTree ID="M"><Sequence>{leaves}</Sequence></BehaviorTree></root>'
    build = Catalog().with_content(xml_mission(text, dialect=dialect))
    found = check_mission(
        build, actions=mind.rig.actions, knowledge=mind.rig.knowledge, clock=mind.rig.clock, parameters={}
    )
    assert not [str(fault) for fault in found if not fault.warning]


def test_a_mission_is_recognised_by_nodes_that_only_nav2_has():
    assert elsewhere().keys() & ACTIONS.keys() == VOCABULARY.common
