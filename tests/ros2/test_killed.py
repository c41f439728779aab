"""Agents killed or stopped at random moments: the robot is commanded zero in time, by the stamps of its commands."""

from __future__ import annotations

from contextlib import closing
from functools import partial

import pytest

from rocs_bt.drivers.ros2.connect import open_transport
from rocs_bt.drivers.ros2.settings import Ros2Settings

from .killed import (
    BRAKING,
    OWN_TIMEOUT,
    SOON,
    both_killed,
    driven,
    killed,
    moments,
    paused,
    publisher_killed,
    publisher_stopped,
    report,
    shortest,
)
from .transport_contract import until


@pytest.fixture
def robots(counterpart, request):
    return partial(driven, counterpart, transport="dds", real_time=request.config.getoption("--real-time"))


@pytest.mark.parametrize("seed", [1, 2])
def test_zero_is_published_in_time(robots, tmp_path, seed):
    """Two random moments: the agent is stopped and goes on, and is killed."""
    faults = list(zip(moments(seed, 2), (paused, killed), strict=True))

    def attempt(number: int) -> float:
        took = []
        with robots(tmp_path / str(number)) as robot:
            for moment, fault in faults:
                robot.drive(moment / 3.0)
                took.append(fault(robot)[1])
        return max(took)

    assert shortest(attempt, SOON) <= SOON


@pytest.mark.parametrize("fault", [publisher_killed, publisher_stopped])
def test_without_the_publisher_the_agent_publishes_zero(robots, tmp_path, fault):
    def attempt(number: int) -> float:
        with robots(tmp_path / str(number)) as robot:
            robot.drive(0.5)
            return fault(robot)[1]

    assert shortest(attempt, SOON) <= SOON


def test_without_agent_and_publisher_the_robot_stops_by_its_own_timeout(robots, tmp_path):
    def attempt(number: int) -> float:
        with robots(tmp_path / str(number)) as robot:
            robot.drive(0.5)
            return both_killed(robot)[1]

    limit = OWN_TIMEOUT + BRAKING
    assert shortest(attempt, limit) <= limit


def test_each_process_has_a_node_name_of_its_own(robots, tmp_path):
    both = {"/r1/rocs_bt", "/r1/rocs_bt_wheels"}
    with closing(open_transport(Ros2Settings(transport="dds"), "observer")) as observer, robots(tmp_path):
        until(lambda: both <= {endpoint.node for endpoint in observer.endpoints()})


@pytest.mark.soak
def test_twenty_five_times_killed(robots, tmp_path):
    took = []
    for count, moment in enumerate(moments(3, 25)):
        with robots(tmp_path / str(count)) as robot:
            robot.drive(moment)
            took.append(killed(robot))
    report("killed", took, SOON)


@pytest.mark.soak
def test_twenty_five_times_stopped(robots, tmp_path):
    took = []
    for count in range(5):
        with robots(tmp_path / str(count)) as robot:
            for moment in moments(count, 5):
                robot.drive(moment / 6.0)
                took.append(paused(robot))
    report("stopped", took, SOON)
