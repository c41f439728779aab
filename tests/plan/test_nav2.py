"""Nav2's nodes: how often decorators tick, when conditions hold, and what the actions do on a robot."""

# ruff: noqa: E501 - a document stands in one line

import math
from itertools import pairwise

import pytest

from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.nav2.motion import PATH_END, TrackingFeedback, track
from rocs_bt.nav2.nodes import NAV2
from rocs_bt.nav2.path import length
from rocs_bt.trees.nodes import Instant, Tree
from rocs_bt.trees.status import FAILURE, SUCCESS, outcome_name
from rocs_bt.trees.xml import load_xml


class Tally(Instant):
    """Counts its ticks in the key `n`."""

    outcome: str = "SUCCESS"

    def update(self):
        self.board["n"] = self.board["n"] + 1
        return SUCCESS if self.outcome == "SUCCESS" else FAILURE


@pytest.fixture
def tree(mind):
    """Makes a tree on the test robot, which ticks it each 0.1 s and returns the counts of Tally."""
    mind.mission.content = Catalog()
    mind.mission.knowledge.world.place("goal", Pose2(2.0, 0.0, 0.0), "goal")

    def make(inside):
        text = f'<root BTCPP_format="4"><BehaviorTree ID="Main">{inside}</BehaviorTree></root>'
        made = Tree(load_xml(text, NAV2.with_([Tally])), clock=mind.rig.clock, owner=mind.mission)
        made.board.update({"goal": "goal", "n": 0})
        return made

    return make


def ticks(mind, made, count):
    """Counts of Tally after each tick; two periods of the test robot are 0.1 s."""
    found = []
    for _ in range(count):
        made.tick()
        found.append(made.board["n"])
        mind.rig.run(2)
    return found


LASTING = "<KeepRunningUntilFailure><AlwaysSuccess/></KeepRunningUntilFailure>"


class TestDecorators:
    @pytest.mark.parametrize(
        ("around", "counts"),
        [
            # ticked again after it ended: throttled
            ("<PipelineSequence>{}" + LASTING + "</PipelineSequence>", [1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 3]),
            (
                "<ReactiveSequence>{}" + LASTING + "</ReactiveSequence>",
                [1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 3],
            ),
            # reset by the parent after it ended: each run begins anew
            ("<KeepRunningUntilFailure><Sequence>{}</Sequence></KeepRunningUntilFailure>", [*range(1, 12)]),
            ("<KeepRunningUntilFailure>{}</KeepRunningUntilFailure>", [*range(1, 12)]),
        ],
        ids=["pipeline", "reactive", "sequence", "decorator"],
    )
    def test_a_rate_controller_throttles_where_its_parent_does_not_reset_it(self, mind, tree, around, counts):
        found = ticks(mind, tree(around.format('<RateController hz="2"><Tally/></RateController>')), 11)
        assert found == counts

    @pytest.mark.parametrize(
        "tag", ["RateController hz='{zero}'", "SpeedController min_rate='{zero}' max_rate='{zero}'"]
    )
    def test_a_rate_of_zero_on_the_board_never_ticks_the_child_again(self, mind, tree, tag):
        made = tree(f"<PipelineSequence><{tag}><Tally/></{tag.split()[0]}>{LASTING}</PipelineSequence>")
        made.board["zero"] = 0.0
        assert ticks(mind, made, 12) == [1] * 12

    @pytest.mark.parametrize("tag", ["GoalUpdatedController", "SpeedController min_rate='0.01' max_rate='0.01'"])
    def test_a_goal_that_moves_makes_the_child_due(self, mind, tree, tag):
        made = tree(f"<PipelineSequence><{tag}><Tally/></{tag.split()[0]}>{LASTING}</PipelineSequence>")
        assert ticks(mind, made, 3) == [1, 1, 1]
        mind.mission.knowledge.world.place("goal", Pose2(3.0, 0.0, 0.0), "goal")
        assert ticks(mind, made, 3) == [2, 2, 2]

    def test_a_single_trigger_ticks_its_child_once_in_a_run(self, mind, tree):
        inside = (
            f"<ReactiveFallback><SingleTrigger><Tally outcome='FAILURE'/></SingleTrigger>{LASTING}</ReactiveFallback>"
        )
        assert ticks(mind, tree(inside), 4) == [1, 1, 1, 1]

    def test_a_distance_controller_waits_until_the_robot_has_moved(self, mind, tree):
        made = tree(
            f"<PipelineSequence><DistanceController distance='0.2'><Tally/></DistanceController>{LASTING}</PipelineSequence>"
        )
        assert ticks(mind, made, 3) == [1, 1, 1]
        pose, away = mind.mission.knowledge.robot.pose, 0.19
        mind.mission.knowledge.robot.pose = lambda *t: pose(*t)._replace(x=away)
        assert ticks(mind, made, 2) == [1, 1]
        away = 0.21
        assert ticks(mind, made, 3) == [2, 2, 2]
        away = 0.42
        assert ticks(mind, made, 2) == [3, 3]

    def test_a_path_that_becomes_much_longer_close_to_the_goal_ticks_the_child(self, mind, tree):
        made = tree(
            "<PipelineSequence><PathLongerOnApproach><Tally/></PathLongerOnApproach>" + LASTING + "</PipelineSequence>"
        )
        found = []
        for path in (
            [(0.0, 0.0), (1.0, 0.0)],  # the first
            [(0.0, 0.0), (0.0, 0.4), (1.0, 0.0)],  # not twice as long
            [(0.0, 0.0), (0.0, 1.0), (0.0, 2.0), (1.0, 0.0)],  # more than twice as long
            [(0.0, 0.0), (0.0, 9.0), (1.0, 0.0)],  # the old one is not close
            [(0.0, 0.0), (2.0, 0.0)],
            [(0.0, 0.0), (0.0, 9.0), (3.0, 0.0)],  # another goal
        ):
            made.board["path"] = path
            found += ticks(mind, made, 2)
        assert found == [0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1]


class TestConditions:
    def outcomes(self, mind, made, count):
        found = []
        for _ in range(count):
            found.append(outcome_name(made.tick())[0])
            mind.rig.run(2)
        return "".join(found)

    @pytest.mark.parametrize(
        ("condition", "while_kept"),
        [
            ("<GoalUpdated/>", "R" * 6),
            ("<TimeExpired seconds='0.3'/>", "RRRSRR"),
            ("<DistanceTraveled distance='1'/>", "R" * 6),
        ],
    )
    def test_those_that_compare_with_the_beginning(self, mind, tree, condition, while_kept):
        inside = f"<ReactiveFallback>{condition}{LASTING}</ReactiveFallback>"
        assert self.outcomes(mind, tree(inside), 6) == while_kept

    def test_the_condition_of_while_do_else_keeps_its_state_while_a_branch_runs(self, mind, tree):
        inside = f"<WhileDoElse><TimeExpired seconds='0.3'/><AlwaysSuccess/>{LASTING}</WhileDoElse>"
        assert self.outcomes(mind, tree(inside), 8) == "RRRSRRRS"

    def test_a_robot_is_stopped_after_a_time_without_speed(self, mind, tree):
        made = tree(f"<ReactiveFallback><IsStopped duration_stopped='300'/>{LASTING}</ReactiveFallback>")
        assert self.outcomes(mind, made, 5) == "RRRRS"
        speed = mind.mission.knowledge.robot.speed
        mind.mission.knowledge.robot.speed = lambda *_: -0.2
        assert self.outcomes(mind, made, 4) == "RRRR"
        mind.mission.knowledge.robot.speed = speed
        assert self.outcomes(mind, made, 5) == "RRRRS"

    def test_a_path_expires_unless_it_is_a_new_one(self, mind, tree):
        made = tree(f"<ReactiveFallback><PathExpiringTimer seconds='0.3'/>{LASTING}</ReactiveFallback>")
        made.board["path"] = [(0.0, 0.0), (1.0, 0.0)]
        assert self.outcomes(mind, made, 3) == "RRR"
        made.board["path"] = [(0.0, 0.0), (1.0, 0.0)]
        assert self.outcomes(mind, made, 5) == "RRRSR"

    def test_goal_updated_holds_once_for_each_change(self, mind, tree):
        made = tree(f"<ReactiveFallback><GoalUpdated/>{LASTING}</ReactiveFallback>")
        assert self.outcomes(mind, made, 2) == "RR"
        mind.mission.knowledge.world.place("goal", Pose2(3.0, 0.0, 0.0), "goal")
        assert self.outcomes(mind, made, 1) == "S"

    def test_global_updated_goal_is_never_reset(self, mind, tree):
        made = tree("<GlobalUpdatedGoal/>")
        assert self.outcomes(mind, made, 3) == "SFF"

    @pytest.mark.parametrize(
        ("condition", "outcome"),
        [
            ("<GoalReached goal='{goal}'/>", "F"),
            ("<GoalReached goal='0;map;0;0;0;0;0;0;1'/>", "S"),
            ("<ArePosesNear target_pose='goal' tolerance='2.5'/>", "S"),
            ("<ArePosesNear target_pose='goal' tolerance='1.5'/>", "F"),
            ("<InitialPoseReceived/>", "S"),
            ("<TransformAvailable parent='map' child='base_link'/>", "S"),
            ("<WouldAPlannerRecoveryHelp error_code='208'/>", "S"),
            ("<WouldAPlannerRecoveryHelp error_code='201'/>", "F"),
            ("<WouldAControllerRecoveryHelp error_code='105'/>", "S"),
            ("<AreErrorCodesPresent error_code='3' error_codes_to_check='1,3'/>", "S"),
            ("<AreErrorCodesPresent error_code='2' error_codes_to_check='1;3'/>", "F"),
            ("<WouldAPlannerRecoveryHelp error_code='308'/>", "S"),
            ("<WouldAPlannerRecoveryHelp error_code='{none}'/>", "F"),
            ("<WouldAControllerRecoveryHelp error_code='{none}'/>", "F"),
            ("<WouldAControllerRecoveryHelp/>", "F"),
            ("<AreErrorCodesPresent error_code='{none}' error_codes_to_check='0;1'/>", "F"),
        ],
    )
    def test_those_that_look_at_now(self, mind, tree, condition, outcome):
        assert self.outcomes(mind, tree(condition), 1) == outcome

    @pytest.mark.parametrize(
        ("errors", "outcome"),
        [
            (None, "S"),
            ((0.4, 0.0), "S"),
            ((0.6, 0.0), "F"),
            ((-0.2, 0.0), "F"),
            ((-0.05, -0.3), "S"),
            ((0.0, 0.9), "F"),
        ],
    )
    def test_a_path_has_bounds_on_each_side_as_soon_as_it_is_tracked(self, mind, tree, errors, outcome):
        bounds = "max_error_left='0.5' max_error_right='0.1' max_error_heading='0.8'"
        made = tree(f"<IsWithinPathTrackingBounds {bounds} tracking_feedback='{{tracking}}'/>")
        if errors is not None:
            names = ("position_tracking_error", "heading_tracking_error")
            made.board["tracking"] = dict(zip(names, errors, strict=True))
        assert self.outcomes(mind, made, 1) == outcome


class TestPaths:
    def test_a_path_through_several_goals(self, mind, tree):
        mind.mission.knowledge.world.place("corner", Pose2(1.0, 1.0, 0.0))
        made = tree("<ComputePathThroughPoses goals='corner;goal' path='{path}'/>")
        assert made.tick() is SUCCESS
        path = made.board["path"]
        assert max(a.distance(b) for a, b in pairwise(path)) <= 0.05
        assert length(path) == pytest.approx(2.0 * math.sqrt(2.0))
        assert min(path, key=lambda p: abs(p.x - 1.0)) == pytest.approx((1.0, 1.0, -math.pi / 4))
        assert (path[0][:2], path[-1]) == (pytest.approx((0.0, 0.0), abs=1e-6), (2.0, 0.0, 0.0))

    @pytest.mark.parametrize(
        ("node", "output", "wanted"),
        [
            (
                "<TruncatePath input_path='{way}' output_path='{out}' distance='0.5'/>",
                "out",
                [(0, 0, 0), (2, 0, math.pi / 2)],
            ),
            (
                "<TruncatePath input_path='{way}' output_path='{out}' distance='9'/>",
                "out",
                [(0, 0, 0), (2, 0, math.pi / 2)],
            ),
            (
                "<ConcatenatePaths input_path1='{way}' input_path2='{more}' output_path='{out}'/>",
                "out",
                [(0, 0, 0), (2, 0, math.pi / 2), (2, 1, math.pi / 2), (2, 1, 0), (3, 1, 0)],
            ),
            ("<GetPoseFromPath path='{way}' index='-1' pose='{out}'/>", "out", (2, 1, math.pi / 2)),
            ("<PlannerSelector default_planner='x' selected_planner='{out}'/>", "out", "x"),
            ("<GoalCheckerSelector default_goal_checker='x' selected_goal_checker='{out}'/>", "out", "x"),
            ("<RemovePassedGoals input_goals='here;goal' output_goals='{out}' radius='0.5'/>", "out", ["goal"]),
        ],
    )
    def test_paths_are_edited(self, mind, tree, node, output, wanted):
        mind.mission.knowledge.world.place("here", Pose2(0.1, 0.0, 0.0))
        made = tree(node)
        made.board.update({"way": [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0)], "more": [(2.0, 1.0), (3.0, 1.0)]})
        assert made.tick() is SUCCESS
        found = made.board[output]
        assert (
            found == wanted
            if isinstance(wanted, str) or wanted == ["goal"]
            else found == pytest.approx(wanted)
            if isinstance(wanted, tuple)
            else [tuple(p) for p in found] == [pytest.approx(p) for p in wanted]
        )


class TestRoutes:
    @pytest.fixture
    def roads(self, mind):
        """A detour of two roads and a shorter one that costs three times its length, from the robot to `goal`."""
        world, graph = mind.mission.knowledge.world, mind.mission.knowledge.graph
        for name, (x, y) in {"dock": (0.0, 0.0), "bend": (1.0, 1.0), "goal": (2.0, 0.0)}.items():
            world.place(name, Pose2(x, y, 0.0), "goal" if name == "goal" else "place")
        for a, b, cost in (("dock", "bend", 1.0), ("bend", "goal", 1.0), ("dock", "goal", 3.0)):
            graph.relate(a, "connects", b, cost=cost)
        return graph

    COMPUTE = (
        "<ComputeRoute {} path='{{path}}' route='{{route}}' planning_time='{{time}}' error_code_id='{{code}}'"
        " error_msg='{{why}}'/>"
    )

    @pytest.mark.usefixtures("roads")
    @pytest.mark.parametrize(
        ("attributes", "nodes"),
        [
            ("goal_id='goal'", ("dock", "bend", "goal")),
            ("use_poses='true'", ("dock", "bend", "goal")),
            ("goal_id='goal' planner_id='astar'", ("dock", "bend", "goal")),
            ("goal_id='goal' start_id='bend'", ("bend", "goal")),
            ("use_poses='true' use_start='true' start='0;map;1;1;0;0;0;0;1'", ("bend", "goal")),
            ("use_poses='true' start='0;map;1;1;0;0;0;0;1'", ("dock", "bend", "goal")),
        ],
    )
    def test_a_route_has_its_places_its_roads_and_its_cost(self, tree, attributes, nodes):
        made = tree(self.COMPUTE.format(attributes))
        assert made.tick() is SUCCESS
        route = made.board["route"]
        assert route.nodes == nodes
        assert route.edges == tuple(pairwise(nodes))
        assert route.route_cost == pytest.approx((len(nodes) - 1) * math.sqrt(2.0))
        assert made.board["path"][-1][:2] == (2.0, 0.0)
        assert (made.board["time"], made.board["code"], made.board["why"]) == (0.0, 0, "")

    def test_no_roads_and_closed_roads_are_two_error_codes(self, mind, tree, roads):
        made = tree(self.COMPUTE.format("goal_id='goal'"))
        for a, b in (("dock", "goal"), ("bend", "goal")):
            roads.relate(a, "connects", b, open=False)
        assert (made.tick(), made.board["code"]) == (FAILURE, 405)
        assert "bend-goal (closed)" in made.board["why"]
        for a, b in (("dock", "bend"), ("dock", "goal"), ("bend", "goal")):
            roads.unrelate(a, "connects", b)
        assert (made.tick(), made.board["code"]) == (FAILURE, 402)

    @pytest.mark.usefixtures("roads")
    def test_the_robot_drives_along_the_route(self, mind, tree):
        drive = "<FollowPath path='{path}' tracking_feedback='{tracking}'/>"
        root = tree(f"<Sequence>{self.COMPUTE.format('goal_id=' + repr('goal'))}{drive}</Sequence>").root
        mind.start(root)
        feedback = []
        while mind.plan.status == "RUNNING":
            mind.run()
            if "tracking" in mind.mission.board:
                feedback.append(mind.mission.board["tracking"])
        assert mind.plan.status == "SUCCESS"
        assert feedback.pop() == TrackingFeedback(feedback[-1].robot_pose, *[0] * 6)
        assert [f.current_path_index for f in feedback] == sorted(f.current_path_index for f in feedback)
        left = [f.remaining_path_length for f in feedback]
        assert left == sorted(left, reverse=True)
        assert left[0] == pytest.approx(2.0 * math.sqrt(2.0), abs=0.1)
        assert feedback[-1].distance_to_goal < 0.15
        assert max(abs(f.position_tracking_error) for f in feedback) < 0.15
        assert max(f.speed for f in feedback) == pytest.approx(0.5, abs=0.1)


@pytest.mark.parametrize(
    ("pose", "wanted"),
    [
        ((0.5, 0.2, 0.1), (0.2, 0.1, 0, 3.5, math.hypot(1.5, 1.8))),
        ((0.5, -0.2, 0.0), (-0.2, 0.0, 0, 3.5, math.hypot(1.5, 2.2))),
        ((2.3, 1.0, math.pi / 2), (-0.3, 0.0, 1, 1.0, math.hypot(0.3, 1.0))),
        ((2.0, 2.5, 0.0), (0.5, -math.pi / 2, 1, 0.0, 0.5)),
    ],
)
def test_tracking_of_a_path(pose, wanted):
    found = track([(0.0, 0.0), (2.0, 0.0), (2.0, 2.0)], Pose2(*pose), 0.4)
    assert (
        abs(found.position_tracking_error) if pose[1] == 2.5 else found.position_tracking_error,
        found.heading_tracking_error,
        found.current_path_index,
        found.remaining_path_length,
        found.distance_to_goal,
    ) == pytest.approx(wanted)
    assert found.robot_pose == pose
    assert found.speed == 0.4
    assert track([(1.0, 1.0)], Pose2(1.0, 0.0, 0.0), 0.0).distance_to_goal == 1.0
    aslant = track([(0.0, 1.0), (1.0, 2.0)], Pose2(0.6, 1.4, 0.0), 0.4)
    assert (aslant.position_tracking_error, aslant.remaining_path_length) == pytest.approx((-(0.02**0.5), 0.5**0.5))


class TestMotion:
    @pytest.mark.parametrize(("end", "goal"), [((2.0, 0.0), "goal"), ((2.0, 1.0), PATH_END), ((1.0, 0.0), PATH_END)])
    def test_the_end_of_a_path_is_the_place_that_lies_there(self, mind, tree, end, goal):
        root = tree("<FollowPath path='{path}'/>").root
        mind.mission.board["path"] = [(0.0, 0.0), end]
        mind.start(root)
        mind.run(2)
        assert root.ticket.action.parameters["goal"] == goal
        assert mind.mission.knowledge.world.pose_of(goal)[:2] == end

    def test_a_new_path_to_the_same_end_is_driven_by_the_same_action_and_another_end_by_another(self, mind, tree):
        root = tree("<FollowPath path='{path}'/>").root
        board, ways = mind.mission.board, [[(0.0, 0.0), *more] for more in ([(2, 0)], [(1, 0.2), (2, 0)], [(0, 2)])]
        board["path"] = ways[0]
        mind.start(root)
        mind.run(2)
        first = root.ticket
        board["path"] = ways[1]
        mind.run(2)
        assert root.ticket is first
        assert list(first.action.points) == ways[1]
        board["path"] = ways[2]
        mind.run(2)
        assert first.cancelled_by == "FollowPath"
        assert (root.ticket.state.done, list(root.ticket.action.points)) == (False, ways[2])

    @pytest.mark.parametrize("far", ["9e9", "1e300"])
    def test_a_path_that_is_too_long_is_an_error_code(self, mind, tree, far):
        path = f"<ComputePathToPose goal='0;map;{far};0;0;0;0;0;1' path='{{path}}'/>"
        drive = "<FollowPath path='{path}' error_code_id='{code}' error_msg='{why}'/>"
        root = tree(f"<Sequence>{path}{drive}</Sequence>").root
        mind.start(root)
        mind.until_done()
        assert (mind.plan.status, mind.mission.board["code"]) == ("FAILURE", 103)
        assert "a path may be 10000 m long, found " in mind.mission.board["why"]

    @pytest.mark.parametrize(
        ("node", "moved"),
        [
            ("<Spin spin_dist='1.57'/>", (0.0, 0.0, 1.57)),
            ("<BackUp backup_dist='0.2' backup_speed='0.2'/>", (-0.2, 0.0, 0.0)),
            ("<BackUp backup_dist='-0.2' backup_speed='0.2'/>", (-0.2, 0.0, 0.0)),
            ("<DriveOnHeading dist_to_travel='0.3' speed='0.2'/>", (0.3, 0.0, 0.0)),
            ("<Sequence><ComputePathToPose path='{path}'/><FollowPath path='{path}'/></Sequence>", (2.0, 0.0, 0.0)),
            ("<Wait wait_duration='0.5'/>", (0.0, 0.0, 0.0)),
        ],
    )
    def test_the_robot_moves_as_asked(self, mind, tree, node, moved):
        root = tree(node).root
        mind.mission.board.update({"goal": "goal"})
        mind.rig.heard |= {"room_ahead": (3.0,) * 5, "room_behind": (3.0,) * 5}  # BackUp needs known ground
        mind.rig.sense()
        mind.start(root)
        mind.until_done()
        assert mind.plan.status == "SUCCESS"
        pose = mind.mission.knowledge.robot.pose(mind.rig.clock.now())
        assert tuple(pose) == pytest.approx(moved, abs=0.12)

    def test_too_little_time_is_an_error_code(self, mind, tree):
        root = tree("<Spin spin_dist='3.0' time_allowance='0.5' error_code_id='{code}'/>").root
        mind.start(root)
        mind.until_done()
        assert (mind.plan.status, mind.mission.board["code"]) == ("FAILURE", 701)
