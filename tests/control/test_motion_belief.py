"""MotionBelief: which hypothesis wins for a walk of each kind, and how fast a mover turns."""

import math

import numpy as np
import pytest

from rocs_bt.control.prediction import HYPOTHESES, accelerated
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
        motion = belief.update(0.05 * k, np.array([7]), mean[None])
    return motion.turn_rate[0], motion.belief[0]


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
        motion = belief.update(0.05 * k, ids, rng.uniform(-2.0, 2.0, (len(ids), 4)))
        rates, shares = motion.turn_rate, motion.belief
        assert rates.shape == (len(ids),)
        assert shares.shape == (len(ids), len(HYPOTHESES))
        assert shares.sum(axis=1) == pytest.approx(1.0)
        assert (shares[:, :3] >= 0.1 - 1e-12).all()
        assert ((shares[:, 3] > 0.0) == motion.acceleration.any(axis=1)).all()
        assert np.isfinite(rates).all()


def test_after_a_gap_in_the_scans_nothing_is_concluded():
    belief = MotionBelief()
    belief.update(0.0, np.array([1]), np.array([[0.0, 0.0, 1.0, 0.0]]))
    motion = belief.update(5.0, np.array([1]), np.array([[3.0, 0.0, 0.0, 1.0]]))
    assert motion.turn_rate.tolist() == [0.0]
    assert not motion.acceleration.any()
    assert HYPOTHESES[int(motion.belief[0].argmax())] == "goes on"


@pytest.mark.parametrize("seed", range(3))
def test_who_turns_back_is_expected_to_come_back(seed):
    """As scripted people do it: from full speed to full speed in the other direction within 0.8 s."""
    rng, belief, at, speed = np.random.default_rng(seed), MotionBelief(), np.array([0.0, 0.0]), 1.0
    for k in range(29):
        speed = max(speed - 0.125 * (k >= 20), -1.0)  # 0.45 s of the turn: it goes back at -0.125 m/s
        at = at + 0.05 * np.array([speed, 0.0])
        mean = np.concatenate([at, [speed, 0.0]]) + rng.normal(0.0, 0.02, 4)
        motion = belief.update(0.05 * k, np.array([7]), mean[None])
    assert motion.belief[0, HYPOTHESES.index("changes speed")] > 0.3
    ahead = accelerated(mean[None, 2:], motion.acceleration, motion.top, np.array([1.0]))
    assert ahead[0, 0] == pytest.approx([-0.125 * 0.35 - 0.5 * 2.5 * 0.35**2 - 0.65, 0.0], abs=0.25)


@pytest.mark.parametrize(("v", "a", "top"), [(1.0, -2.0, 1.0), (0.2, 1.5, 0.9), (-0.4, -1.0, 0.8), (0.7, 0.0, 0.7)])
def test_an_acceleration_ends_at_the_top_speed(v, a, top):
    """Against steps of a millisecond."""
    times, x, speed, found = np.linspace(0.0, 3.0, 7), 0.0, v, []
    for step in range(3001):
        if step % 500 == 0:
            found.append(x)
        x += 1e-3 * speed
        limit = math.copysign(top, a)
        speed = speed if (speed - limit) * a >= 0.0 else speed + 1e-3 * a
    moved = accelerated(np.array([[v, 0.0]]), np.array([[a, 0.0]]), np.array([top]), times)
    assert moved[0, :, 0] == pytest.approx(np.array(found), abs=5e-3)
    assert not moved[0, :, 1].any()
