"""Comparison and Verdict: what episodes say of planners and of pairs."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rocs_bt.base.errors import InputError, UnknownName
from rocs_bt.compare import Comparison
from rocs_bt.compare.record import EpisodeRecord
from rocs_bt.compare.replay import replay_command
from rocs_bt.compare.statistics import holm
from rocs_bt.compare.verdict import Verdict

from .records import LIMIT, episode, table

rng = np.random.default_rng


def drawn(planner, chance, scenes=60, seeds=1, seed=1, time=20.0):
    stream = rng(seed)
    return [
        episode(planner, f"field-{i}", s, "success" if stream.random() < chance else "stuck", stream.normal(time, 2.0))
        for i in range(scenes)
        for s in range(1, seeds + 1)
    ]


def test_its_tables_have_a_row_for_each_scene_and_a_column_for_each_seed():
    comparison = Comparison([*table("a", "sc ss", seeds=2), *table("b", "st", seeds=2)])
    assert comparison.planners == ("a", "b")
    assert comparison.scenes == ("field-0", "field-1")
    assert comparison.values("a", "success").tolist() == [[1.0, 0.0], [1.0, 1.0]]
    assert comparison.values("b", "time")[0].tolist() == [20.0, LIMIT]
    assert np.isnan(comparison.values("b", "success")[1]).all()
    assert np.isnan(comparison.values("a", "spl")).all()
    assert comparison.outcomes("a") == {"success": 3, "collision": 1}
    assert comparison.find("b", "field-1", 1) is None
    with pytest.raises(UnknownName, match=r"no planner .*'c'.*a, b"):
        comparison.of("c")
    with pytest.raises(UnknownName, match="metric"):
        comparison.values("a", "beauty")


def test_no_episodes_and_two_of_one_kind_are_refused():
    with pytest.raises(InputError, match="No episodes to compare"):
        Comparison([])
    one = episode("a", "field-1")
    with pytest.raises(InputError, match="two different episodes of a in field-1 with seed 1"):
        Comparison([one, one.__class__(**{**{f: getattr(one, f) for f in one.__struct_fields__}, "key": "other"})])
    assert len(Comparison([one, one]).records) == 1


def test_a_planner_that_wins_often_enough_is_better_and_the_other_is_not():
    comparison = Comparison([*table("a", "s" * 30 + "c" * 2), *table("b", "s" * 15 + "c" * 17)])
    verdict = comparison.verdict("a", "b")
    assert verdict.word == "better"
    assert verdict.p == pytest.approx(2.0**-14)  # the exact McNemar test of 15 against 0
    assert (verdict.scenes, verdict.episodes, verdict.apart) == (32, 32, 15)
    assert verdict.difference == pytest.approx(15 / 32)
    assert verdict.low > 0.0
    assert verdict.needed is None
    assert verdict.superiority == pytest.approx(0.5 + 15 / 64)
    assert comparison.verdict("b", "a").word == "not better"
    assert comparison.verdict("b", "a").difference == -verdict.difference
    assert str(verdict).startswith("a is better than b in success: +0.469 [")


def test_less_is_better_where_the_metric_says_so():
    comparison = Comparison([*table("a", "s" * 30, time=18.0), *table("b", "s" * 28 + "cc", time=21.0)])
    verdict = comparison.verdict("a", "b", "time")
    assert verdict.word == "better"
    assert verdict.difference > 3.0
    assert comparison.verdict("a", "b", "collision").difference == pytest.approx(2 / 30)


def test_few_scenes_are_inconclusive_and_say_how_many_would_do():
    comparison = Comparison([*drawn("a", 0.9, seed=1), *drawn("b", 0.85, seed=3)])
    verdict = comparison.verdict("a", "b")
    assert verdict.word == "inconclusive"
    assert verdict.needed > 60
    assert "inconclusive whether a is better than b in success" in str(verdict)
    assert f"about {verdict.needed} scenes needed" in str(verdict)
    same = Comparison([*table("a", "ssss"), *table("b", "ssss")]).verdict("a", "b")
    assert (same.word, same.needed, same.p) == ("inconclusive", None, 1.0)
    assert math.isnan(Comparison([*table("a", "s"), *table("b", "c")]).verdict("a", "b").low)
    assert Comparison([*table("a", "s"), *table("b", "c")]).verdict("a", "b").as_dict()["low"] is None


def test_not_worse_is_better_than_minus_a_margin():
    same = Comparison([*table("a", "s" * 200), *table("b", "s" * 200)])
    assert same.verdict("a", "b", margin=-0.05).word == "better"
    few = Comparison([*table("a", "s" * 20), *table("b", "s" * 20)])
    assert few.verdict("a", "b", margin=-0.05).word == "inconclusive"
    assert str(same.verdict("a", "b", margin=-0.05)).startswith("a is not worse than b by more than 0.05 in success")
    slower = Comparison([*drawn("a", 1.0, seed=1, time=24.0), *drawn("b", 1.0, seed=2, time=20.0)])
    assert slower.verdict("a", "b", "time", margin=-2.0).word == "not better"
    assert slower.verdict("a", "b", "time", margin=-6.0).word == "better"
    assert slower.verdict("a", "b", "time", margin=-4.0).word == "inconclusive"


def test_what_tells_of_the_way_until_a_failure_is_compared_where_both_succeed():
    a = table("a", "ssscc", path_length=3.0)
    b = table("b", "csscs", path_length=4.0)
    verdict = Comparison([*a, *b]).verdict("a", "b", "path_length")
    assert (verdict.scenes, verdict.difference) == (2, 1.0)


def test_verdicts_looked_at_together_are_harder_to_come_by():
    records = [r for k, p in enumerate((0.95, 0.72, 0.7, 0.72)) for r in drawn(f"p{k}", p, 40, seed=k)]
    comparison = Comparison(records)
    together = comparison.verdicts()
    alone = [comparison.verdict(v.a, v.b) for v in together]
    assert len(together) == 6
    assert [v.p for v in together] == pytest.approx(holm(np.array([v.p for v in alone])).tolist())
    few = Comparison([*table("a", "s" * 30), *table("b", "s" * 24 + "c" * 6), *table("c", "s" * 29 + "c")])
    assert few.verdict("a", "b").word == "better"
    assert [v.word for v in few.verdicts()] == ["inconclusive"] * 3  # p = 0.031 alone, three times that together
    assert all(t.p >= one.p for t, one in zip(together, alone, strict=True))
    assert sum(t.word != "inconclusive" for t in together) <= sum(v.word != "inconclusive" for v in alone)


def test_a_scene_counts_once_however_many_seeds_it_has():
    few = Comparison([*drawn("a", 0.9, 15), *drawn("b", 0.5, 15, seed=2)])
    copies = [episode(r.planner, r.scene, s, r.outcome, r.metrics["time"]) for r in few.records for s in range(1, 21)]
    alike = Comparison(copies)
    assert alike.verdict("a", "b").p == pytest.approx(few.verdict("a", "b").p)
    assert alike.verdict("a", "b").low == pytest.approx(few.verdict("a", "b").low)
    assert alike.size("a").effective == pytest.approx(15, rel=0.08)


def test_bounds_of_a_share():
    comparison = Comparison(table("a", "s" * 100))
    assert comparison.bounds("a", "collision") == (0.0, pytest.approx(0.0295, abs=1e-3))
    assert comparison.estimate("a", "success").low == pytest.approx(0.96, abs=0.01)
    assert comparison.estimate("a", "time").value == 20.0
    with pytest.raises(InputError, match="only shares have exact bounds"):
        comparison.bounds("a", "time")


def test_at_any_time_a_verdict_needs_a_bound_and_more_evidence():
    comparison = Comparison([*table("a", "s" * 40), *table("b", "c" * 12 + "s" * 28)])
    once, always = comparison.verdict("a", "b"), comparison.verdict("a", "b", any_time=True)
    assert always.p > once.p
    assert once.word == always.word == "better"
    assert comparison.settled()
    assert not comparison.settled(["success", "time"])
    with pytest.raises(InputError, match=r"no any-time verdict on path_length.*success, collision.*time"):
        comparison.verdict("a", "b", "path_length", any_time=True)


def test_an_episode_that_broke_down_is_a_failure_and_is_not_left_out():
    broken = EpisodeRecord(key="x", planner="a", family="field", scene="field-2", seed=1, outcome="error", reason="oh")
    comparison = Comparison([*table("a", "ss"), broken, *table("b", "sss")])
    assert comparison.values("a", "success")[:, 0].tolist() == [1.0, 1.0, 0.0]
    assert comparison.values("a", "time")[2, 0] == LIMIT
    assert np.isnan(comparison.values("a", "collision")[2, 0])
    assert comparison.estimate("a", "success").value == pytest.approx(2 / 3)
    assert comparison.verdict("a", "b").apart == 1


def test_disagreements_have_the_one_that_succeeded_first():
    comparison = Comparison([*table("a", "ssc"), *table("b", "scs")])
    found = comparison.disagreements("a", "b")
    assert [(d.winner.planner, d.loser.planner, d.loser.scene) for d in found] == [
        ("a", "b", "field-1"),
        ("b", "a", "field-2"),
    ]
    assert replay_command(found[0].loser) == "rocs-bt run field-1 --planner b --seed 1"
    assert isinstance(comparison.verdict("a", "b"), Verdict)


def test_of_a_single_scene_the_seeds_are_the_sample():
    a = [episode("a", "field-1", seed) for seed in range(1, 31)]
    b = [episode("b", "field-1", seed, "success" if seed % 2 else "stuck") for seed in range(1, 31)]
    comparison = Comparison([*a, *b])
    verdict = comparison.verdict("a", "b")
    assert (verdict.word, verdict.scenes, verdict.episodes) == ("better", 1, 30)
    assert str(verdict).endswith("30 seeds of one scene")
    assert comparison.size("a").effective == 30
    assert comparison.bounds("a", "collision")[1] == pytest.approx(0.095, abs=0.01)
    assert comparison.estimate("b", "success").low > 0.3


def test_an_interval_ends_where_the_metric_does():
    few = [episode("a", "field-0", time=1.0), episode("a", "field-1", outcome="timeout")]
    assert (Comparison(few).estimate("a", "time").low, Comparison(few).estimate("a", "time").high) == (0.0, LIMIT)
    assert math.isnan(Comparison(few[:1]).estimate("a", "time").low)


def test_one_episode_has_no_interval_to_tell():
    verdict = Comparison([*table("a", "s"), *table("b", "c")]).verdict("a", "b")
    assert str(verdict) == "inconclusive whether a is better than b in success: +1, p 1, 1 seed of one scene"
