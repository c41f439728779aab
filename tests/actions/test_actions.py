"""The shipped actions, on a robot whose wheels do exactly what they are told."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.action import Action, AtomicAction, Progress, Reason, make_action, parameters_of
from rocs_bt.actions import (
    ACTIONS,
    AvoidCollision,
    Flinch,
    FollowPath,
    GoTo,
    GoToOrigin,
    SetWheelSpeed,
    Stop,
    TurnAngle,
    TurnTo,
    TurnToOrigin,
    TurnToPosition,
    action_table,
)
from rocs_bt.errors import InputError
from rocs_bt.event import ActuatorCommanded, AtomicStarted, Followed
from rocs_bt.geometry import Pose2, wrap_angle
from rocs_bt.pipeline import Priority, TicketState

SUCCEEDED, FAILED = TicketState.SUCCEEDED, TicketState.FAILED


def names(rig):
    return [e.action for e in rig.of(AtomicStarted)]


class TestSetWheelSpeed:
    @pytest.mark.parametrize(
        ("duration", "periods"), [(0.05, 1), (0.8, 16), (2.0, 40), (0.06, 1), (0.09, 2), (0.001, 1), (0.0, 0)]
    )
    def test_commands_for_whole_periods(self, rig, duration, periods):
        ticket = rig.submit(SetWheelSpeed(speeds=[0.2, 0.2], duration=duration))
        rig.run(50)
        assert ticket.state is SUCCEEDED
        assert [e.values for e in rig.of(ActuatorCommanded)].count([0.2, 0.2]) == periods
        assert rig.pose.x == pytest.approx(0.2 * 0.05 * periods)

    def test_a_stream_of_one_period_actions_gives_one_command_a_period(self, rig):
        tickets = [rig.submit(SetWheelSpeed(speeds=[v, v], duration=0.05)) for v in (0.1, 0.2, 0.3)]
        rig.run(4)
        assert [(e.t, e.values[0]) for e in rig.of(ActuatorCommanded)] == [
            (0.0, 0.1), (0.05, 0.2), (0.1, pytest.approx(0.3)), (pytest.approx(0.15), 0.0),
        ]  # fmt: skip
        assert {t.state for t in tickets} == {SUCCEEDED}

    def test_until_is_asked_before_each_command(self, rig):
        ticket = rig.submit(SetWheelSpeed(speeds=[0.5, 0.5], until=lambda body: rig.pose.x > 0.1))
        rig.finish(ticket)
        assert rig.pose.x == pytest.approx(0.125)

    def test_goes_on_without_an_end_and_takes_new_speeds_while_it_does(self, rig):
        action = SetWheelSpeed(speeds=[0.1, 0.1])
        ticket = rig.submit(action)
        rig.run(100)
        action.update(speeds=[-0.1, -0.1])
        rig.run()
        assert ticket.state is TicketState.RUNNING
        assert rig.wheels.speeds == [-0.1, -0.1]

    def test_is_slowed_to_what_the_wheels_can(self, rig):
        rig.submit(SetWheelSpeed(speeds=[2.4, 1.2]))
        rig.run()
        assert rig.wheels.speeds == pytest.approx([1.2, 0.6])

    def test_the_wrong_number_of_speeds_says_what_the_drive_takes(self, rig):
        ticket = rig.submit(SetWheelSpeed(speeds=[0.1]))
        rig.run()
        assert ticket.failure.reason is Reason.CANNOT
        assert "2 rim speeds (left, right), found [0.1]" in ticket.failure.evidence


class TestTurnAngle:
    @settings(max_examples=40, deadline=None)
    @given(degrees=st.floats(-720.0, 720.0), start=st.floats(-180.0, 180.0), rate=st.floats(0.2, 4.0))
    def test_ends_within_tolerance_the_way_that_the_sign_says(self, make_rig, degrees, start, rate):
        rig = make_rig()
        rig.put(1.0, 2.0, start)
        ticket = rig.submit(TurnAngle(angle=math.radians(degrees), rate=rate))
        turned = 0.0
        for _ in range(5000):
            before = rig.pose.yaw
            rig.run()
            turned += wrap_angle(rig.pose.yaw - before)
            if ticket.state.done:
                break
        assert ticket.state is SUCCEEDED
        assert turned == pytest.approx(math.radians(degrees), abs=0.0201)
        assert rig.pose[:2] == (1.0, 2.0)

    @settings(max_examples=20, deadline=None)
    @given(degrees=st.floats(-180.0, 180.0), rate=st.floats(0.2, 4.0))
    def test_keeps_rate_and_acceleration(self, make_rig, degrees, rate):
        rig = make_rig()
        rig.finish(rig.submit(TurnAngle(angle=math.radians(degrees), rate=rate)))
        wheels = np.array([[0.0, 0.0]] + [e.values for e in rig.of(ActuatorCommanded)])
        turns = wheels @ rig.body.drive.twist_from_q[2]
        assert np.abs(turns).max() <= rate + 1e-9
        last = -1 if len(turns) > 1 else None  # the last command is the rest after it
        assert np.abs(np.diff(turns[:last])).max(initial=0.0) <= 4.0 * rig.body.period + 1e-9

    def test_takes_about_its_ideal_time(self, rig):
        periods = rig.finish(rig.submit(TurnAngle(angle=math.pi / 2, rate=1.5)))
        assert periods * 0.05 < 1.4 * (math.pi / 2 / 1.5 + 1.5 / 4.0)

    def test_an_update_does_not_move_the_target_once_it_turns(self, rig):
        action = TurnAngle(angle=math.radians(60.0))
        ticket = rig.submit(action)
        rig.run(5)
        action.update(angle=math.radians(-60.0))
        rig.finish(ticket)
        assert math.degrees(rig.pose.yaw) == pytest.approx(60.0, abs=1.2)

    def test_stands_while_the_pose_is_lost_and_goes_on_when_it_is_back(self, rig):
        ticket = rig.submit(TurnAngle(angle=math.radians(90.0)))
        rig.run(5)
        rig.lost = True
        rig.run(5)  # the last pose stays valid for max_age
        assert rig.wheels.speeds == [0.0, 0.0]
        rig.lost = False
        rig.sense()
        rig.finish(ticket)
        assert ticket.state is SUCCEEDED
        assert math.degrees(rig.pose.yaw) == pytest.approx(90.0, abs=1.2)

    def test_fails_when_the_pose_stays_lost(self, rig):
        ticket = rig.submit(TurnAngle(angle=math.radians(90.0)))
        rig.run(5)
        rig.lost = True
        rig.finish(ticket, limit=12)
        assert ticket.failure.reason is Reason.LOST_POSE
        assert rig.wheels.speeds == [0.0, 0.0]

    def test_gives_up_when_the_robot_does_not_turn(self, rig):
        ticket = rig.submit(TurnAngle(angle=math.radians(90.0)))
        for _ in range(200):
            rig.put(0.0, 0.0)
            rig.run()
        assert ticket.failure.reason is Reason.TIMEOUT
        assert "deg were left" in ticket.failure.evidence

    @pytest.mark.parametrize(("angle", "rate"), [(math.nan, 1.0), (1.0, 0.0), (1.0, -1.0)])
    def test_what_cannot_be_turned_fails_at_once(self, rig, angle, rate):
        ticket = rig.submit(TurnAngle(angle=angle, rate=rate))
        rig.run()
        assert ticket.failure.reason is Reason.CANNOT


class TestTable2:
    """The decompositions of the paper's Table 2, as written."""

    def test_avoid_collision_is_turn_angle_then_set_wheel_speed(self, rig):
        ticket = rig.submit(AvoidCollision(turn=math.radians(60.0), duration=1.0, speed=0.25), Priority.HIGH)
        rig.finish(ticket)
        assert names(rig) == ["TurnAngle", "SetWheelSpeed"]
        assert math.degrees(rig.pose.yaw) == pytest.approx(60.0, abs=1.2)
        assert math.hypot(rig.pose.x, rig.pose.y) == pytest.approx(0.25)

    def test_avoid_collision_loses_no_period_between_the_two(self, rig):
        rig.submit(AvoidCollision(turn=math.radians(60.0), duration=1.0, speed=0.25), Priority.HIGH)
        rig.run(60)
        rest = [i for i, e in enumerate(rig.of(ActuatorCommanded)) if e.values == [0.0, 0.0]]
        assert rest == [len(rig.of(ActuatorCommanded)) - 1]

    def test_avoid_collision_takes_a_new_speed_until_it_drives(self, rig):
        action = AvoidCollision(turn=math.radians(60.0), duration=1.0, speed=0.25)
        ticket = rig.submit(action, Priority.HIGH)
        rig.run(5)
        action.update(speed=0.1)
        rig.finish(ticket)
        assert math.hypot(rig.pose.x, rig.pose.y) == pytest.approx(0.1)

    def test_go_to_origin_is_turn_to_position_then_set_wheel_speed(self, rig):
        rig.put(-1.0, 2.0, -63.0)
        ticket = rig.submit(GoToOrigin())
        rig.finish(ticket)
        assert names(rig)[:2] == ["SetWheelSpeed", "Stop"] or names(rig)[:2] == ["TurnAngle", "SetWheelSpeed"]
        assert ticket.state is SUCCEEDED
        assert math.hypot(rig.pose.x, rig.pose.y) < 0.1
        assert rig.wheels.speeds == [0.0, 0.0]

    @settings(max_examples=15, deadline=None)
    @given(x=st.floats(-2.0, 2.0), y=st.floats(-2.0, 2.0), degrees=st.floats(-180.0, 180.0))
    def test_go_to_origin_arrives_from_anywhere(self, make_rig, x, y, degrees):
        rig = make_rig()
        rig.put(x, y, degrees)
        rig.finish(rig.submit(GoToOrigin()))
        assert math.hypot(rig.pose.x, rig.pose.y) < 0.1

    def test_turn_to_origin_is_turn_angle(self, rig):
        rig.put(1.0, 1.0, 0.0)
        rig.finish(rig.submit(TurnToOrigin()))
        assert names(rig) == ["TurnAngle"]
        assert math.degrees(rig.pose.yaw) == pytest.approx(-135.0, abs=1.2)


class TestTurning:
    def test_turn_to_position_looks_at_it(self, rig):
        rig.put(1.0, 1.0, 90.0)
        rig.finish(rig.submit(TurnToPosition(x=0.0, y=1.0)))
        assert abs(math.degrees(rig.pose.yaw)) == pytest.approx(180.0, abs=1.2)

    @pytest.mark.parametrize("yaw", [170.0, -170.0, 0.0, 90.0])
    def test_turn_to_goes_the_short_way(self, rig, yaw):
        rig.put(0.0, 0.0, 175.0)
        ticket = rig.submit(TurnTo(yaw=math.radians(yaw)))
        periods = rig.finish(ticket)
        assert ticket.state is SUCCEEDED
        assert wrap_angle(rig.pose.yaw - math.radians(yaw)) == pytest.approx(0.0, abs=0.021)
        assert periods < 120


class TestFlinch:
    @pytest.mark.parametrize("speed", [0.35, -0.35])
    def test_gains_its_distance_straight(self, rig, speed):
        rig.put(0.0, 0.0, 30.0)
        ticket = rig.submit(Flinch(speed=speed, distance=0.08), Priority.HIGH)
        rig.finish(ticket)
        gained = math.copysign(math.hypot(rig.pose.x, rig.pose.y), rig.pose.x)
        assert math.copysign(1.0, speed) * gained == pytest.approx(0.08, abs=0.35 * 0.05)
        assert math.degrees(rig.pose.yaw) == pytest.approx(30.0)

    def test_fails_when_the_way_is_blocked(self, rig):
        ticket = rig.submit(Flinch(speed=0.35), Priority.HIGH)
        for _ in range(40):
            rig.put(0.0, 0.0)
            rig.run()
        assert ticket.failure.reason is Reason.TIMEOUT
        assert "gained 0.00 m of 0.08 m in 1.5 s" in ticket.failure.evidence

    def test_a_lost_pose_does_not_keep_it(self, rig):
        rig.lost = True
        rig.clock.advance(100)
        rig.sense()
        ticket = rig.submit(Flinch(speed=-0.35), Priority.HIGH)
        rig.finish(ticket)
        assert ticket.state is SUCCEEDED
        assert rig.pose.x == pytest.approx(-0.08, abs=0.02)

    def test_turning_round_begins_anew(self, rig):
        action = Flinch(speed=0.35)
        ticket = rig.submit(action, Priority.HIGH)
        rig.run(3)
        action.update(speed=-0.35)
        rig.finish(ticket)
        assert ticket.state is SUCCEEDED
        assert rig.pose.x == pytest.approx(3 * 0.35 * 0.05 - 0.08, abs=0.02)


class TestStop:
    def test_ends_when_the_wheels_stand(self, rig):
        rig.submit(SetWheelSpeed(speeds=[0.3, 0.3], duration=0.2))
        rig.run(4)
        ticket = rig.submit(Stop())
        assert rig.finish(ticket) <= 2
        assert rig.wheels.speeds == [0.0, 0.0]

    def test_without_a_measure_it_waits_its_patience(self, rig, monkeypatch):
        monkeypatch.setattr(rig.knowledge.robot, "wheel_speeds", lambda t=None: np.array([np.nan, np.nan]))
        assert rig.finish(rig.submit(Stop(patience=0.5))) == 11


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
        assert max(map(abs, rig.of(ActuatorCommanded)[-2].values)) <= slow if rig.of(Followed) else True

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
        assert len(rig.of(Followed)) == periods - 1
        assert max(abs(e.cross_track) for e in rig.of(Followed)) < 0.05
        assert {e.rung for e in rig.of(Followed)} == {"solved"}
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
        assert max(abs(e.cross_track) for e in rig.of(Followed)) < 0.05

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


class TestTable:
    @pytest.mark.parametrize("name", ACTIONS)
    def test_every_action_explains_itself_and_each_parameter(self, name):
        action = ACTIONS[name]
        assert action.__name__ == name
        assert action.__doc__
        for parameter in parameters_of(action):
            assert f"{parameter}:" in action.__doc__, f"{name} does not document '{parameter}'"

    def test_names_are_pinned(self):
        assert sorted(ACTIONS) == [
            "AvoidCollision", "Dock", "Flinch", "FollowPath", "FollowRobot", "GoTo", "GoToOrigin", "SetWheelSpeed",
            "Stop", "TurnAngle", "TurnTo", "TurnToOrigin", "TurnToPosition",
        ]  # fmt: skip

    def test_a_users_action_is_added_and_a_clash_is_refused(self):
        class Wave(AtomicAction):
            """Waves."""

            def act(self, body):
                return Progress.SUCCEEDED

        table = action_table(Wave)
        assert isinstance(make_action(table, "Wave", {}), Action)
        assert "Wave" not in ACTIONS
        with pytest.raises(InputError, match="two actions are named 'GoTo'"):
            action_table(type("GoTo", (Wave,), {}))
