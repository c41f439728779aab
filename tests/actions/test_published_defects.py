"""What the published C++ code does wrong in its actions and its planner, and these do not."""

import math

import pytest

from rocs_bt.actions import GoTo, GoToOrigin, SetWheelSpeed, TurnAngle, TurnToOrigin
from rocs_bt.base.geometry import Pose2, wrap_angle
from rocs_bt.event import ActuatorCommanded, TicketChanged
from rocs_bt.interfaces.action import Reason
from rocs_bt.interfaces.pipeline import TicketState


@pytest.fixture
def goal(rig):
    rig.knowledge.world.place("goal", Pose2(0.0, 0.0), kind="goal")
    return "goal"


def test_the_deliberative_route_commands_in_every_period(rig, goal):
    """There: 6.3 commands a second, each on a pose that is one chain old, because children are queued again."""
    rig.put(-1.5, 0.0, 90.0)
    periods = rig.finish(rig.submit(GoTo(goal=goal)))
    assert [round(e.t / 0.05) for e in rig.of(ActuatorCommanded)] == list(range(periods))


@pytest.mark.parametrize(("y", "degrees"), [(1.5, -90.0), (-1.5, 90.0)])
def test_straight_above_and_below_has_the_right_sign(rig, y, degrees):
    """There: the angle of a position at x = 0 has the wrong sign."""
    rig.put(0.0, y, 0.0)
    rig.finish(rig.submit(TurnToOrigin()))
    assert math.degrees(rig.pose.yaw) == pytest.approx(degrees, abs=1.2)


@pytest.mark.parametrize("degrees", [180.0, -179.95, 179.95])
def test_looking_west_is_as_good_as_any_direction(rig, goal, degrees):
    """There: a yaw within 0.0016 rad of west is "invalid"."""
    rig.put(1.5, 0.0, degrees)
    ticket = rig.submit(GoTo(goal=goal))
    rig.finish(ticket)
    assert ticket.state is TicketState.SUCCEEDED


def test_a_turn_across_west_goes_the_short_way(rig):
    rig.put(0.0, 0.0, 170.0)
    ticket = rig.submit(TurnAngle(angle=math.radians(20.0)))
    assert rig.finish(ticket) < 40
    assert wrap_angle(rig.pose.yaw - math.radians(-170.0)) == pytest.approx(0.0, abs=0.021)


def test_an_invalid_pose_is_told_and_not_met_with_silence(rig, goal):
    """There: with an invalid orientation the action pushes nothing, and nobody hears why."""
    rig.lost = True
    rig.clock.advance(100)
    tickets = [rig.submit(action) for action in (TurnToOrigin(), GoTo(goal=goal), GoToOrigin())]
    for ticket in tickets:
        rig.finish(ticket)
        assert ticket.failure.reason is Reason.LOST_POSE
    assert "LOST_POSE: the signal 'pose' has been invalid" in rig.of(TicketChanged)[-1].reason


def test_set_wheel_speed_lasts_as_long_as_it_says_and_says_when_it_is_over(rig):
    """There: no duration, no feedback, no result."""
    ticket = rig.submit(SetWheelSpeed(speeds=[0.2, 0.2], duration=0.5))
    assert rig.finish(ticket) == 10
    rig.run()
    assert ticket.state is TicketState.SUCCEEDED
    assert rig.wheels.speeds == [0.0, 0.0]


def test_a_robot_that_is_almost_aligned_is_not_faster_than_one_that_is(rig):
    """There: near-aligned drives at twice the speed of aligned."""
    rig.put(-2.0, 0.0, 8.0)
    rig.finish(rig.submit(GoToOrigin(speed=0.3)))
    assert max(max(e.values) for e in rig.of(ActuatorCommanded)) == pytest.approx(0.3)


def test_the_goal_is_reached_when_it_is_and_not_by_a_snapshot(rig):
    """There: an action holds the position of the moment when it was made."""
    rig.knowledge.world.place("goal", Pose2(1.0, 0.0), kind="goal")
    ticket = rig.submit(GoTo(goal="goal"))
    rig.knowledge.world.place("goal", Pose2(0.0, 1.0), kind="goal")
    rig.finish(ticket)
    assert rig.pose.distance(Pose2(0.0, 1.0)) < 0.06
