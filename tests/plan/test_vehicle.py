"""Vehicle: times until contact with what moves."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from rocs_bt.base.geometry import Pose2
from rocs_bt.control.locomotion import Response
from rocs_bt.knowledge import Movers, OccupancyGrid
from rocs_bt.plan import Observation, Vehicle

HERE = Pose2(1.0, 2.0, np.pi / 2.0)  # heading north
AHEAD = np.arange(0.5, 4.1, 0.5)
STAYING = np.zeros((1, 8, 3))


def vehicle(movers):
    """Robot of 1 m x 0.5 m among movers, without a static obstacle."""
    world = SimpleNamespace(movers=movers, occupancy=OccupancyGrid(0.05, 10.0))
    graph = SimpleNamespace(attributes=lambda name: {"length": 1.0, "width": 0.5})
    knowledge = SimpleNamespace(world=world, graph=graph, agent="R")
    goal = {"goal": HERE}
    return Vehicle(
        SimpleNamespace(goals=goal, tolerances={"goal": 0.1}, locomotion=None, knowledge=knowledge), movers=True
    )


def coming():
    """A mover 3 m ahead of the robot that comes at 1 m/s."""
    return Movers.of(10.0, np.array([[1.0, 5.0, 0.0, -1.0]]), 0.25)


def near(*values):
    return pytest.approx(values)


def times(robot, poses=STAYING, margin=0.1):
    """Earliest and expected time until contact, from the time of the estimates."""
    earliest, expected = robot.contact_times(Observation(10.0, HERE, {}), poses, AHEAD, margin)
    return tuple(earliest), tuple(expected)


def test_a_staying_robot_is_reached_by_a_mover_that_comes():
    # 3 m less half the length, the radius and the margin, at 1 m/s
    assert times(vehicle(coming())) == (near(2.15), near(2.15))


def test_poses_are_of_the_body_frame_and_each_has_its_own_time():
    aside = np.zeros((3, 8, 3))
    aside[1, :, 1] = 1.0  # 1 m to the left, which is west
    aside[2, :, 0] = -1.0 * AHEAD  # back, as fast as the mover comes
    assert times(vehicle(coming()), aside)[0] == near(2.15, 4.0, 4.0)


def test_all_probable_hypotheses_count_for_the_earliest_time_and_with_their_weights_for_the_expected_one():
    known = coming()
    for stops, expected in ((0.5, 3.075), (0.95, 4.0), (0.05, 2.15)):
        belief = np.array([[1.0 - stops, 0.0, stops, 0.0]])
        robot = vehicle(dataclasses.replace(known, belief=belief))
        assert times(robot) == (near(4.0 if stops > 0.9 else 2.15), near(expected))


def test_uncertainty_adds_to_the_margin():
    unsure = dataclasses.replace(coming(), covariance=np.diag([0.09, 0.09, 0.0, 0.0])[None])
    assert times(vehicle(coming()), margin=0.5) == (near(1.75), near(1.75))
    assert times(vehicle(unsure), margin=0.5) == (near(1.45), near(1.45))


def test_a_robot_may_leave_a_mover_that_is_too_near_but_not_approach_it():
    close = Movers.of(10.0, np.array([[1.0, 2.6, 0.0, 0.0]]), 0.25)  # a decimetre ahead
    poses = np.zeros((3, 8, 3))
    poses[0, :, 0], poses[2, :, 0] = -0.2 * AHEAD, 0.02
    assert times(vehicle(close), poses, margin=0.3)[0] == near(4.0, 4.0, 0.25)


def test_the_mover_that_is_met_first_counts():
    two = Movers.of(10.0, np.array([[1.0, 5.0, 0.0, -1.0], [1.0, 4.0, 0.0, -1.0]]), 0.25)
    assert times(vehicle(two)) == (near(1.15), near(1.15))


@pytest.mark.parametrize("robot", [vehicle(None), vehicle(Movers.of(0.0, np.zeros((0, 4))))])
def test_without_tracked_movers_nothing_is_met(robot):
    assert times(robot) == (near(4.0), near(4.0))
    assert np.isinf(robot.clearances(HERE, 5.0, STAYING)).all()


def test_a_command_begins_to_act_after_the_delay_where_the_robot_is_then():
    robot = vehicle(None)
    robot.locomotion = SimpleNamespace(response=Response(delay=0.15, lag=0.05))
    signals = {"speed": np.array([1.0]), "turn_rate": np.array([0.0])}
    later = robot.when_effective(Observation(10.0, HERE, signals))
    assert (later.t, later.pose) == (pytest.approx(10.2), pytest.approx((1.0, 2.2, HERE.yaw)))
