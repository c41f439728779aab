from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.base.errors import InputError
from rocs_bt.control.axis import AxisLimits

TIMES = 0.1 * np.arange(1, 101)
axes = st.builds(AxisLimits, st.floats(0.1, 3.0), st.floats(0.2, 6.0))


@given(axes, st.floats(-6.0, 6.0), st.floats(-1.0, 1.0), st.lists(st.floats(-3.0, 3.0), min_size=101, max_size=101))
def test_a_track_keeps_its_limits_and_is_the_integral_of_its_rates(
    axis: AxisLimits, position: float, share: float, targets: list[float]
) -> None:
    rate = share * axis.max_speed
    positions, rates = axis.track(np.array(targets), TIMES, position, rate)
    whole = np.concatenate([[rate], rates])
    assert np.abs(rates).max() <= axis.max_speed + 1e-9
    assert np.abs(np.diff(whole)).max() <= axis.max_acceleration * 0.1 + 1e-9
    moved = np.cumsum(0.5 * (whole[1:] + whole[:-1]) * 0.1)
    np.testing.assert_allclose(positions, position + moved, atol=1e-9)


@given(axes, st.floats(-2.0, 2.0))
def test_from_rest_a_target_is_reached_in_the_time_of_a_trapezoid_and_not_passed(
    axis: AxisLimits, target: float
) -> None:
    positions, rates = axis.track(np.full(101, target), TIMES, 0.0, 0.0)
    peak = min(axis.max_speed, math.sqrt(axis.max_acceleration * abs(target)))
    ideal = (
        abs(target) / axis.max_speed + axis.max_speed / axis.max_acceleration
        if peak == axis.max_speed
        else 2 * peak / axis.max_acceleration
    )
    passed = 0.07 * axis.max_acceleration * 0.1**2  # of the last step, which is not a whole one
    assert (np.abs(positions) <= abs(target) + passed).all()
    later = ideal + 0.5 <= TIMES  # the trapezoid, rounded up to whole steps
    np.testing.assert_allclose(positions[later], target, atol=0.01 * abs(target) + 1e-6)
    assert abs(rates[-1]) <= 1e-6 or ideal > 9.0


@given(st.floats(-0.5, 0.5), st.floats(-1.0, 1.0), st.floats(-0.5, 0.5))
def test_a_target_that_moves_evenly_is_followed_without_lag(speed: float, start: float, rate: float) -> None:
    times = np.concatenate([[0.0], TIMES])
    positions, rates = AxisLimits(1.5, 2.0).track(start + speed * times, TIMES, 0.0, rate)
    np.testing.assert_allclose(positions[50:], start + speed * TIMES[50:], atol=1e-6)
    np.testing.assert_allclose(rates[50:], speed, atol=1e-6)


@pytest.mark.parametrize("lag", [0.1, 0.3])
@pytest.mark.parametrize("target", [0.05, 1.0, -2.0])
def test_a_lagging_body_settles_without_overshoot(lag: float, target: float) -> None:
    axis, period, height, climb, command = AxisLimits(0.5, 0.8), 0.05, 0.0, 0.0, 0.0
    heights = []
    for _ in range(400):
        command = axis.step(target - height - lag * climb, command, period, settling=3.0 * lag)
        decay = math.exp(-period / lag)
        height += command * period + (climb - command) * lag * (1.0 - decay)
        climb = command + (climb - command) * decay
        heights.append(height * math.copysign(1.0, target))
    assert max(heights) <= abs(target) + 0.02
    assert heights[-1] == pytest.approx(abs(target), abs=1e-3)


@pytest.mark.parametrize("limits", [(0.0, 1.0), (1.0, -1.0), (math.nan, 1.0), (1.0, math.inf)])
def test_limits_that_are_none_are_refused(limits: tuple[float, float]) -> None:
    with pytest.raises(InputError, match="of an axis"):
        AxisLimits(*limits)
