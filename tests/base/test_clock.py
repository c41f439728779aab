"""Clocks and rates."""

import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.base.clock import Rate, SimulatedClock, WallClock
from rocs_bt.base.errors import RateError


def test_simulated_time_does_not_drift():
    clock = SimulatedClock(0.05)
    for _ in range(100_000):
        clock.advance()
    assert clock.now() == 100_000 * 0.05


@given(st.integers(1, 1000), st.sampled_from([0.001, 0.002, 0.005, 0.05]))
def test_a_rate_that_divides_is_found(every, step):
    rate = Rate.dividing(1.0 / (every * step), step, "this rate")
    assert rate.every == every
    assert [k for k in range(3 * every) if rate.due(k)] == [0, every, 2 * every]


def test_a_rate_that_does_not_divide_names_the_nearest_that_do():
    with pytest.raises(RateError) as error:
        Rate.dividing(30.0, 0.005, "the control rate")
    assert "the control rate of 30 Hz is 6.667 steps of 0.005 s" in str(error.value)
    assert "Use 28.5714 Hz or 33.3333 Hz" in str(error.value)


@pytest.mark.parametrize("hz", [0.0, -5.0, float("nan"), 1000.0])
def test_a_rate_that_cannot_be_is_refused(hz):
    with pytest.raises(RateError):
        Rate.dividing(hz, 0.005, "this rate")


def test_the_wall_clock_wakes_early_when_it_is_told_to_stop():
    clock, stop = WallClock(), threading.Event()
    threading.Timer(0.02, stop.set).start()
    assert clock.wait_until(clock.now() + 60.0, stop) is False
    assert clock.now() < 30.0
