"""MotionBelief: which hypothesis wins for a walk of each kind, and how fast a mover turns."""

import math

import numpy as np
import pytest

from rocs_bt.control.prediction import HYPOTHESES
from rocs_bt.control.tracking import MotionBelief


def walked(speed, turn_rate, braking=0.0, steps=30, noise=0.01, seed=1):
    """Beliefs about one mover after a walk of so many control periods; it brakes in the last 0.5 s."""
    rng, belief, heading, at = np.random.default_rng(seed), MotionBelief(), 0.3, np.array([1.0, 2.0])
    for k in range(steps):
        speed = max(speed - 0.05 * braking * (k >= steps - 10), 0.0)
        heading += 0.05 * turn_rate
        velocity = speed * np.array([math.cos(heading), math.sin(heading)])
        at = at + 0.05 * velocity
        mean = np.concatenate([at, velocity]) + rng.normal(0.0, [noise, noise, 3.0 * noise, 3.0 * noise])
        rates, shares = belief.update(0.05 * k, np.array([7]), mean[None])
    return rates[0], shares[0]


@pytest.mark.parametrize("seed", range(3))
def test_a_hypothesis_gains_by_predicting_well(seed):
    straight, turning = walked(1.0, 0.0, seed=seed)[1], walked(1.2, 1.2, seed=seed)[1]
    stopping = walked(1.0, 0.0, braking=4.0, seed=seed)[1]
    assert HYPOTHESES[int(straight.argmax())] == "goes on"
    assert turning[1] / turning[0] > 1.1 * straight[1] / straight[0]
    assert stopping[2] > 1.5 * straight[2]


@pytest.mark.parametrize("rate", [-1.2, -0.5, 0.0, 0.8])
def test_a_turn_rate_is_measured(rate):
    assert walked(1.0, rate)[0] == pytest.approx(rate, abs=0.2)


def test_movers_come_and_go_and_their_probabilities_add_up_to_one():
    rng, belief = np.random.default_rng(2), MotionBelief()
    for k in range(60):
        ids = np.flatnonzero(rng.random(9) < 0.7) + 1
        rates, shares = belief.update(0.05 * k, ids, rng.uniform(-2.0, 2.0, (len(ids), 4)))
        assert rates.shape == (len(ids),)
        assert shares.shape == (len(ids), len(HYPOTHESES))
        assert shares.sum(axis=1) == pytest.approx(1.0)
        assert (shares >= 0.1 - 1e-12).all()
        assert np.isfinite(rates).all()


def test_after_a_gap_in_the_scans_nothing_is_concluded():
    belief = MotionBelief()
    belief.update(0.0, np.array([1]), np.array([[0.0, 0.0, 1.0, 0.0]]))
    rates, shares = belief.update(5.0, np.array([1]), np.array([[3.0, 0.0, 0.0, 1.0]]))
    assert rates.tolist() == [0.0]
    assert HYPOTHESES[int(shares[0].argmax())] == "goes on"
