"""GoTo and FollowPath, on a robot whose wheels do exactly what they are told."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.actions import (
    Flinch,
    FollowPath,
    GoTo,
    SetWheelSpeed,
)
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import ActuatorCommanded, FollowerStepped
from rocs_bt.interfaces.action import Reason
from rocs_bt.interfaces.pipeline import Priority, TicketState

SUCCEEDED, FAILED = TicketState.SUCCEEDED, TicketState.FAILED


class TestGoTo:
    @settings(max_examples=12, deadline=None)
    @given(x=st.floats(-2.0, 2.0), y=st.floats(-2.0, 2.0), degrees=st.floats(-180.0, 180.0))
    def test_arrives_and_stands_there(self, make_rig, x, y, degrees):
        rig = make_rig()
        rig.put(x, y, degrees)
        rig.knowledge.world.place("dock", Pose2(0.5, -0.3), kind="goal")
        ticket = rig.submit(GoTo(goal="dock"))
        rig.finish(ticket)
        assert ticket.state is SUCCEEDED
        assert rig.pose.distance(Pose2(0.5, -0.3)) <= 0.055
        slow = 0.05 + 1.5 * rig.body.period  # the last command counts from wheels that stand
        assert max(map(abs, rig.of(ActuatorCommanded)[-2].values)) <= slow if rig.of(FollowerStepped) else True

    def test_stands_when_it_succeeds(self, rig):
        rig.knowledge.world.place("goal", Pose2(1.0, 0.0), kind="goal")
        rig.finish(rig.submit(GoTo(goal="goal", tolerance=0.3)))
        assert math.hypot(rig.path[-1].x - rig.path[-2].x, rig.path[-1].y - rig.path[-2].y) <= 0.06 * rig.body.period
        assert rig.pose.x > 0.9

    def test_commands_once_a_period_within_the_wheels_limits_and_tells_how_it_follows(self, rig):
        rig.put(-1.0, 2.0, -63.0)
        rig.knowledge.world.place("goal", Pose2(0.0, 0.0), kind="goal")
        periods = rig.finish(rig.submit(GoTo(goal="goal", cruise=0.5)))
        commands = np.array([[0.0, 0.0]] + [e.values for e in rig.of(ActuatorCommanded)])
        assert len(commands) - 1 == periods
        assert len({e.t for e in rig.of(ActuatorCommanded)}) == periods
        assert np.abs(np.diff(commands[:-1], axis=0)).max() <= 1.5 * 0.05 + 1e-9
        assert np.abs(commands).max() <= 1.2 + 1e-9
        assert len(rig.of(FollowerStepped)) == periods - 1
        assert max(abs(e.cross_track) for e in rig.of(FollowerStepped)) < 0.05
        assert {e.rung for e in rig.of(FollowerStepped)} == {"solved"}
        assert periods * 0.05 < 7.0

    def test_turns_on_the_spot_first_when_it_looks_away(self, rig):
        rig.put(0.0, 0.0, 180.0)
        rig.knowledge.world.place("goal", Pose2(1.0, 0.0), kind="goal")
        rig.finish(rig.submit(GoTo(goal="goal")))
        assert min(p.x for p in rig.path) > -0.01

    def test_the_goal_is_pursued_while_it_drives_and_not_after(self, rig):
        world = rig.knowledge.world
        world.place("goal", Pose2(1.0, 0.0), kind="goal")
        ticket = rig.submit(GoTo(goal="goal"))
        rig.run()
        assert world.pursued() == "goal"
        rig.finish(ticket)
        assert world.pursued() is None

    def test_a_reflex_does_not_end_the_pursuit(self, rig):
        rig.knowledge.world.place("goal", Pose2(1.0, 0.0), kind="goal")
        rig.submit(GoTo(goal="goal"))
        rig.run()
        rig.submit(Flinch(speed=-0.2), Priority.HIGH)
        rig.run()
        assert rig.knowledge.world.pursued() == "goal"

    def test_takes_the_wheels_over_from_a_reflex_within_their_limits(self, rig):
        rig.knowledge.world.place("goal", Pose2(3.0, 0.0), kind="goal")
        rig.submit(SetWheelSpeed(speeds=[-0.4, -0.4], duration=0.5), Priority.HIGH)
        rig.submit(GoTo(goal="goal"))
        rig.run(11)
        assert rig.wheels.speeds == pytest.approx([-0.4 + 1.5 * 0.05] * 2, abs=1e-6)

    def test_follows_a_goal_that_moves(self, rig):
        world = rig.knowledge.world
        world.place("goal", Pose2(1.0, 0.0), kind="goal")
        ticket = rig.submit(GoTo(goal="goal"))
        rig.run(30)
        world.place("goal", Pose2(1.0, 1.0), kind="goal")
        rig.finish(ticket)
        assert rig.pose.distance(Pose2(1.0, 1.0)) <= 0.055
        assert min(p.distance(Pose2(1.0, 0.0)) for p in rig.path) > 0.2

    def test_finds_its_way_after_it_was_carried_off(self, rig):
        rig.knowledge.world.place("goal", Pose2(2.0, 0.0), kind="goal")
        ticket = rig.submit(GoTo(goal="goal"))
        rig.run(20)
        rig.put(0.5, 1.5, 90.0)
        rig.finish(ticket)
        assert ticket.state is SUCCEEDED
        assert rig.pose.distance(Pose2(2.0, 0.0)) <= 0.055
        assert max(abs(p.x - 0.5 - (1.5 - p.y)) for p in rig.path[21:]) < 0.3  # straight from there

    def test_an_unknown_goal_says_which_there_are(self, rig):
        rig.knowledge.world.place("dock", Pose2(1.0, 0.0), kind="goal")
        ticket = rig.submit(GoTo(goal="dok"))
        rig.run()
        assert ticket.failure.reason is Reason.NO_GOAL
        assert "'dok'" in ticket.failure.evidence
        assert "Did you mean 'dock'" in ticket.failure.evidence

    def test_a_goal_that_vanishes_ends_it(self, rig):
        rig.knowledge.world.place("goal", Pose2(1.0, 0.0), kind="goal")
        ticket = rig.submit(GoTo(goal="goal"))
        rig.run(10)
        rig.knowledge.graph.remove("goal")
        rig.run(2)
        assert ticket.failure.reason is Reason.NO_GOAL
        assert rig.wheels.speeds == [0.0, 0.0]

    def test_brakes_when_the_pose_is_lost_and_then_fails(self, rig):
        rig.knowledge.world.place("goal", Pose2(3.0, 0.0), kind="goal")
        ticket = rig.submit(GoTo(goal="goal"))
        rig.run(20)
        rig.lost = True
        rig.run(6)
        assert rig.wheels.speeds == [0.0, 0.0]
        assert not ticket.state.done
        rig.finish(ticket, limit=10)
        assert ticket.failure.reason is Reason.LOST_POSE
        assert rig.knowledge.world.pursued() is None

    def test_goes_on_when_the_pose_is_back_in_time(self, rig):
        rig.knowledge.world.place("goal", Pose2(3.0, 0.0), kind="goal")
        ticket = rig.submit(GoTo(goal="goal"))
        rig.run(20)
        rig.lost = True
        rig.run(6)
        rig.lost = False
        rig.sense()
        rig.finish(ticket)
        assert ticket.state is SUCCEEDED

    def test_goes_to_a_place_that_is_no_goal_without_pursuing_it(self, rig):
        rig.knowledge.world.place("corner", Pose2(0.5, 0.0))
        ticket = rig.submit(GoTo(goal="corner"))
        rig.run()
        assert rig.knowledge.world.pursued() is None
        rig.finish(ticket)
        assert ticket.state is SUCCEEDED

    @pytest.mark.parametrize("period", [0.02, 0.05])
    def test_works_at_both_rates(self, make_rig, period):
        rig = make_rig(period)
        rig.put(-1.0, 2.0, -63.0)
        rig.knowledge.world.place("goal", Pose2(0.0, 0.0), kind="goal")
        ticket = rig.submit(GoTo(goal="goal"))
        rig.finish(ticket)
        assert rig.pose.distance(Pose2(0.0, 0.0)) <= 0.055

    def test_says_how_far_it_is_from_done(self, rig):
        rig.knowledge.world.place("goal", Pose2(3.0, 4.0), kind="goal")
        assert GoTo(goal="goal").remaining(rig.knowledge) == pytest.approx(5.0)
        assert math.isnan(GoTo(goal="nowhere").remaining(rig.knowledge))


class TestFollowPath:
    CORNER = ((1.0, 0.0), (1.0, 1.0))

    def test_drives_along_to_the_end(self, rig):
        ticket = rig.submit(FollowPath(points=[(0.0, 0.0), *self.CORNER], corner_radius=0.3))
        rig.finish(ticket)
        assert ticket.state is SUCCEEDED
        assert rig.pose.distance(Pose2(1.0, 1.0)) <= 0.055
        assert max(abs(e.cross_track) for e in rig.of(FollowerStepped)) < 0.05

    def test_joins_from_aside(self, rig):
        rig.put(0.5, -0.8, 0.0)
        ticket = rig.submit(FollowPath(points=[(0.0, 0.0), *self.CORNER]))
        rig.finish(ticket)
        assert rig.pose.distance(Pose2(1.0, 1.0)) <= 0.055

    def test_sent_again_it_goes_on_where_it_was(self, rig):
        points = [(0.0, 0.0), (2.0, 0.0)]
        rig.submit(FollowPath(points=points))
        rig.run(60)
        reached = rig.pose.x
        rig.submit(Flinch(speed=-0.2), Priority.HIGH)
        rig.run(10)
        ticket = rig.submit(FollowPath(points=points))
        rig.finish(ticket)
        assert min(p.x for p in rig.path[60:]) > reached - 0.15
        assert rig.pose.distance(Pose2(2.0, 0.0)) <= 0.055

    def test_a_round_trip_is_driven_round(self, rig):
        square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)]
        rig.put(0.02, 0.05, 0.0)  # nearer to the last side than to the first
        ticket = rig.submit(FollowPath(points=square))
        rig.finish(ticket)
        assert max(p.x + p.y for p in rig.path) > 1.7
        assert rig.pose.distance(Pose2(0.0, 0.0)) <= 0.055

    def test_carried_off_near_the_end_it_does_not_begin_again(self, rig):
        square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)]
        ticket = rig.submit(FollowPath(points=square))
        while not (rig.pose.x < 0.1 and 0.3 < rig.pose.y < 0.5):
            rig.run()
        before = len(rig.path)
        rig.put(0.45, 0.1, -90.0)
        rig.finish(ticket)
        assert max(p.x for p in rig.path[before:]) < 0.6
        assert rig.pose.distance(Pose2(0.0, 0.0)) <= 0.055

    @pytest.mark.parametrize("points", [[], [(0.0, math.nan), (1.0, 0.0)]])
    def test_what_is_no_path_fails_with_the_reason(self, rig, points):
        ticket = rig.submit(FollowPath(points=points))
        rig.run()
        assert ticket.failure.reason is Reason.CANNOT
        assert "path" in ticket.failure.evidence or "point" in ticket.failure.evidence
