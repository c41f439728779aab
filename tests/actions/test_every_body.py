"""The motion actions on every kind of body: the same actions, through the seam."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rocs_bt import Failure, Reason
from rocs_bt.actions import (
    AvoidCollision,
    Flinch,
    FollowPath,
    GoTo,
    SetTwist,
    SetWheelSpeed,
    Stop,
    TurnAngle,
    TurnTo,
)
from rocs_bt.base.geometry import Pose2
from rocs_bt.control.locomotion_kinds import LOCOMOTIONS, Axis, TurnAxis, make_locomotion
from rocs_bt.event import ActuatorCommanded, AtomicStarted
from rocs_bt.interfaces.action import Progress
from rocs_bt.interfaces.pipeline import TicketState

WHEELS = {"max_wheel_speed": 1.2, "max_wheel_acceleration": 1.5}
AXES = {
    "vx": Axis(max_speed=0.8, max_acceleration=1.0),
    "vy": Axis(max_speed=0.4, max_acceleration=0.8),
    "vz": Axis(max_speed=0.5, max_acceleration=0.8),
    "wz": TurnAxis(max_speed=1.6, max_acceleration=4.0),
}
PARAMETERS = {
    "differential": {"wheel_separation": 0.331, **WHEELS},
    "skid": {"effective_wheel_separation": 0.9, "icr_offset": 0.05, **WHEELS},
    "tracked": {"effective_wheel_separation": 0.55, "icr_offset": 0.02, **WHEELS},
    "omni3": {"base_radius": 0.18, **WHEELS},
    "mecanum": {"half_length": 0.2, "half_width": 0.2, **WHEELS},
    "twist": {axis: AXES[axis] for axis in ("vx", "wz")},
    "legged": {axis: AXES[axis] for axis in ("vx", "vy", "wz")},
    "flying": AXES,
}


@pytest.fixture(params=LOCOMOTIONS)
def rig(request, make_rig):
    return make_rig(locomotion=make_locomotion(request.param, **PARAMETERS[request.param]))


def test_every_kind_is_tried():
    assert set(PARAMETERS) == set(LOCOMOTIONS)


def commands(rig):
    return np.array([event.values for event in rig.of(ActuatorCommanded)])


def test_it_goes_to_a_goal_and_stops_there(rig):
    rig.knowledge.world.place("goal", Pose2(1.2, 0.8), kind="goal")
    assert rig.finish(rig.submit(GoTo(goal="goal"))) > 0
    assert rig.pose.distance(Pose2(1.2, 0.8)) <= 0.05
    found, limits = commands(rig), rig.locomotion
    assert (np.abs(found) <= limits.max_speed * (1.0 + 1e-9)).all()
    change = np.abs(np.diff(found[:-1], axis=0))  # the last command is the rest after it
    assert (change <= limits.max_acceleration * rig.body.period * (1.0 + 1e-6)).all()


def test_it_follows_a_path(rig):
    ticket = rig.submit(FollowPath(points=[(0, 0), (1, 0), (1, 1)]))
    rig.finish(ticket)
    assert ticket.state is TicketState.SUCCEEDED
    assert rig.pose.distance(Pose2(1.0, 1.0)) <= 0.05


@pytest.mark.parametrize("action", [TurnAngle(angle=1.3), TurnTo(yaw=1.3)])
def test_it_turns_on_the_spot(rig, action):
    rig.finish(rig.submit(type(action)(**action.parameters)))
    assert rig.pose.yaw == pytest.approx(1.3, abs=0.03)
    assert rig.pose.distance(Pose2(0.0, 0.0)) < 0.2 * abs(rig.locomotion.icr_offset) + 0.15


def test_reflex_actions_move_it(rig):
    for signal in ("front", "rear", "left_gap", "right_gap"):
        rig.heard[signal] = 2.0
    rig.heard |= {"free_turn": (3.0, 3.0), "bend_off": (0.0, 0.0), "room_behind": (2.0,) * 5}
    rig.sense()
    rig.finish(rig.submit(Flinch(speed=-0.3, distance=0.2)))
    assert rig.pose.x < -0.15
    rig.finish(rig.submit(AvoidCollision(turn=0.8, duration=1.0)))
    assert rig.pose.yaw == pytest.approx(0.8, abs=0.12)
    ticket = rig.submit(Stop())
    rig.finish(ticket)
    assert list(rig.wheels.speeds) == list(rig.locomotion.rest)


def test_the_smallest_action_is_that_of_the_body(rig):
    rig.knowledge.world.place("goal", Pose2(0.5, 0.0), kind="goal")
    rig.finish(rig.submit(GoTo(goal="goal")))
    smallest = "SetWheelSpeed" if rig.locomotion.wheels else "SetTwist"
    assert {event.action for event in rig.of(AtomicStarted)} == {smallest}


def test_wheel_speeds_are_for_wheels_only(rig):
    done = SetWheelSpeed(speeds=[0.1] * len(rig.locomotion.values)).act(rig.body)
    if rig.locomotion.wheels:
        assert done is Progress.RUNNING
    else:
        assert done == Failure(Reason.CANNOT, f"a '{rig.locomotion.kind}' locomotion has no wheels; use SetTwist")


@pytest.mark.parametrize(("axis", "name"), [("vx", "forward"), ("vy", "left"), ("vz", "up"), ("wz", "turn")])
def test_a_twist_moves_the_axes_that_the_body_has(rig, axis, name):
    ticket = rig.submit(SetTwist(**{name: 0.3}, duration=1.0))
    rig.finish(ticket)
    if axis not in rig.locomotion.axes:
        assert (ticket.state, ticket.failure.reason) == (TicketState.FAILED, Reason.CANNOT)
        assert [n for n, _ in SetTwist.misfits({name: 0.3}, rig.knowledge)] == [name]
        return
    assert ticket.state is TicketState.SUCCEEDED
    moved = {"vx": rig.pose.x, "vy": rig.pose.y, "wz": rig.pose.yaw}
    if axis != "vz":
        assert moved[axis] == pytest.approx(0.3, abs=0.01)
        assert all(abs(value) < 0.02 for other, value in moved.items() if other != axis)
    index = rig.locomotion.values.index(axis) if axis in rig.locomotion.values else None
    if index is not None:
        assert commands(rig)[0][index] == 0.3


def test_a_duration_is_of_whole_periods(rig):
    ticket = rig.submit(SetTwist(turn=0.1, duration=0.2))
    assert rig.finish(ticket) == 4
    assert not SetTwist.can_move({"turn": 0.0})
    assert SetTwist.can_move({"turn": 0.1})
    assert math.isinf(SetTwist().duration)
