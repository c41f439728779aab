"""Points that the leading edge of the hull reaches."""

import math

import numpy as np
import pytest

from rocs_bt.control.arcs import BENDS, HEADINGS, STRAIGHT

from .summit_xl import edges

leading_edges = edges.leading_edges


def test_the_leading_edge_is_the_hulls_front_ahead_and_its_back_behind():
    ahead, back = leading_edges((0.35, 0.25), np.array([0.1, 0.5]))
    assert ahead.shape == back.shape == (len(BENDS), 2, 5, 2)
    assert ahead[STRAIGHT, 1, :, 0] == pytest.approx(np.full(5, 0.85))
    assert back[STRAIGHT, 1, :, 0] == pytest.approx(np.full(5, -0.85))
    assert sorted(ahead[STRAIGHT, 0, :, 1].tolist()) == pytest.approx([-0.25, -0.125, 0.0, 0.125, 0.25])
    left = ahead[-1, 1, 2]
    assert math.atan2(left[1], left[0]) > 0.1  # the last bend is to the left


def test_after_a_turn_the_leading_edge_is_straight_on_from_there():
    (east,) = edges.turned_edges((0.35, 0.25), np.array([0.5]))[HEADINGS.tolist().index(0.0)]
    (west,) = edges.turned_edges((0.35, 0.25), np.array([0.5]))[0]
    assert east[:, 0] == pytest.approx(np.full(5, 0.85))
    assert west == pytest.approx(-east)
