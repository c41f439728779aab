"""Error codes and reasons of Nav2's nodes: for all failures that the simulator can tell apart, and without ROS."""

import itertools
import math

import numpy as np
import pytest

from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.declare import summary_of
from rocs_bt.interfaces.action import ActionFailed, Failure, Reason
from rocs_bt.knowledge import OccupancyGrid
from rocs_bt.nav2.lenient import Served
from rocs_bt.nav2.motion import _Move
from rocs_bt.nav2.nodes import NAV2
from rocs_bt.plan import TreePlan, mission_parameters, xml_mission
from rocs_bt.ros2.nodes import NAV2_SERVERS
from rocs_bt.trees.status import FAILURE, RUNNING, SUCCESS, outcome_name

GOAL = Pose2(4.0, 0.0, 0.0)


@pytest.fixture
def grow(mind):
    mind.mission.content = Catalog()
    knowledge = mind.mission.knowledge
    knowledge.world.place("goal", GOAL, "goal")
    knowledge.graph.set(knowledge.agent, length=0.5, width=0.4)

    def grow(inside, dialect="nav2", **board):
        text = f'<root BTCPP_format="4"><BehaviorTree ID="Main">{inside}</BehaviorTree></root>'
        build = Catalog().with_content(xml_mission(text, dialect=dialect))
        given = {name: board.pop(name, "goal") for name in mission_parameters(build)}
        mind.mission.board.update(board)
        return TreePlan(build(mind.mission, **given), mind.mission).tree

    return grow


def box(x, y, half):
    """Outline of a square in the map."""
    side = np.arange(-half, half + 0.01, 0.04)
    return [(x + s * half, y + a) for s in (-1, 1) for a in side] + [
        (x + a, y + s * half) for s in (-1, 1) for a in side
    ]


PLACES = {  # obstacle: position, size; code, and a part of the reason
    "goal in a box": (((4.0, 0.0), 0.15), 6, "the goal is occupied: "),
    "goal touches a box": (((4.3, 0.0), 0.1), 6, "the goal is occupied: "),
    "start in a box": (((0.0, 0.0), 0.15), 5, "the start is occupied: "),
    "goal in a closed room": (((4.0, 0.0), 1.0), 8, "the map contains no path"),
    "start in a closed room": (((0.0, 0.0), 1.0), 8, "the map contains no path"),
}
OTHERS = {  # attributes, code, outcome of the condition on recoveries
    "lost": ('goal="goal" goals="goal"', 2, FAILURE),
    "no such planner": ('goal="goal" goals="goal" planner_id="{none}"', 1, FAILURE),
    "no such place": ('goal="nowhere" goals="goal;nowhere"', 0, SUCCESS),
    "a goal without a position": ('goal="{bad}" goals="{bads}"', 0, SUCCESS),
}
PLANNERS = {"ComputePathToPose": 200, "ComputePathThroughPoses": 300}


def planned(grow, tag, attributes, **board):
    """Outcome of the condition on recoveries after a planner that failed, the blackboard, and its message."""
    attributes = attributes.replace("goals=" if tag == "ComputePathToPose" else "goal=", "_description=")
    plan = f'<{tag} {attributes} path="{{path}}" error_code_id="{{code}}" error_msg="{{why}}"/>'
    helps = '<WouldAPlannerRecoveryHelp error_code="{code}"/>'
    made = grow(f"<Fallback>{plan}{helps}</Fallback>", path=[Pose2(0.0, 0.0)], **board)
    outcome = made.tick()
    assert list(made.board["path"]) == []
    return outcome, made, made.root.children[1].feedback_message


@pytest.mark.parametrize("tag", PLANNERS)
@pytest.mark.parametrize(
    ("scene", "goal"),
    [
        *itertools.product(PLACES, ["goal", GOAL]),
        *((scene, GOAL._replace(yaw=math.nan)) for scene in PLACES if "touches" not in scene),
    ],
)
def test_a_path_that_is_blocked_has_the_code_of_its_cause(mind, grow, tag, scene, goal):
    ((x, y), half), code, why = PLACES[scene]
    grid = mind.mission.knowledge.world.occupancy = OccupancyGrid(0.05, 30.0)
    grid.add_scan(np.array(box(x, y, half)), np.empty((0, 2), dtype=np.intp))
    outcome, made, told = planned(grow, tag, 'goal="{aim}" goals="{aims}"', aim=goal, aims=[goal])
    assert made.board["code"] == PLANNERS[tag] + code
    assert why in made.board["why"]
    assert outcome is (SUCCESS if code == 8 else FAILURE)
    assert code == 8 or (str(made.board["code"]) in told and why in told)


@pytest.mark.parametrize("tag", PLANNERS)
@pytest.mark.parametrize("case", OTHERS)
def test_other_failures_of_planners_have_their_codes(mind, grow, tag, case):
    attributes, code, outcome = OTHERS[case]
    if case == "lost":
        mind.mission.knowledge.robot.pose = lambda *_: Pose2(math.nan, math.nan, math.nan)
    found, made, told = planned(
        grow, tag, attributes, bad=Pose2(math.nan, 0.0), bads=[Pose2(math.nan, 0.0)], none="none"
    )
    assert (found, made.board["code"]) == (outcome, PLANNERS[tag] + code)
    assert outcome is SUCCESS or made.board["why"] in told


def test_goals_of_a_mission_have_their_states_from_the_start(grow):
    remove = (
        '<RemovePassedGoals input_goals="{goals}" output_goals="{goals}" radius="0.7" '
        'input_waypoint_statuses="{waypoint_statuses}" output_waypoint_statuses="{waypoint_statuses}"/>'
    )
    assert "waypoint_statuses" not in grow(remove.replace("{goals}", "{others}"), others="goal").board
    made = grow(remove, goals="0;map;0.5;0;0;0;0;0;1;0;map;4;0;0;0;0;0;1")
    states = [(0, 0), (1, 0)]
    assert [(s.waypoint_index, s.waypoint_status) for s in made.board["waypoint_statuses"]] == states
    assert made.tick() is SUCCESS
    assert [(s.waypoint_index, s.waypoint_status) for s in made.board["waypoint_statuses"]] == [(0, 1), (1, 0)]


MOTION = {  # code of each reason of the robot's action; all others are the first code, which means unknown
    "FollowPath": (100, {"LOST_POSE": 2, "CANNOT": 3, "STUCK": 5, "BLOCKED": 6, "TIMEOUT": 7}),
    "Spin": (700, {"TIMEOUT": 1, "LOST_POSE": 2, "BLOCKED": 3, "STUCK": 3}),
    "BackUp": (710, {"TIMEOUT": 1, "LOST_POSE": 2, "CANNOT": 3, "BLOCKED": 4, "STUCK": 4}),
    "DriveOnHeading": (720, {"TIMEOUT": 1, "LOST_POSE": 2, "BLOCKED": 3, "STUCK": 3, "CANNOT": 4}),
}


@pytest.mark.parametrize("reason", [r for r in Reason if r is not Reason.RAISED], ids=lambda r: r.name)
@pytest.mark.parametrize("tag", MOTION)
def test_a_failure_of_the_robots_action_is_a_code(mind, grow, tag, reason):
    action = mind.rig.actions[NAV2[tag].action]

    class Fails(action):
        def act(self, body):
            return Failure(reason, "on purpose")

        def decompose(self, body):
            raise ActionFailed(reason, "on purpose")

    mind.mission.actions = {**mind.rig.actions, NAV2[tag].action: Fails}
    path = {"path": [Pose2(0.0, 0.0), Pose2(1.0, 0.0)]} if tag == "FollowPath" else {}
    mind.start(grow(f'<{tag} error_code_id="{{code}}" error_msg="{{why}}"/>', **path).root)
    mind.until_done()
    base, codes = MOTION[tag]
    assert mind.plan.status == "FAILURE"
    assert mind.mission.board["code"] == base + codes.get(reason.name, 0)
    assert mind.mission.board["why"] == f"{reason.name}: on purpose"


def test_the_table_has_every_node_that_moves_the_robot():
    assert {node.tag for node in NAV2.values() if issubclass(node, _Move)} == set(MOTION)


WITHOUT = {  # outcome, code, part of the reason
    "NavigateToPose": ("FAILURE", 9001, "no navigator"),
    "NavigateThroughPoses": ("FAILURE", 9101, "no navigator"),
    "DockRobot": ("FAILURE", 999, "no docking server"),
    "UndockRobot": ("FAILURE", 999, "no docking server"),
    "FollowObject": ("FAILURE", 902, "no topic with its pose"),
    "IsBatteryCharging": ("FAILURE", None, "not known here"),
    "ReinitializeGlobalLocalization": ("SUCCESS", None, "not started again"),
    "ToggleCollisionMonitor": ("SUCCESS", None, "reflexes stay on"),
}


@pytest.mark.parametrize("tag", WITHOUT)
def test_a_node_that_needs_ros_returns_what_its_doc_says(grow, tag):
    outcome, code, why = WITHOUT[tag]
    served = issubclass(NAV2[tag], Served)
    ports = 'error_code_id="{code}" error_msg="{why}"' if served else ""
    made = grow(f"<{tag} {ports}/>")
    assert outcome_name(made.tick()) == outcome
    doc = summary_of(NAV2[tag])
    said = made.root.feedback_message
    assert why in said
    assert doc == f"{outcome}{f' with the code {code}' if code else ''}: {said}."
    assert not served or (made.board["code"], made.board["why"]) == (code, said)


OFFLINE = {"Selector": SUCCESS, "GoalUpdater": SUCCESS, "PauseResumeController": SUCCESS}
"""Nodes of a running Nav2 that do without a connection what they do in the simulator."""


@pytest.mark.parametrize("tag", sorted(node.tag for node in NAV2_SERVERS))
def test_a_node_of_a_running_nav2_fails_without_a_connection_and_says_so(mind, grow, tag):
    node = next(n for n in NAV2_SERVERS if n.tag == tag)
    default = next((f'{n}="a"' for n in node.ports if n.startswith("default_")), "")
    service = 'service_name="a"' if "service_name" in node.ports and not tag.startswith("Cancel") else ""
    child = "<AlwaysSuccess/>" if node.min_children else ""
    made = grow(f"<{tag} {default} {service}>{child}</{tag}>", "nav2_servers")
    outcome = next((o for part, o in OFFLINE.items() if tag.endswith(part)), FAILURE)
    assert made.tick() is outcome
    assert outcome is SUCCESS or "rocs-bt drive" in made.root.feedback_message


def test_a_route_that_is_tracked_tells_where_the_robot_is_expected(mind, grow):
    world = mind.mission.knowledge.world
    for name, x in (("a", 0.0), ("b", 3.0)):
        world.place(name, Pose2(x, 0.0, 0.0))
    mind.mission.knowledge.graph.relate("a", "connects", "b")
    made = grow('<ComputeAndTrackRoute start_id="a" goal_id="b"/>')
    assert made.tick() is RUNNING
    assert made.root.wait_text() == "until the robot is within 0.5 m of 'b', 3.0 m away"
