"""The shipped actions, on a robot whose wheels do exactly what they are told."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.actions import (
    ACTIONS,
    AvoidCollision,
    GoToOrigin,
    SetWheelSpeed,
    Stop,
    TurnAngle,
    TurnTo,
    TurnToOrigin,
    TurnToPosition,
    action_table,
)
from rocs_bt.actions.avoid_collision import LEFT
from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import wrap_angle
from rocs_bt.event import ActuatorCommanded, AtomicStarted
from rocs_bt.interfaces.action import Action, AtomicAction, Progress, Reason, make_action, parameters_of
from rocs_bt.interfaces.pipeline import Priority, TicketState

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
            (0.0, 0.1),
            (0.05, 0.2),
            (0.1, pytest.approx(0.3)),
            (pytest.approx(0.15), 0.0),
        ]
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
        assert "2 wheel speeds (left, right), found [0.1]" in ticket.failure.evidence


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
        turns = wheels @ rig.body.locomotion.twist_from_q[2]
        assert np.abs(turns).max() <= rate + 1e-9
        last = -1 if len(turns) > 1 else None  # the last command is the rest after it
        drive = rig.body.locomotion
        most = drive.max_acceleration.min() / drive.arm
        assert np.abs(np.diff(turns[:last])).max(initial=0.0) <= most * rig.body.period + 1e-9

    def test_takes_about_its_ideal_time(self, rig):
        drive = rig.body.locomotion
        periods = rig.finish(rig.submit(TurnAngle(angle=math.pi / 2, rate=1.5)))
        assert periods * 0.05 < 1.4 * (math.pi / 2 / 1.5 + 1.5 * drive.arm / drive.max_acceleration.min())

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
        assert (1.0 - LEFT) * 60.0 <= math.degrees(rig.pose.yaw) <= 60.0
        assert math.hypot(rig.pose.x, rig.pose.y) == pytest.approx(0.25)

    def test_avoid_collision_does_not_wait_for_the_last_degrees(self, make_rig):
        def turned(action):
            rig = make_rig()
            rig.finish(rig.submit(action, Priority.HIGH))
            return [e.values[0] < 0.0 for e in rig.of(ActuatorCommanded)].count(True) * rig.body.period

        angle = math.radians(60.0)
        took = turned(AvoidCollision(turn=angle, duration=0.05, rate=2.5))
        assert took < turned(TurnAngle(angle=angle, rate=2.5)) < 0.8  # who comes at 0.2 m/s makes 0.16 m meanwhile

    @pytest.mark.parametrize(
        ("free", "behind", "rear", "back", "turned"),
        [
            ((math.pi, math.pi), 1.0, math.inf, 0.0, 60.0),
            ((math.nan, math.nan), 1.0, math.inf, 0.0, 60.0),
            ((0.8, 0.0), 1.0, math.inf, 0.0, math.degrees(0.8)),
            ((0.2, 3.0), 1.0, math.inf, 0.3, math.degrees(0.2)),
            ((0.2, 3.0), 0.2, math.inf, 0.2, math.degrees(0.2)),
            ((0.2, 3.0), 1.0, 0.4, 0.15, math.degrees(0.2)),
            ((0.2, 3.0), 1.0, 0.2, 0.0, math.degrees(0.2)),
            ((0.2, 3.0), 1.0, math.nan, 0.0, math.degrees(0.2)),
            ((0.2, 3.0), 0.0, math.inf, 0.0, math.degrees(0.2)),
        ],
    )
    def test_avoid_collision_sweeps_nothing_with_a_corner(self, rig, free, behind, rear, back, turned):
        def tell():
            rig.knowledge.signals.write("free_turn", free, rig.clock.now())
            rig.knowledge.signals.write("rear", [rear], rig.clock.now())
            rig.knowledge.signals.write("room_behind", [0.0, 0.0, behind, 0.0, 0.0], rig.clock.now())

        sense, rig.sense = rig.sense, lambda: (sense(), tell())
        tell()
        rig.finish(rig.submit(AvoidCollision(turn=math.radians(60.0), duration=1.0, speed=0.25), Priority.HIGH))
        assert names(rig) == ["SetWheelSpeed"] * (back > 0.0) + ["TurnAngle", "SetWheelSpeed"]
        assert (1.0 - LEFT) * turned <= math.degrees(rig.pose.yaw) <= turned
        assert min(pose.x for pose in rig.path) == pytest.approx(-back, abs=0.02)

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
            "AvoidCollision",
            "Dock",
            "Flinch",
            "FollowPath",
            "FollowRobot",
            "FollowRoute",
            "GoTo",
            "GoToOrigin",
            "SendMessage",
            "SetTwist",
            "SetWheelSpeed",
            "Stop",
            "TurnAngle",
            "TurnTo",
            "TurnToOrigin",
            "TurnToPosition",
        ]

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
