"""Verdicts that stay valid however often one looks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.compare.statistics import always_valid, log_wealth


def test_a_wealth_cannot_be_expected_to_grow():
    """Enumerated: over all ways in which six scenes can end, its mean is 1 where the mean is what is bet against."""
    import itertools

    for chance in (0.2, 0.5, 0.9):
        total = 0.0
        for ends in itertools.product([0.0, 1.0], repeat=6):
            weight = np.prod([chance if end else 1.0 - chance for end in ends])
            total += weight * np.exp(log_wealth(np.array(ends), chance)[-1])
        assert total == pytest.approx(1.0)


@given(st.lists(st.sampled_from([-1.0, -1 / 3, 0.0, 1 / 3, 1.0]), min_size=1, max_size=40))
@settings(deadline=None)
def test_the_interval_holds_the_mean_and_agrees_with_p(differences):
    found, p = always_valid(np.array(differences), 1.0)
    assert -1.0 <= found.low <= found.high <= 1.0 or found.low > found.high  # moments that contradict each other
    assert (p <= 0.05) == (found.low >= 0.0 or found.high <= 0.0)


def test_a_side_that_wins_is_found_and_the_other_way_round():
    wins = np.array([1.0, 0.0, 1.0, 1.0, 0.0, 1.0, -1.0, 1.0] * 6)
    found, p = always_valid(wins, 1.0)
    other, same = always_valid(-wins, 1.0)
    assert found.low > 0.0
    assert p == pytest.approx(same)
    assert p < 0.05
    assert (other.low, other.high) == pytest.approx((-found.high, -found.low))


def test_what_was_once_told_stays_told():
    """The interval only shrinks: a later run of bad luck takes nothing back."""
    wins = np.array([1.0] * 30 + [-1.0, 1.0] * 30)
    early, late = always_valid(wins[:30], 1.0), always_valid(wins, 1.0)
    assert late[0].low >= early[0].low > 0.0
    assert late[1] <= early[1]


def test_a_margin_is_told_from_in_its_own_unit():
    slower = np.random.default_rng(3).normal(-4.0, 3.0, 400).clip(-60.0, 60.0)
    found, p = always_valid(slower, 60.0, margin=-20.0)
    assert found.low > -20.0
    assert p < 0.05
    assert always_valid(np.zeros(0), 1.0)[1] == 1.0
    assert always_valid(np.zeros(50), 1.0)[1] == 1.0
