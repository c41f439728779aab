"""The ways on which a robot asks how much ground is free."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.control.arcs import BENDS, STRAIGHT, along, leading_edges, sinc
from rocs_bt.geometry import Pose2, Twist2, arc

number = st.floats(-2.0, 2.0)


@given(st.lists(st.tuples(number, number, number, number, number, number), min_size=1, max_size=3))
def test_along_is_the_arc_of_geometry(numbers):
    motions, whiles = [(Pose2(*each[:3]), Twist2(*each[3:])) for each in numbers], np.linspace(0.0, 2.5, 6)
    durations = np.array([whiles + i for i in range(len(motions))])
    for (pose, twist), lasting, found in zip(motions, durations, along(motions, durations), strict=True):
        want = np.array(arc(pose, twist, lasting.tolist()))
        # Below 1e-9 rad geometry takes an arc for straight: off by half of that of the way, which is 13 m at most here.
        assert found[:, :2] == pytest.approx(want[:, :2], abs=7e-9)
        assert np.cos(found[:, 2] - want[:, 2]) == pytest.approx(np.ones(6))


@given(st.lists(st.floats(-5.0, 5.0), min_size=1))
def test_sinc_is_numpys_to_the_bit(numbers):
    assert sinc(np.array(numbers)).tolist() == np.sinc(numbers).tolist()


def test_the_leading_edge_is_the_hulls_front_ahead_and_its_back_behind():
    ahead, back = leading_edges((0.35, 0.25), np.array([0.1, 0.5]))
    assert ahead.shape == back.shape == (len(BENDS), 2, 5, 2)
    assert ahead[STRAIGHT, 1, :, 0] == pytest.approx(np.full(5, 0.85))
    assert back[STRAIGHT, 1, :, 0] == pytest.approx(np.full(5, -0.85))
    assert sorted(ahead[STRAIGHT, 0, :, 1].tolist()) == pytest.approx([-0.25, -0.125, 0.0, 0.125, 0.25])
    left = ahead[-1, 1, 2]
    assert math.atan2(left[1], left[0]) > 0.1  # the last bend is to the left
