"""No interval has the width zero: equal values, and values at the end of their range, say little of other episodes."""

import math

import numpy as np
import pytest

from rocs_bt.compare.comparison import Comparison
from rocs_bt.compare.metric import METRICS, ZERO_ON_FAILURE
from rocs_bt.compare.record import EpisodeRecord
from rocs_bt.compare.report.tables import everything, middle, text
from rocs_bt.compare.statistics import bootstrapped, mean_over_scenes, rate, widened

LIMIT = 60.0  # [s]
SHARES = ("spl", "path_efficiency", "intimate", "personal", "reflex_share", "holds safe")
BOUNDED = ("success", "collision", "fell", "clean", "untouched", "barn2022", "barn2024", "time", *SHARES)


def record(planner, scene, seed, success=True, **metrics):
    outcome = "success" if success else "failed"
    values = dict.fromkeys(METRICS, 0.25) | {"success": float(success), "clean": float(success), "holds safe": 1.0}
    values |= {"collision": 0.0, "fell": 0.0, "spl": float(success), "time": 20.0 if success else LIMIT}
    if not success:
        values |= dict.fromkeys(ZERO_ON_FAILURE, 0.0)
    return EpisodeRecord(
        key=f"{planner}{scene}{seed}",
        planner=planner,
        family="f",
        scene=scene,
        seed=seed,
        outcome=outcome,
        metrics=values | metrics,
        time_limit=LIMIT,
        sim_time=20.0,
    )


def compared(success, scenes, seeds, noise=0.0):
    rng = np.random.default_rng(1)

    def measured():
        near = 1.0 - noise * float(rng.uniform())
        return {"spl": near, "time": 20.0 / near, "barn2022": 0.25 * near, "barn2024": 0.5 * near} if success else {}

    return Comparison(
        record("p", f"s{k}", seed, success, **measured()) for k in range(scenes) for seed in range(1, seeds + 1)
    )


@pytest.mark.parametrize(("scenes", "seeds"), [(30, 1), (1, 30), (10, 3), (2, 1)])
@pytest.mark.parametrize("success", [True, False])
def test_equal_values_have_a_wide_interval_or_none(success, scenes, seeds):
    comparison = compared(success, scenes, seeds)
    for name in [*METRICS, "holds safe"]:
        found = comparison.estimate("p", name)
        if name in BOUNDED:
            assert 0.0 <= found.low <= found.value <= found.high, name
            assert found.high - found.low > 0.05 * max(found.value, 0.05), name
        else:
            assert math.isnan(found.low), name
            assert "(" not in text(found, METRICS[name])
    assert not [cell for _, _, cells in everything(comparison) for cell in cells if _flat(cell)]
    assert not _flat(middle(comparison)[0])


def _flat(cell):
    ends = cell.partition("(")[2].rstrip(")").split(" to ")
    return len(ends) == 2 and ends[0] == ends[1]


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_what_failures_would_do_to_a_mean_is_as_uncertain_as_whether_there_are_any(noise):
    comparison = compared(True, 30, 1, noise)
    least = comparison.estimate("p", "success").low
    assert least == pytest.approx(0.878, abs=0.002)
    for name in ("spl", "barn2022", "barn2024"):
        found = comparison.estimate("p", name)
        assert found.low == pytest.approx(least * found.value, rel=0.02), name
    time = comparison.estimate("p", "time")
    assert time.high == pytest.approx(least * time.value + (1.0 - least) * LIMIT, rel=0.02)
    if noise:
        assert time.low == pytest.approx(time.value, rel=0.02)


def test_one_failure_gives_no_narrower_interval_than_none():
    records = [record("p", f"s{k}", 1, k > 0) for k in range(30)]
    some, none = Comparison(records).estimate("p", "spl"), compared(True, 30, 1).estimate("p", "spl")
    assert some.low < none.low + 0.03


@pytest.mark.parametrize("p", [0.9, 0.97])
@pytest.mark.parametrize("scenes", [20, 50])
def test_the_interval_of_a_mean_with_rare_failures_holds_it(p, scenes):
    rng, held, plain = np.random.default_rng(2), 0, 0
    for _ in range(400):
        values = rng.uniform(0.9, 1.0, (scenes, 1)) * (rng.uniform(size=(scenes, 1)) < p)
        unseen = (0.0,) if values.min() > 0.0 else ()
        found, student = mean_over_scenes(values, unseen=unseen), mean_over_scenes(values)
        held += found.low <= 0.95 * p <= found.high
        plain += student.low <= 0.95 * p <= student.high
    assert held >= 0.92 * 400
    assert plain <= held


def test_bootstraps_of_equal_values_are_no_interval():
    assert math.isnan(bootstrapped(np.full((9, 1), 0.1), lambda values: float(values.mean())).low)


def test_the_band_of_a_curve_is_that_of_a_rate_where_all_episodes_agree():
    episodes, ones = np.ones((30, 1)), np.ones(3)
    low, high = widened(episodes, np.array([0.0, 0.5, 1.0]), np.array([0.0, 0.3, 1.0]), np.array([0.0, 0.7, 1.0]))
    assert low == pytest.approx([0.0, 0.3, rate(episodes).low])
    assert high == pytest.approx([1.0 - rate(episodes).low, 0.7, 1.0])
    assert (high - low > 0.1 * ones).all()
