"""The ways on which a robot asks how much ground is free."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.base.geometry import Pose2, Twist2, arc
from rocs_bt.control.arcs import along, sinc

number = st.floats(-2.0, 2.0)


@given(st.lists(st.tuples(number, number, number, number, number, number), min_size=1, max_size=3))
def test_along_is_the_arc_of_geometry(numbers):
    motions, whiles = [(Pose2(*each[:3]), Twist2(*each[3:])) for each in numbers], np.linspace(0.0, 2.5, 6)
    durations = np.array([whiles + i for i in range(len(motions))])
    for (pose, twist), lasting, found in zip(motions, durations, along(motions, durations), strict=True):
        want = np.array(arc(pose, twist, lasting.tolist()))
        # Near 1e-8 rad, (1 - cos(a)) / a of geometry is off by up to 5.3e-9: half a unit in the last place, over a.
        # The robot drives at most 12.8 m here.
        assert found[:, :2] == pytest.approx(want[:, :2], abs=5.3e-9 * 12.8)
        assert np.cos(found[:, 2] - want[:, 2]) == pytest.approx(np.ones(6))


@given(st.lists(st.floats(-5.0, 5.0), min_size=1))
def test_sinc_is_numpys_to_the_bit(numbers):
    assert sinc(np.array(numbers)).tolist() == np.sinc(numbers).tolist()
