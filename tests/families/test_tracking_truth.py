"""Movers against truth in the family `crowd`, and none where nothing moves; `-s` prints the figures."""

import numpy as np
import pytest

from .tracking_truth import measure, played

pytestmark = pytest.mark.soak

MOTIONS = ("mixed", "polynomial", "social_force")
CASES = {
    "as measured": {},
    "noise x3": {"noise": 3.0},
    "30 % of the scans lost": {"dropped": 0.3},
    "a pose that drifts": {"drift": (0.003, 0.003, 0.002)},
}


@pytest.fixture(scope="module")
def walks():
    return [played("crowd", 4000 + i, motion=MOTIONS[i % 3]) for i in range(6)]


@pytest.mark.parametrize("case", CASES)
def test_people_are_tracked_as_they_walk(walks, case):
    figures = measure(walks, **CASES[case])
    print(f"{case}: {figures}")
    assert np.mean(figures.position) < 0.03
    assert np.median(figures.velocity) < 0.1
    assert np.mean(figures.latency) < 0.15
    assert figures.missed_share < 0.12
    assert figures.false / figures.scans < 0.02
    assert figures.out_of_view / figures.scans < 0.6


@pytest.mark.parametrize("index", range(4000, 4004))
def test_nothing_moves_among_posts(index):
    walk = played("barn_like", index, duration=8.0)
    walk.people["P"] = dict.fromkeys(range(-1, 400), (99.0, 99.0))
    figures = measure([walk])
    assert figures.scans > 100
    assert figures.false == figures.out_of_view == 0
