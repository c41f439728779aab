"""Vehicle: gaps to what moves, where it will be."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from rocs_bt.geometry import Pose2
from rocs_bt.knowledge import Movers, OccupancyGrid
from rocs_bt.plan import Vehicle

HERE = Pose2(1.0, 2.0, np.pi / 2.0)  # heading north
TIMES = np.array([10.0, 11.0, 12.0])
STAYING = np.zeros((1, 3, 3))


def vehicle(movers, *, predicts=True):
    """Robot of 1 m x 0.5 m among movers, without a static obstacle."""
    world = SimpleNamespace(movers=movers, occupancy=OccupancyGrid(0.05, 10.0))
    graph = SimpleNamespace(attributes=lambda name: {"length": 1.0, "width": 0.5})
    knowledge = SimpleNamespace(world=world, graph=graph, agent="R")
    goal = {"goal": HERE}
    return Vehicle(
        SimpleNamespace(goals=goal, tolerances={"goal": 0.1}, locomotion=None, knowledge=knowledge), movers=predicts
    )


def coming():
    """A mover 3 m ahead of the robot that comes at 1 m/s."""
    return Movers.of(10.0, np.array([[1.0, 5.0, 0.0, -1.0]]), 0.25)


def test_a_staying_robot_is_reached_by_a_mover_that_comes():
    gaps = vehicle(coming()).clearances(HERE, 5.0, STAYING, TIMES)
    assert gaps == pytest.approx(np.array([[2.25, 1.25, 0.25]]))


def test_poses_are_of_the_body_frame_and_each_has_its_own_time():
    aside = STAYING + np.array([0.0, 1.0, 0.0])  # 1 m to the left, which is west
    gaps = vehicle(coming()).clearances(HERE, 5.0, aside, TIMES)
    assert gaps == pytest.approx(np.hypot(0.75, [2.5, 1.5, 0.5])[None] - 0.25)


def test_an_improbable_hypothesis_does_not_count_and_uncertainty_takes_of_the_gap():
    known = coming()
    belief = np.array([[0.95, 0.0, 0.05, 0.0]])
    unsure = dataclasses.replace(known, belief=belief, covariance=np.diag([0.01, 0.01, 0.0, 0.0])[None])
    gaps = vehicle(unsure).clearances(HERE, 5.0, STAYING, TIMES)
    assert gaps == pytest.approx(np.array([[2.15, 1.15, 0.15]]))


@pytest.mark.parametrize(
    "robot", [vehicle(coming(), predicts=False), vehicle(None), vehicle(Movers.of(0.0, np.zeros((0, 4))))]
)
def test_without_tracked_movers_nothing_is_near(robot):
    assert np.isinf(robot.clearances(HERE, 5.0, STAYING, TIMES)).all()
    assert np.isinf(vehicle(coming()).clearances(HERE, 5.0, STAYING)).all()
