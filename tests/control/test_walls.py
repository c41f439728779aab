"""Walls: predicted motion follows what it would run into, stops in corners, and never passes through."""

from itertools import pairwise

import numpy as np
import pytest

from rocs_bt.control.footprint import Footprint
from rocs_bt.control.way_field import WayField
from rocs_bt.knowledge import Movers

TIMES = np.arange(0.2, 3.61, 0.2)
RADIUS = 0.25


def line(a, b):
    a, b = np.array(a), np.array(b)
    return a + np.linspace(0.0, 1.0, int(np.hypot(*(b - a)) / 0.04) + 1)[:, None] * (b - a)


def field(*lines):
    return WayField(np.zeros(2), 6.0, np.vstack([line(*each) for each in lines]), Footprint(0.5, 0.4))


def walk(walls, x, y, vx, vy, times=TIMES):
    return Movers.of(0.0, np.array([[x, y, vx, vy]]), RADIUS).predict(times, walls).positions[0]


WALL = ((-5.0, 1.0), (5.0, 1.0))


@pytest.mark.parametrize("across", [0.3, 0.6, 1.2])
@pytest.mark.parametrize("along", [-0.9, 0.5])
def test_a_mover_that_would_walk_into_a_wall_follows_it(across, along):
    path = walk(field(WALL), 0.2, 0.0, along, across)
    assert path[:, 1].max() == pytest.approx(0.75, abs=0.25)
    assert path[:, 1].max() < 1.0 - RADIUS + 0.06
    assert path[:, 0] == pytest.approx(0.2 + along * TIMES, abs=0.06)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("times", [TIMES, np.linspace(0.0, 3.0, 7)], ids=["near", "far"])
def test_no_prediction_passes_through_a_wall_and_without_one_ahead_nothing_changes(seed, times):
    """Rooms with an inner wall, pillars and doors; movers with any motion, anywhere in them."""
    rng = np.random.default_rng(seed)
    door = rng.uniform(-2.0, 2.0)
    corners = [(-3.0, -3.0), (3.0, -3.0), (3.0, 3.0), (-3.0, 3.0), (-3.0, -3.0)]
    pillar = [(x + 0.1 * dx, y + 0.1 * dy) for x, y in rng.uniform(-2.5, 2.5, (3, 2)) for dx, dy in ((0, 0), (1, 1))]
    lines = [
        *pairwise(corners),
        ((-3.0, 0.0), (door - 0.5, 0.0)),
        ((door + 0.5, 0.0), (3.0, 0.0)),
    ]
    walls = field(*lines, *zip(pillar[::2], pillar[1::2], strict=True))
    at = rng.uniform(-2.7, 2.7, (60, 2))
    at = at[walls.gap(*at.T) > RADIUS]
    n = len(at)
    movers = Movers(
        0.0,
        np.arange(n),
        np.column_stack([at, rng.uniform(-1.6, 1.6, (n, 2))]),
        np.zeros((n, 4, 4)),
        np.full(n, RADIUS),
        np.zeros(n),
        np.ones(n, bool),
        rng.uniform(-1.0, 1.0, n),
        rng.uniform(-2.0, 2.0, (n, 2)),
        rng.uniform(0.8, 1.6, n),
        np.tile([0.4, 0.2, 0.1, 0.3], (n, 1)),
    )
    free, led = movers.predict(times), movers.predict(times, walls)
    assert (led.hypothesis == free.hypothesis).all()
    assert (led.weight == free.weight).all()
    start = at[led.owner]
    fine = np.linspace(0.0, 1.0, 21)[:, None]
    for row in range(len(led)):
        ways = [np.vstack([start[row], p.positions[row]]) for p in (led, free)]
        swept, straight = (np.vstack([a + fine * (b - a) for a, b in pairwise(w)]) for w in ways)
        assert walls.gap(*swept.T).min() > 0.0
        if walls.gap(*straight.T).min() > RADIUS + 0.1:
            assert (led.positions[row] == free.positions[row]).all()
        assert np.hypot(*np.diff(ways[0], axis=0).T).sum() <= np.hypot(*np.diff(ways[1], axis=0).T).sum() + 0.05


def test_without_movers_there_is_nothing_to_lead():
    assert not len(Movers.of(0.0, np.empty((0, 4))).predict(TIMES, field(WALL)))
