"""Shares and means over the seeds of a single scenario, each with how sure it is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binom

from benchmarks.paper.estimates import mean, share


@given(st.integers(1, 300).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_a_share_has_the_interval_of_clopper_and_pearson(counts):
    hits, of = counts
    found = share(hits, of)
    assert (found.value, found.of) == (hits / of, of)
    # By definition: at the ends, as few or as many as these are 2.5 % likely.
    assert found.high == 1.0 if hits == of else binom.cdf(hits, of, found.high) == pytest.approx(0.025)
    assert found.low == 0.0 if hits == 0 else binom.sf(hits - 1, of, found.low) == pytest.approx(0.025)


@settings(deadline=None)  # ten thousand resamples
@given(st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=30))
def test_a_means_interval_holds_it_lies_within_the_values_and_repeats(values):
    found = mean(values)
    assert found.value == pytest.approx(sum(values) / len(values), abs=1e-9)
    if math.isnan(found.low):
        assert max(values) - min(values) <= 1e-12 * max(map(abs, values))
        return
    assert min(values) - 1e-9 <= found.low <= found.value + 1e-9
    assert found.value - 1e-9 <= found.high <= max(values) + 1e-9
    assert mean(values) == found


def test_it_is_as_wide_as_theory_says_for_many_values():
    values = np.random.default_rng(3).normal(5.0, 2.0, 400).tolist()
    found = mean(values)
    half = 1.96 * np.std(values) / math.sqrt(len(values))
    assert found.high - found.low == pytest.approx(2.0 * half, rel=0.05)


def test_one_value_says_nothing_of_others():
    found = mean([0.7])
    assert (found.value, found.of) == (0.7, 1)
    assert math.isnan(found.low)
    assert math.isnan(found.high)
