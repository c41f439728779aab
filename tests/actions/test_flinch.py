"""Flinch, on a robot whose wheels do exactly what they are told."""

import math

import pytest

from rocs_bt.actions import Flinch
from rocs_bt.event import ActuatorCommanded
from rocs_bt.interfaces.action import Reason
from rocs_bt.interfaces.pipeline import Priority, TicketState

SUCCEEDED, RUNNING = TicketState.SUCCEEDED, TicketState.RUNNING


@pytest.fixture
def rig(make_rig):
    """A robot of few beams that knows the ground around it."""
    rig = make_rig()
    hear(rig, {"room_ahead": (2.0,) * 5, "room_behind": (2.0,) * 5})
    return rig


@pytest.fixture
def ring(make_rig):
    """A robot of 0.455 x 0.381 m with beams all round."""
    return make_rig(ring=True)


def gaps(front=1.0, rear=1.0, left=1.0, right=1.0):
    """The gaps around a robot [m], as its monitor writes them."""
    return {"front": front, "rear": rear, "left_gap": left, "right_gap": right}


def hear(rig, signals):
    """Sense these values from now on."""
    rig.heard |= signals
    rig.sense()


def held(rig, periods):
    """Run while something holds the robot in its place."""
    place = rig.pose
    for _ in range(periods):
        rig.run()
        rig.put(place.x, place.y, math.degrees(rig.pose.yaw))
        rig.knowledge.signals.write("speed", [0.0], rig.clock.now())


def shove(rig, ahead, aside=0.0, speed=0.4):
    """Push the robot by so much [m], at this speed [m/s]; meanwhile it may drive against that."""
    for _ in range(round(math.hypot(ahead, aside) / (speed * 0.05))):
        share = speed * 0.05 / math.hypot(ahead, aside)
        x, y = rig.pose.transform(share * ahead, share * aside)
        rig.put(x, y, math.degrees(rig.pose.yaw))
        rig.run()


@pytest.mark.parametrize("speed", [0.35, -0.35])
@pytest.mark.parametrize("known", [0.0, math.nan, 0.05, 0.2])
def test_it_does_not_leave_the_ground_that_it_knows(make_rig, speed, known):
    rig = make_rig()
    way = "room_ahead" if speed > 0.0 else "room_behind"
    ticket = rig.submit(Flinch(speed=speed, distance=0.5), Priority.HIGH)
    while not ticket.state.done:
        hear(rig, {way: (known - abs(rig.pose.x),) * 5})
        rig.run()
    assert abs(rig.pose.x) <= max(known, 0.0) or (math.isnan(known) and rig.pose.x == 0.0)
    assert ticket.failure.reason in (Reason.BLOCKED, Reason.TIMEOUT)


@pytest.mark.parametrize("driven", [0.0, 0.3])
def test_a_robot_that_is_blind_behind_backs_off_over_the_ground_that_it_has_driven(ring, driven):
    ring.knowledge.robot.blind = frozenset({"rear"})
    hear(ring, {"front": 2.0, "rear": math.inf})
    ring.finish(ring.submit(Flinch(speed=0.2, distance=max(driven, 0.001)), Priority.HIGH))
    start = ring.pose.x
    ticket = ring.submit(Flinch(speed=-0.4, distance=0.6), Priority.HIGH)
    ring.finish(ticket)
    assert ticket.failure.reason is Reason.BLOCKED
    assert 0.0 <= ring.pose.x <= start - 0.5 * driven


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
def test_without_a_speed_it_drives_back_to_where_it_came_to_stand(ring, push):
    ring.put(1.0, 0.5, 30.0)
    ticket = ring.submit(Flinch(speed=0.0, resist=0.2), Priority.HIGH)
    ring.run(40)
    assert ring.pose == ring.path[0]
    shove(ring, push)
    assert ring.pose.distance(ring.path[0]) > 0.04
    ring.run(60)
    assert ring.pose.distance(ring.path[0]) < 0.01
    assert ring.wheels.speeds == [0.0, 0.0]
    assert max(abs(v) for e in ring.of(ActuatorCommanded) for v in e.values) == pytest.approx(0.2)
    assert ticket.state is RUNNING


def test_a_nudge_does_not_move_it(ring):
    ring.submit(Flinch(speed=0.0, resist=0.2), Priority.HIGH)
    ring.run(2)
    shove(ring, 0.035, speed=0.1)
    ring.run(10)
    assert ring.pose.x == pytest.approx(0.035)


def test_what_it_drove_while_it_came_to_stand_is_no_push(ring):
    ticket = ring.submit(Flinch(speed=0.0, resist=0.2), Priority.HIGH)
    for speed in (0.4, 0.2):  # still braking
        ring.wheels.speeds = [speed, speed]
        ring.put(ring.pose.x + 0.06, 0.0)
        ring.run()
    ring.run(20)
    assert ring.pose.x == pytest.approx(0.12)
    assert ticket.state is RUNNING


@pytest.mark.parametrize(("aside", "turned"), [(0.1, 0.0), (-0.1, 0.0), (0.1, 90.0)])
def test_from_the_side_it_lets_itself_be_pushed(ring, aside, turned):
    ring.put(0.0, 0.0, turned)
    ring.submit(Flinch(speed=0.0, resist=0.2), Priority.HIGH)
    ring.run(2)
    shove(ring, 0.0, aside)
    ring.run(10)
    assert math.hypot(ring.pose.x, ring.pose.y) == pytest.approx(0.1)


def test_who_is_pushed_too_far_stands_there_anew(ring):
    ring.submit(Flinch(speed=0.0, resist=0.2), Priority.HIGH)
    ring.run(2)
    shove(ring, 0.8)  # of which it makes good a half, as it drives back at half of that speed
    ring.run(40)
    assert ring.pose.x == pytest.approx(0.3, abs=0.03)


@pytest.mark.parametrize(("x", "y"), [(0.045, 0.0), (-0.06, 0.0), (0.1, 0.0), (-2.0, 0.0), (0.1, 0.3)])
def test_a_pose_that_jumps_is_no_push(ring, x, y):
    ring.submit(Flinch(speed=0.0, resist=0.2), Priority.HIGH)
    ring.run(2)
    ring.put(x, y)
    ring.run(20)
    assert (ring.pose.x, ring.pose.y) == (x, y)
    shove(ring, 0.1)  # and it resists there
    ring.run(40)
    assert ring.pose.x == pytest.approx(x, abs=0.011)


def test_without_a_speed_known_it_lets_itself_be_pushed(ring):
    ring.submit(Flinch(speed=0.0, resist=0.2), Priority.HIGH)
    ring.run(2)
    for step in range(1, 11):
        ring.put(0.02 * step, 0.0)
        ring.knowledge.signals.write("speed", [math.nan], ring.clock.now())
        ring.execute.run(ring.clock.now())
        ring.clock.advance()
        assert ring.wheels.speeds == [0.0, 0.0]


def test_where_its_pose_is_found_again_it_stands_anew(ring):
    ring.submit(Flinch(speed=0.0, resist=0.2), Priority.HIGH)
    ring.run(2)
    ring.lost = True
    ring.clock.advance(100)
    ring.put(0.1, 0.0)
    ring.run(2)
    ring.lost = False
    ring.run(10)
    assert ring.pose.x == 0.1


def test_it_may_let_itself_be_pushed(ring):
    ring.submit(Flinch(speed=0.0, resist=0.0), Priority.HIGH)
    ring.run(2)
    shove(ring, -0.2)
    ring.run(10)
    assert ring.pose.x == pytest.approx(-0.2)


def test_it_stands_while_its_pose_is_lost(ring):
    ring.submit(Flinch(speed=0.0, resist=0.2), Priority.HIGH)
    ring.run(2)
    ring.put(-0.5, 0.0)
    ring.lost = True
    ring.clock.advance(100)
    ring.sense()
    ring.run(10)
    assert ring.pose.x == -0.5


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


def test_between_two_things_it_stands(ring):
    ticket = ring.submit(Flinch(speed=-0.4, creep=0.0, get_out=True), Priority.HIGH)
    hear(ring, gaps(front=0.19, rear=0.24, left=0.1))
    ring.run(60)
    assert (ring.pose.x, ticket.state) == (0.0, RUNNING)
    hear(ring, gaps(front=0.19, rear=0.26, left=0.1))
    ring.finish(ticket)
    assert (ring.pose.x, ticket.state) == (pytest.approx(-0.08, abs=0.02), SUCCEEDED)


def test_without_get_out_it_drives_and_fails(ring):
    ticket = ring.submit(Flinch(speed=-0.4), Priority.HIGH)
    hear(ring, gaps(front=0.19, rear=0.24))
    held(ring, 45)
    assert ticket.failure.reason is Reason.TIMEOUT


@pytest.mark.parametrize(
    ("around", "degrees"),
    [
        (gaps(front=0.22, rear=0.19, left=0.3), -60.0),
        (gaps(front=0.22, rear=0.19, right=0.3), 60.0),
        (gaps(front=0.6, rear=0.6, left=0.22), -60.0),
        (gaps(front=0.22, rear=0.19, left=0.12), 60.0),  # the stern swings away from what is beside the robot
        (gaps(front=0.22, rear=0.19, left=0.12, right=0.13), 0.0),
        (gaps(front=0.22, rear=0.19, left=0.10), 0.0),
        (gaps(front=0.22, rear=0.13), 0.0),
        (gaps(front=0.22, rear=0.19, left=math.nan), 0.0),
    ],
)
def test_where_backing_off_is_in_vain_it_turns_out_if_there_is_room(ring, around, degrees):
    hear(ring, around)
    ring.submit(Flinch(speed=0.4, distance=0.3, creep=0.0, get_out=True), Priority.HIGH)
    held(ring, 28)
    assert ring.pose.yaw == pytest.approx(0.0)
    held(ring, 25)
    assert math.degrees(ring.pose.yaw) == pytest.approx(degrees, abs=8.0)


def test_after_the_turn_it_drives_ahead(ring):
    hear(ring, gaps(front=0.3, rear=0.3, left=0.22))
    ring.submit(Flinch(speed=-0.4, distance=0.3, get_out=True), Priority.HIGH)
    held(ring, 28)
    assert ring.wheels.speeds == pytest.approx([-0.4, -0.4])
    held(ring, 28)
    assert math.degrees(ring.pose.yaw) == pytest.approx(-60.0, abs=8.0)
    assert ring.wheels.speeds == pytest.approx([0.4, 0.4])


def test_it_stops_turning_where_there_is_no_more_room(ring):
    hear(ring, gaps(front=0.22, rear=0.19, left=0.3))
    ring.submit(Flinch(speed=0.4, distance=0.3, creep=0.0, get_out=True), Priority.HIGH)
    held(ring, 36)
    begun = ring.pose.yaw
    assert begun < -0.05
    hear(ring, gaps(front=0.22, rear=0.13, left=0.3))
    held(ring, 20)
    assert ring.pose.yaw == pytest.approx(begun, abs=0.15)


def test_while_the_robot_drives_backing_off_is_not_in_vain(ring):
    hear(ring, gaps(front=0.6, rear=0.6, left=0.22))
    ticket = ring.submit(Flinch(speed=0.4, distance=5.0, get_out=True), Priority.HIGH)
    ring.run(45)
    assert (ring.pose.yaw, ticket.failure.reason) == (pytest.approx(0.0), Reason.TIMEOUT)


@pytest.mark.parametrize(
    ("around", "sign"),
    [
        (gaps(front=0.22, rear=0.12), 1),
        (gaps(front=0.12, rear=0.22), -1),
        (gaps(front=0.13, rear=0.12), 0),
        (gaps(front=0.22, rear=0.12, left=0.14), 0),
    ],
)
def test_between_two_things_it_creeps_to_the_middle(ring, around, sign):
    hear(ring, around)
    ring.submit(Flinch(speed=-0.4, distance=0.3, get_out=True), Priority.HIGH)
    held(ring, 28)
    assert ring.wheels.speeds == [0.0, 0.0]
    held(ring, 5)
    assert ring.wheels.speeds == pytest.approx([0.1 * sign] * 2)


def test_with_few_beams_it_stands_between_two_things_and_lets_itself_be_pushed(rig):
    hear(rig, gaps(front=0.22, rear=0.12))
    rig.submit(Flinch(speed=-0.4, get_out=True), Priority.HIGH)
    rig.run(60)
    shove(rig, 0.1)
    rig.run(10)
    assert rig.pose.x == pytest.approx(0.1)


def test_with_a_vague_pose_it_lets_itself_be_pushed(ring):
    hear(ring, {"pose_spread": 0.02})
    ring.submit(Flinch(speed=0.0), Priority.HIGH)
    ring.run(2)
    shove(ring, 0.1)
    ring.run(20)
    assert ring.pose.x == pytest.approx(0.1)
