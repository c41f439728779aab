"""`navigate` drives through a gap that is 0.25 m wider than the hull, on every body with a scanner."""

import pytest

from .gap_campaign import through_a_gap

ROBOTS = ("humanoid", "jackal", "quadruped", "rosbot_xl", "turtlebot3_burger")


@pytest.mark.parametrize(("robot", "scene"), [("jackal", 3), ("turtlebot3_burger", 1), ("rosbot_xl", 2)])
def test_it_drives_through_a_gap(robot, scene):
    found = through_a_gap(robot, scene)
    assert found.outcome == "success", found.reason


@pytest.mark.soak
def test_it_drives_through_nineteen_gaps_of_twenty_on_each_of_five_robots():
    found = {robot: [through_a_gap(robot, scene).outcome for scene in range(20)] for robot in ROBOTS}
    assert sum(outcomes.count("success") for outcomes in found.values()) >= 95, found
