"""Statistics of scenes and seeds: against published numbers, scipy, exact enumeration, and examples done by hand."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import CensoredData, beta, binom, binomtest, ecdf, permutation_test, trim_mean, ttest_1samp

from benchmarks.paper.estimates import share
from rocs_bt.compare.statistics import (
    bootstrapped,
    cluster_bootstrap,
    cumulative_incidence,
    holm,
    interquartile_mean,
    lower_bound,
    mean_difference,
    mean_over_scenes,
    paired,
    performance_profile,
    rate,
    sample_size,
    scene_means,
    scenes_needed,
    sign_flip_test,
    superiority,
    upper_bound,
)

from . import dwa

SUCCESS = dwa.by_world(lambda cause, t: cause == 1)
TIMES = np.array([min(t, 100.0) for _, _, t in dwa.RUNS])
ENDS = np.array([cause for _, cause, _ in dwa.RUNS])
rng = np.random.default_rng


def test_500_published_episodes_are_worth_108():
    size = sample_size(SUCCESS)
    assert (size.scenes, size.episodes) == (50, 500)
    assert size.design_effect == pytest.approx(4.65, abs=0.02)
    assert size.effective == pytest.approx(108, abs=1)


def test_their_success_rate_and_its_intervals_are_the_published_ones():
    assert share(425, 500).low == pytest.approx(0.816, abs=1e-3)  # as if seeds were scenes
    assert share(425, 500).high == pytest.approx(0.880, abs=1e-3)
    found = bootstrapped(SUCCESS, np.mean)
    assert found.value == 0.85
    assert (found.low, found.high) == pytest.approx((0.780, 0.912), abs=4e-3)
    score = rate(SUCCESS)
    assert score.low < found.low < 0.816 < 0.880 < score.high


def test_the_mean_over_successes_flatters():
    assert TIMES[ENDS == 1].mean() == pytest.approx(33.1, abs=0.05)
    restricted = dwa.by_world(lambda cause, t: t if cause == 1 else 100.0)
    assert restricted.mean() == pytest.approx(43.2, abs=0.05)


def test_seeds_that_all_agree_are_one_and_seeds_that_know_nothing_of_each_other_are_many():
    alike = np.repeat(rng(2).integers(0, 2, (40, 1)), 5, axis=1).astype(float)
    assert sample_size(alike).effective == pytest.approx(40, rel=0.03)
    assert sample_size(alike).intraclass_correlation == pytest.approx(1.0, abs=0.01)
    strangers = rng(3).integers(0, 2, (2000, 5)).astype(float)
    assert sample_size(strangers).effective == pytest.approx(10_000, rel=0.06)


def test_what_is_not_known_is_left_out():
    values = np.array([[1.0, np.nan], [np.nan, np.nan], [0.0, 1.0]])
    assert scene_means(values).tolist() == [1.0, 0.5]
    size = sample_size(values)
    assert (size.scenes, size.episodes) == (2, 3)
    assert math.isnan(rate(np.full((4, 2), np.nan)).value)
    assert math.isnan(mean_over_scenes(np.ones((1, 3))).low)


def test_with_single_seeds_a_rate_has_wilsons_interval_with_students_quantile():
    from scipy.stats import binomtest, t

    values = np.array([[1.0]] * 80 + [[0.0]] * 20)
    found = rate(values)
    level = 2.0 * (1.0 - binom_tail(t.ppf(0.975, 99)))
    wilson = binomtest(80, 100).proportion_ci(1.0 - level, method="wilson")
    assert (found.low, found.high) == pytest.approx((wilson.low, wilson.high), abs=1e-3)


def binom_tail(quantile):
    from scipy.stats import norm

    return norm.cdf(quantile)


def test_nothing_in_a_hundred_scenes_is_at_most_three_percent_however_many_seeds():
    assert upper_bound(np.zeros((100, 1))) == pytest.approx(share(0, 100).high, abs=0.01)
    assert upper_bound(np.zeros((100, 1))) == pytest.approx(1.0 - 0.05 ** (1 / 100))
    assert upper_bound(np.zeros((100, 9))) == upper_bound(np.zeros((100, 1)))
    assert lower_bound(np.ones((100, 3))) == pytest.approx(0.05 ** (1 / 100))
    assert upper_bound(np.ones((5, 2))) == 1.0
    assert upper_bound(np.zeros((0, 2))) == 1.0


def chances(weights, n):
    """The distribution of the sum of n scenes, counted in k-ths."""
    found = np.ones(1)
    for _ in range(n):
        found = np.convolve(found, weights)
    return found


@pytest.mark.parametrize("n", [5, 12, 30])
def test_a_bound_holds_for_every_way_in_which_three_seeds_can_be_alike(n):
    """Enumerated: all distributions of a scene's count 0..3 on a grid, and how often the bound lies below the truth."""
    bounds = beta.ppf(0.95, np.arange(3 * n + 1) / 3 + 1.0, np.maximum(n - np.arange(3 * n + 1) / 3, 1e-9))
    worst = 0.0
    for parts in itertools.product(range(11), repeat=3):
        if sum(parts) > 10:
            continue
        weights = np.array([10 - sum(parts), *parts]) / 10.0
        truth = float(weights @ np.arange(4)) / 3.0
        worst = max(worst, float(chances(weights, n)[bounds < truth - 1e-12].sum()))
    assert worst <= 0.05


@given(st.lists(st.integers(-3, 3), min_size=1, max_size=10))
@settings(deadline=None)
def test_flips_that_are_counted_are_those_that_are_tried(thirds):
    differences = np.array(thirds) / 3.0
    signs = np.array(list(itertools.product([-1.0, 1.0], repeat=len(thirds))))
    tried = float((np.abs(signs @ differences) >= abs(differences.sum()) - 1e-12).mean())
    assert sign_flip_test(differences, lattice=3) == pytest.approx(tried)
    assert sign_flip_test(differences) == pytest.approx(tried)


@given(st.integers(0, 30), st.integers(0, 30))
def test_with_single_seeds_flipping_is_the_exact_mcnemar_test(a, b):
    differences = np.array([1.0] * a + [-1.0] * b + [0.0] * 7)
    mcnemar = binomtest(a, a + b).pvalue if a + b else 1.0
    assert sign_flip_test(differences, lattice=1) == pytest.approx(mcnemar)


def test_flips_that_are_drawn_say_what_scipy_says():
    differences = rng(5).normal(0.4, 1.0, 40)
    oracle = permutation_test((differences,), np.sum, permutation_type="samples", n_resamples=9999, rng=rng(6)).pvalue
    assert sign_flip_test(differences) == pytest.approx(oracle, abs=0.01)
    assert sign_flip_test(differences) == pytest.approx(ttest_1samp(differences, 0.0).pvalue, abs=0.02)
    assert sign_flip_test(np.zeros(9)) == 1.0


@pytest.mark.parametrize("p", [[0.01, 0.04, 0.03, 0.005]])
def test_holm_by_hand(p):
    # Sorted: 0.005 x 4, 0.01 x 3, 0.03 x 2, 0.04 x 1, none below the one before.
    assert holm(np.array(p)) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm(np.array([0.7, 0.6])).tolist() == [1.0, 1.0]
    assert holm(np.array([0.02])).tolist() == [0.02]


def test_a_symmetric_sample_has_students_interval():
    values = np.arange(-10.0, 11.0)[:, None]
    found = mean_over_scenes(values)
    oracle = ttest_1samp(values[:, 0], 0.0).confidence_interval(0.95)
    assert (found.low, found.high) == pytest.approx((oracle.low, oracle.high))
    skewed = mean_over_scenes(np.exp(values / 5.0))
    plain = ttest_1samp(np.exp(values[:, 0] / 5.0), 0.0).confidence_interval(0.95)
    assert skewed.low == pytest.approx(plain.low)
    assert skewed.high > plain.high + 0.1


def test_a_paired_difference_has_students_interval_a_little_wider():
    differences = rng(7).normal(1.0, 2.0, 60)
    found, oracle = mean_difference(differences), ttest_1samp(differences, 0.0).confidence_interval(0.95)
    assert found.high - found.low == pytest.approx(oracle.high - oracle.low, rel=0.02)
    assert found.high - found.low > oracle.high - oracle.low
    a, b = rng(8).normal(size=(9, 3)), rng(9).normal(size=(9, 3))
    b[2] = np.nan
    assert len(paired(a, b)) == 8


def test_few_scenes_that_differ_say_little_of_how_often_others_will():
    differences = np.array([1.0, 1.0, -1.0, -1.0] + [0.0] * 96)
    found, plain = mean_difference(differences), ttest_1samp(differences, 0.0).confidence_interval(0.95)
    assert found.high == pytest.approx(plain.high * math.sqrt(5 / 4))  # five that differ in place of four


def test_scenes_that_all_agree_say_no_more_than_that():
    found = mean_difference(np.zeros(100), span=1.0)
    assert found.high == pytest.approx(0.02, abs=0.002)
    assert math.isnan(mean_difference(np.zeros(100)).high)
    assert math.isnan(mean_difference(np.array([0.3])).high)


def test_superiority_by_hand():
    a = np.array([[1.0, 2.0], [3.0, np.nan], [0.0, 0.0]])
    b = np.array([[0.0, 2.0], [1.0, 5.0], [1.0, 1.0]])
    assert superiority(a, b).value == pytest.approx((0.75 + 1.0 + 0.0) / 3)
    assert superiority(b, a).value == pytest.approx(1.0 - superiority(a, b).value)


def test_a_bootstrap_draws_scenes_and_not_seeds():
    alike = np.repeat(rng(10).normal(size=(50, 1)), 20, axis=1)
    found = bootstrapped(alike, np.mean)
    half = 1.96 * alike[:, 0].std() / math.sqrt(50)
    assert found.high - found.low == pytest.approx(2 * half, rel=0.05)
    assert bootstrapped(alike, np.mean) == found
    value, low, high = cluster_bootstrap(alike, lambda drawn: np.quantile(drawn, [0.25, 0.75]))
    assert value.shape == low.shape == high.shape == (2,)
    assert np.all((low <= value) & (value <= high))


def test_incidence_by_hand():
    # Six episodes; by 2 s one success of six; one is cut off at 3 s; at 4 s a collision of four left; at 5 s a success.
    times, causes = np.array([2.0, 3.0, 4.0, 5.0, 6.0, 6.0]), np.array([1, 0, 2, 1, 0, 0])
    at = np.array([0.0, 2.0, 4.0, 5.0, 9.0])
    assert cumulative_incidence(times, causes, 1, at) == pytest.approx([0, 1 / 6, 1 / 6, 1 / 6 + 5 / 8 * 1 / 3, 3 / 8])
    assert cumulative_incidence(times, causes, 2, at) == pytest.approx([0, 0, 5 / 6 / 4, 5 / 6 / 4, 5 / 6 / 4])


@given(
    st.lists(st.tuples(st.integers(1, 12), st.integers(0, 2)), min_size=2, max_size=25).filter(
        lambda found: any(cause for _, cause in found)
    )
)
@settings(deadline=None)
def test_incidences_add_up_to_kaplan_and_meier_of_any_end(found):
    times, causes = np.array([float(t) for t, _ in found]), np.array([cause for _, cause in found])
    at = np.arange(0.0, 14.0)
    both = cumulative_incidence(times, causes, 1, at) + cumulative_incidence(times, causes, 2, at)
    sample = CensoredData(uncensored=times[causes > 0], right=times[causes == 0])
    assert both == pytest.approx(ecdf(sample).cdf.evaluate(at), abs=1e-9)


def test_a_collision_is_no_censoring():
    """Half collide at once, the rest succeed: success is a half, though the estimate for censored data says all."""
    times, causes = np.array([1.0, 1.0, 5.0, 5.0]), np.array([2, 2, 1, 1])
    assert cumulative_incidence(times, causes, 1, np.array([9.0])) == [0.5]
    censored = ecdf(CensoredData(uncensored=[5.0, 5.0], right=[1.0, 1.0])).cdf
    assert censored.evaluate(9.0) == 1.0


def test_a_profile_by_hand():
    costs = np.array([[1.0, 4.0, np.inf, np.inf], [2.0, 2.0, 3.0, np.inf]])
    found = performance_profile(costs, np.array([1.0, 2.0, 100.0]))
    assert found.tolist() == [[0.25, 0.5, 0.5], [0.5, 0.75, 0.75]]


def test_the_middle_half_says_nothing_of_failures():
    scores = np.array([0.5] * 980 + [0.0] * 20).reshape(100, 10)
    assert interquartile_mean(scores) == 0.5
    for count in range(1, 40):
        values = np.random.default_rng(count).normal(size=count)
        assert interquartile_mean(values) == trim_mean(values, 0.25)
    assert interquartile_mean(np.arange(8.0).reshape(4, 2)) == pytest.approx(3.5)


def test_as_many_scenes_as_are_needed_find_it_four_times_in_five():
    pilot = rng(11).normal(0.5, 2.0, 400)
    pilot = (pilot - pilot.mean()) / pilot.std(ddof=1) * 2.0 + 0.5
    needed = scenes_needed(pilot)
    assert 126 <= needed <= 130  # (1.960 + 0.842)^2 x 16 = 125.6, and a little for Student
    drawn = rng(12).normal(0.5, 2.0, (3000, needed))
    assert np.mean(ttest_1samp(drawn, 0.0, axis=1).pvalue <= 0.05) == pytest.approx(0.8, abs=0.025)
    assert scenes_needed(pilot, 0.25) == pytest.approx(4 * needed, rel=0.03)
    assert scenes_needed(np.zeros(9)) is None
    assert scenes_needed(np.array([1.0])) is None


def test_a_share_over_one_seed_is_binomial():
    """The rate's interval holds the truth as often as it should: enumerated, no luck."""
    counts = np.arange(101)
    ends = [rate(np.array([[1.0]] * k + [[0.0]] * (100 - k))) for k in counts]
    for truth in (0.5, 0.7, 0.9):
        held = [e.low <= truth <= e.high for e in ends]
        assert 0.93 <= binom.pmf(counts, 100, truth)[held].sum() <= 0.97
