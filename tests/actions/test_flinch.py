"""Flinch, on a robot whose wheels do exactly what they are told."""

import math

import pytest

from rocs_bt.action import Reason
from rocs_bt.actions import Flinch
from rocs_bt.event import ActuatorCommanded
from rocs_bt.pipeline import Priority, TicketState

SUCCEEDED, RUNNING = TicketState.SUCCEEDED, TicketState.RUNNING


def shove(rig, ahead, aside=0.0, speed=0.4):
    """Push the robot by so much [m], at this speed [m/s]; meanwhile it may drive against that."""
    for _ in range(round(math.hypot(ahead, aside) / (speed * 0.05))):
        share = speed * 0.05 / math.hypot(ahead, aside)
        x, y = rig.pose.transform(share * ahead, share * aside)
        rig.put(x, y, math.degrees(rig.pose.yaw))
        rig.run()


@pytest.mark.parametrize("speed", [0.35, -0.35])
def test_gains_its_distance_straight(rig, speed):
    rig.put(0.0, 0.0, 30.0)
    ticket = rig.submit(Flinch(speed=speed, distance=0.08), Priority.HIGH)
    rig.finish(ticket)
    gained = math.copysign(math.hypot(rig.pose.x, rig.pose.y), rig.pose.x)
    assert math.copysign(1.0, speed) * gained == pytest.approx(0.08, abs=0.35 * 0.05)
    assert math.degrees(rig.pose.yaw) == pytest.approx(30.0)


@pytest.mark.parametrize(("speed", "bend"), [(0.35, 0.6), (-0.35, -1.5)])
def test_goes_on_the_bend_on_which_there_is_room(rig, speed, bend):
    ticket = rig.submit(Flinch(speed=speed, distance=0.08), Priority.HIGH)
    while not ticket.state.done:
        rig.knowledge.signals.write("bend_off", (0.6, -1.5), rig.clock.now())  # ahead, and back
        rig.run()
    half = 0.5 * rig.pose.yaw
    assert rig.pose.yaw == pytest.approx(bend * math.copysign(math.hypot(rig.pose.x, rig.pose.y), speed), rel=0.02)
    assert math.tan(half) == pytest.approx(rig.pose.y / rig.pose.x)


def test_fails_when_the_way_is_blocked(rig):
    ticket = rig.submit(Flinch(speed=0.35), Priority.HIGH)
    for _ in range(40):
        rig.put(0.0, 0.0)
        rig.run()
    assert ticket.failure.reason is Reason.TIMEOUT
    assert "gained 0.00 m of 0.08 m in 1.5 s" in ticket.failure.evidence


def test_a_lost_pose_does_not_keep_it(rig):
    rig.lost = True
    rig.clock.advance(100)
    rig.sense()
    ticket = rig.submit(Flinch(speed=-0.35), Priority.HIGH)
    rig.finish(ticket)
    assert ticket.state is SUCCEEDED
    assert rig.pose.x == pytest.approx(-0.08, abs=0.02)


def test_turning_round_begins_anew(rig):
    action = Flinch(speed=0.35)
    ticket = rig.submit(action, Priority.HIGH)
    rig.run(3)
    action.update(speed=-0.35)
    rig.finish(ticket)
    assert ticket.state is SUCCEEDED
    assert rig.pose.x == pytest.approx(3 * 0.35 * 0.05 - 0.08, abs=0.02)


@pytest.mark.parametrize("push", [0.15, -0.15])
def test_without_a_speed_it_drives_back_to_where_it_came_to_stand(rig, push):
    rig.put(1.0, 0.5, 30.0)
    ticket = rig.submit(Flinch(speed=0.0, resist=0.2), Priority.HIGH)
    rig.run(40)
    assert rig.pose == rig.path[0]
    shove(rig, push)
    assert rig.pose.distance(rig.path[0]) > 0.04
    rig.run(60)
    assert rig.pose.distance(rig.path[0]) < 0.01
    assert rig.wheels.speeds == [0.0, 0.0]
    assert max(abs(v) for e in rig.of(ActuatorCommanded) for v in e.values) == pytest.approx(0.2)
    assert ticket.state is RUNNING


def test_a_nudge_does_not_move_it(rig):
    rig.submit(Flinch(speed=0.0, resist=0.2), Priority.HIGH)
    rig.run(2)
    shove(rig, 0.035, speed=0.1)
    rig.run(10)
    assert rig.pose.x == pytest.approx(0.035)


def test_what_it_drove_while_it_came_to_stand_is_no_push(rig):
    ticket = rig.submit(Flinch(speed=0.0, resist=0.2), Priority.HIGH)
    for speed in (0.4, 0.2):  # still braking
        rig.wheels.speeds = [speed, speed]
        rig.put(rig.pose.x + 0.06, 0.0)
        rig.run()
    rig.run(20)
    assert rig.pose.x == pytest.approx(0.12)
    assert ticket.state is RUNNING


@pytest.mark.parametrize(("aside", "turned"), [(0.1, 0.0), (-0.1, 0.0), (0.1, 90.0)])
def test_from_the_side_it_lets_itself_be_pushed(rig, aside, turned):
    rig.put(0.0, 0.0, turned)
    rig.submit(Flinch(speed=0.0, resist=0.2), Priority.HIGH)
    rig.run(2)
    shove(rig, 0.0, aside)
    rig.run(10)
    assert math.hypot(rig.pose.x, rig.pose.y) == pytest.approx(0.1)


def test_who_is_pushed_too_far_stands_there_anew(rig):
    rig.submit(Flinch(speed=0.0, resist=0.2), Priority.HIGH)
    rig.run(2)
    shove(rig, 0.8)  # of which it makes good a half, as it drives back at half of that speed
    rig.run(40)
    assert rig.pose.x == pytest.approx(0.3, abs=0.03)


@pytest.mark.parametrize(("x", "y"), [(0.045, 0.0), (-0.06, 0.0), (0.1, 0.0), (-2.0, 0.0), (0.1, 0.3)])
def test_a_pose_that_jumps_is_no_push(rig, x, y):
    rig.submit(Flinch(speed=0.0, resist=0.2), Priority.HIGH)
    rig.run(2)
    rig.put(x, y)
    rig.run(20)
    assert (rig.pose.x, rig.pose.y) == (x, y)
    shove(rig, 0.1)  # and it resists there
    rig.run(40)
    assert rig.pose.x == pytest.approx(x, abs=0.011)


def test_without_a_speed_known_it_lets_itself_be_pushed(rig):
    rig.submit(Flinch(speed=0.0, resist=0.2), Priority.HIGH)
    rig.run(2)
    for step in range(1, 11):
        rig.put(0.02 * step, 0.0)
        rig.knowledge.signals.write("speed", [math.nan], rig.clock.now())
        rig.execute.run(rig.clock.now())
        rig.clock.advance()
        assert rig.wheels.speeds == [0.0, 0.0]


def test_where_its_pose_is_found_again_it_stands_anew(rig):
    rig.submit(Flinch(speed=0.0, resist=0.2), Priority.HIGH)
    rig.run(2)
    rig.lost = True
    rig.clock.advance(100)
    rig.put(0.1, 0.0)
    rig.run(2)
    rig.lost = False
    rig.run(10)
    assert rig.pose.x == 0.1


def test_it_may_let_itself_be_pushed(rig):
    rig.submit(Flinch(speed=0.0, resist=0.0), Priority.HIGH)
    rig.run(2)
    shove(rig, -0.2)
    rig.run(10)
    assert rig.pose.x == pytest.approx(-0.2)


def test_it_stands_while_its_pose_is_lost(rig):
    rig.submit(Flinch(speed=0.0, resist=0.2), Priority.HIGH)
    rig.run(2)
    rig.put(-0.5, 0.0)
    rig.lost = True
    rig.clock.advance(100)
    rig.sense()
    rig.run(10)
    assert rig.pose.x == -0.5


def test_to_set_off_begins_anew(rig):
    action = Flinch(speed=-0.4, distance=0.3)
    ticket = rig.submit(action, Priority.HIGH)
    rig.run(10)
    assert rig.pose.x == pytest.approx(-0.2, abs=0.01)
    action.update(speed=0.0)
    rig.run(100)  # far longer than its timeout, which is not for standing
    action.update(speed=-0.4)
    rig.finish(ticket)
    assert ticket.state is SUCCEEDED
    assert rig.pose.x == pytest.approx(-0.5, abs=0.02)


def test_each_course_has_the_whole_timeout(rig):
    action = Flinch(speed=0.35, timeout=1.5)
    ticket, periods = rig.submit(action, Priority.HIGH), 0
    while not ticket.state.done:
        if periods == 20:
            action.update(speed=-0.35)
        rig.put(0.0, 0.0)  # the way is blocked, ahead and back
        rig.run()
        periods += 1
    assert ticket.failure.reason is Reason.TIMEOUT
    assert periods == pytest.approx(20 + 30, abs=1)
