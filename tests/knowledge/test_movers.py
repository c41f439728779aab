"""Movers: what is predicted of them, against stepping each hypothesis and against samples of the covariance."""

import numpy as np
import pytest

from rocs_bt.knowledge import HYPOTHESES, Movers

TIMES = 5.0 + np.linspace(0.0, 3.0, 7)


def sampled(seed, n=5):
    rng = np.random.default_rng(seed)
    roots = rng.normal(0.0, (0.05, 0.05, 0.1, 0.1), (n, 4, 4)).transpose(0, 2, 1)
    belief = rng.dirichlet(np.ones(4), n)
    mean, turn = rng.uniform(-1.5, 1.5, (n, 4)), rng.uniform(-1.0, 1.0, n)
    return Movers(
        t=5.0,
        ids=np.arange(n) + 7,
        mean=mean,
        covariance=roots @ roots.transpose(0, 2, 1),
        radius=rng.uniform(0.1, 0.4, n),
        seen=np.full(n, 5.0),
        moves=rng.random(n) < 0.8,
        turn_rate=turn,
        acceleration=np.where(np.arange(n)[:, None] % 2, rng.uniform(-2.0, 2.0, (n, 2)), 0.0),
        top=rng.uniform(0.5, 1.5, n),
        belief=belief,
    )


def stepped(mean, turn_rate, acceleration, top, until, step=1e-3):
    """Position after a time at a constant speed and turn rate, or at a constant acceleration up to a speed."""
    (x, y, vx, vy), angle = mean, turn_rate * step
    size = np.hypot(*acceleration)
    for _ in range(round(until / step)):
        if size and (vx * acceleration[0] + vy * acceleration[1]) / size < top:
            vx, vy = vx + step * acceleration[0], vy + step * acceleration[1]
        vx, vy = vx * np.cos(angle) - vy * np.sin(angle), vx * np.sin(angle) + vy * np.cos(angle)
        x, y = x + vx * step, y + vy * step
    return x, y


@pytest.mark.parametrize("seed", range(3))
def test_each_row_goes_where_its_hypothesis_leads(seed):
    movers = sampled(seed)
    prediction = movers.predict(TIMES)
    for row in range(len(prediction)):
        i = movers.ids.tolist().index(prediction.owner[row])
        which = HYPOTHESES[prediction.hypothesis[row]]
        mean = np.where([1, 1, which != "stops", which != "stops"], movers.mean[i], 0.0)
        turn = movers.turn_rate[i] if which == "turns" else 0.0
        change = movers.acceleration[i] if which == "changes speed" else np.zeros(2)
        assert prediction.radius[row] == movers.radius[i]
        for k in (0, 3, 6):
            expected = stepped(mean, turn, change, movers.top[i], TIMES[k] - 5.0)
            assert prediction.positions[row, k] == pytest.approx(expected, abs=5e-3)


@pytest.mark.parametrize("seed", range(5))
def test_the_weights_of_a_mover_add_up_to_one_and_who_stands_only_stays(seed):
    movers = sampled(seed)
    prediction = movers.predict(TIMES)
    for i, number in enumerate(movers.ids):
        rows = prediction.owner == number
        assert prediction.weight[rows].sum() == pytest.approx(1.0)
        if not movers.moves[i] and not movers.acceleration[i].any():
            assert [HYPOTHESES[h] for h in prediction.hypothesis[rows]] == ["stops"]


def test_a_margin_is_the_standard_deviation_of_the_worst_direction():
    movers, rng = sampled(1), np.random.default_rng(2)
    prediction = movers.predict([5.0, 5.5])
    for row in np.flatnonzero(prediction.hypothesis == 0):
        i = movers.ids.tolist().index(prediction.owner[row])
        states = rng.multivariate_normal(movers.mean[i], movers.covariance[i], 20000)
        for k, ahead in enumerate((0.0, 0.5)):
            worst = np.sqrt(np.linalg.eigvalsh(np.cov((states[:, :2] + ahead * states[:, 2:]).T)).max())
            assert prediction.margin[row, k] == pytest.approx(min(worst, 0.4), rel=0.04)


def test_the_estimates_cannot_be_changed():
    movers = sampled(1)
    with pytest.raises(ValueError, match="read-only"):
        movers.mean[0, 0] = 1.0


def test_what_is_known_exactly_goes_on():
    prediction = Movers.of(1.0, np.array([[0.0, 1.0, 0.5, 0.0], [2.0, 2.0, 0.0, 0.0]])).predict([2.0, 4.0])
    assert prediction.positions[:, 1].tolist() == [[1.5, 1.0], [2.0, 2.0]]
    assert prediction.weight.tolist() == [1.0, 1.0]
    assert prediction.margin.tolist() == [[0.0, 0.0]] * 2
