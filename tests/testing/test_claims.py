"""Claims of tests about planners: they pass, fail with the episodes against them, or are inconclusive."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

from rocs_bt.base.errors import UnknownName
from rocs_bt.compare import Comparison
from rocs_bt.testing.claims import Claims, Inconclusive

spec = importlib.util.spec_from_file_location("records", Path(__file__).parents[1] / "compare" / "records.py")
records = importlib.util.module_from_spec(spec)
spec.loader.exec_module(records)
episode, table = records.episode, records.table


def claims(*tables, check=lambda planner, text: ()):
    return Claims(Comparison([r for each in tables for r in each]), check)


def failure(claim):
    with pytest.raises(pytest.fail.Exception) as found:
        claim()
    return str(found.value)


def test_better_passes_and_gives_its_verdict():
    found = claims(table("a", "s" * 30), table("b", "s" * 10 + "c" * 20)).assert_better("a", "b")
    assert found.word == "better"
    assert found.episodes == 30


def test_not_better_fails_and_names_what_speaks_against_it_with_commands():
    both = claims(table("a", "s" * 10 + "c" * 20), table("b", "s" * 30))
    text = failure(lambda: both.assert_better("a", "b"))
    assert text.startswith("a is not better than b in success: -0.667 [")
    assert "b is better in 20 of 30 episodes:" in text
    assert "  field-10 seed 1: success 0 and 1; a collision at 15.0 s, b success at 20.0 s\n" in text
    assert "    rocs-bt run field-10 --planner a --seed 1\n    rocs-bt run field-10 --planner b --seed 1" in text
    assert text.count("rocs-bt run") == 10


def test_what_cannot_be_told_is_neither_and_says_how_many_scenes_would_do():
    with pytest.raises(Inconclusive, match=r"whether a is better than b in success: .*about \d+ scenes needed"):
        claims(table("a", "sssssc"), table("b", "sssscc")).assert_better("a", "b")
    with pytest.raises(Inconclusive, match="b is better in no episode"):
        claims(table("a", "ssss"), table("b", "ssss")).assert_better("a", "b")


def test_not_worse_needs_a_margin_and_enough_scenes_to_fill_it():
    many = claims(table("a", "s" * 200), table("b", "s" * 200))
    assert many.assert_not_worse("a", "b", margin=0.05).margin == -0.05
    with pytest.raises(Inconclusive, match=r"whether a is not worse than b by more than 0.005 in success"):
        many.assert_not_worse("a", "b", margin=0.005)
    slower = claims(table("a", "s" * 30, time=30.0), table("b", "s" * 30, time=20.0))
    text = failure(lambda: slower.assert_not_worse("a", "b", "time", margin=4.0))
    assert text.startswith("a is worse than b by more than 4 s in time: -10 s")
    with pytest.raises(ValueError, match="the margin must be above 0, found 0"):
        many.assert_not_worse("a", "b", margin=0.0)


def test_a_rate_has_an_exact_bound():
    none = claims(table("a", "s" * 200))
    none.assert_rate("a", "collision", upper=0.02)
    none.assert_rate("a", lower=0.98)
    with pytest.raises(Inconclusive, match=r"at most 0.01: a's collision rate, 0 of 200 .* about 400 scenes needed"):
        none.assert_rate("a", "collision", upper=0.01)
    with pytest.raises(Inconclusive, match=r"at least 0.99: a's success rate, 200 of 200 .* about 400 scenes"):
        none.assert_rate("a", lower=0.99)
    often = claims(table("a", "s" * 100 + "c" * 30))
    text = failure(lambda: often.assert_rate("a", "collision", upper=0.1))
    assert "30 of 130 episodes" in text
    assert "and so not at most 0.1" in text
    assert "field-100 seed 1: collision at 15.0 s\n    rocs-bt run field-100 --planner a --seed 1" in text
    assert "and 25 more" in text
    assert "field-100 seed 1" in failure(lambda: often.assert_rate("a", lower=0.9))
    with pytest.raises(ValueError, match="either upper"):
        none.assert_rate("a")


def test_always_lists_the_worst_first():
    asked = []

    def check(planner, text):
        asked.append((planner, text))
        return [
            episode(planner, f"field-{i}", **{f"holds {text}": held, f"margin of {text}": margin})
            for i, (held, margin) in enumerate([(1.0, 0.2), (0.0, -0.1), (0.0, -0.3)])
        ]

    both = claims(table("a", "sss"), check=check)
    text = failure(lambda: both.assert_always("a", "min(front) > 0.05 m"))
    assert asked == [("a", "always (min(front) > 0.05 m)")]
    assert text.startswith("a violates 'min(front) > 0.05 m' in 2 of 3 episodes; worst first\n  field-2 seed 1: least")
    failure(lambda: both.assert_always("a", "always speed < 1 m/s"))
    assert asked[-1] == ("a", "always speed < 1 m/s")


def test_always_is_inconclusive_where_it_cannot_be_told():
    def check(planner, text):
        return [episode(planner, "field-0", **{f"holds {text}": None})]

    with pytest.raises(Inconclusive, match=r"no episode violates .*, but its value is unknown in 1 of 1 episode\b"):
        claims(table("a", "s"), check=check).assert_always("a", "x > 0")

    def held(planner, text):
        return [episode(planner, "field-0", **{f"holds {text}": 1.0})]

    claims(table("a", "s"), check=held).assert_always("a", "x > 0")


def test_a_planner_that_is_not_there_is_told():
    with pytest.raises(UnknownName, match="'c'"):
        claims(table("a", "s")).assert_better("a", "c")
