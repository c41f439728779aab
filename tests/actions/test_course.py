"""Where a peer is headed."""

import numpy as np
import pytest

from rocs_bt.actions.course import Course
from rocs_bt.base.geometry import Pose2, Twist2

TIMES = np.array([0.0, 1.0, 5.0])


def watched(places, begin=0.0, course=None):
    """A course of places that are noted 20 times a second from a time on [s]."""
    course = course or Course()
    for i, (x, y) in enumerate(places):
        course.note(begin + 0.05 * i, Pose2(x, y, 2.0))  # where it looks does not count
    return course


def test_it_goes_on_as_it_went_whatever_it_turns():
    course = watched([(0.02 * i, -0.01 * i) for i in range(21)])
    there = course.ahead(Twist2(0.7, 1.5), TIMES)
    assert there[:, :2] == pytest.approx(np.array([(0.4 + 0.4 * t, -0.2 - 0.2 * t) for t in TIMES]))


def test_only_the_last_second_counts():
    course = watched([(1.0, 1.0)] * 40 + [(1.0 + 0.02 * i, 1.0) for i in range(21)])
    assert course.ahead(Twist2(0.0), TIMES)[2, :2] == pytest.approx((3.4, 1.0))


@pytest.mark.parametrize("count", [1, 5])
def test_until_it_has_been_watched_its_speed_and_heading_count(count):
    course = watched([(0.5, 0.0)] * count)
    assert course.ahead(Twist2(0.4), TIMES)[1, :2] == pytest.approx((0.5 + 0.4 * np.cos(2.0), 0.4 * np.sin(2.0)))


def test_after_a_gap_it_is_watched_anew():
    course = watched([(0.02 * i, 0.0) for i in range(21)])
    watched([(1.6, 0.0)] * 10, begin=4.0, course=course)
    assert course.ahead(Twist2(0.0), TIMES)[:, :2] == pytest.approx(np.array([(1.6, 0.0)] * 3))
