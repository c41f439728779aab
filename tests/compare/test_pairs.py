"""The verdicts on many pairs in few lines."""

from __future__ import annotations

import pytest

from rocs_bt.compare import Comparison
from rocs_bt.compare.report import markdown, pairs, standings

from .records import table

ENDS = {
    "a_planner_of_a_long_name": "s" * 40,
    "b": "s" * 39 + "c",
    "c": "s" * 20 + "c" * 20,
    "d": "s" * 21 + "k" * 19,
    **{f"e{number}": "t" * 40 for number in range(4)},
}
METRICS = ("success", "collision", "time")


def told(ends, metrics=METRICS):
    comparison = Comparison([record for name, letters in ends.items() for record in table(name, letters)])
    planners = [row.planner for row in standings(comparison, metrics)]
    return comparison.verdicts(metrics), planners, pairs(comparison.verdicts(metrics), planners)


def test_eight_planners_and_three_metrics_fit_on_a_screen():
    verdicts, _, lines = told(ENDS)
    assert len(verdicts) == 84
    assert len(lines) <= 70
    assert max(map(len, lines)) <= 100
    assert sum(line.startswith(tuple(METRICS)) for line in lines) == 3
    apart = sum(verdict.word != "inconclusive" for verdict in verdicts if verdict.metric == "success")
    assert lines[0].startswith(f"success: {apart} of 28 pairs conclusive (+ better than the column's, - worse")
    assert 15 < apart < 28


def test_the_matrix_says_what_the_verdicts_say():
    verdicts, planners, lines = told(ENDS, ("success",))
    rows = [line.split() for line in lines[2 : 2 + len(planners)]]
    assert [row[1] for row in rows] == planners
    for verdict in verdicts:
        a, b = planners.index(verdict.a), planners.index(verdict.b)
        signs = {"better": ("+", "-"), "not better": ("-", "+"), "inconclusive": ("?", "?")}[verdict.word]
        assert (rows[a][2 + b], rows[b][2 + a]) == signs
    assert all(rows[i][2 + i] == "." for i in range(len(planners)))


def test_what_is_told_apart_is_told_in_words_and_the_rest_is_counted():
    verdicts, _, lines = told({"a": "s" * 40, "b": "s" * 40, "c": "c" * 40, "d": "s" * 39 + "c"}, ("success",))
    assert "  a is better than c by 100 points" in lines
    needed = {verdict.needed for verdict in verdicts if verdict.word == "inconclusive"} - {None}
    assert len(needed) == 1
    assert f"  3 inconclusive: about {needed.pop()} scenes needed for all that differ; 1 shows no difference" in lines
    assert "  3 inconclusive, without a difference that more scenes would probably show" in "\n".join(
        told(dict.fromkeys("abc", "s" * 9), ("success",))[2]
    )


def test_two_planners_are_one_sentence_of_the_one_that_did_better():
    _, _, lines = told({"a": "c" * 30, "b": "s" * 30}, ("success",))
    assert lines[0].startswith("b is better than a in success: +1 [")
    assert len(lines) == 1


@pytest.mark.parametrize(("scenes", "least"), [(2, 6), (5, 6), (40, None)])
def test_fewer_scenes_than_a_test_can_tell_are_never_held_enough(scenes, least):
    comparison = Comparison([*table("a", "s" * scenes), *table("b", "c" * scenes)])
    assert comparison.verdict("a", "b").needed == least


def test_who_makes_many_claims_needs_more_scenes():
    records = [r for name, letters in {"a": "s" * 5, "b": "c" * 5, "c": "c" * 5}.items() for r in table(name, letters)]
    comparison = Comparison(records)
    assert comparison.verdict("a", "b").needed == 6
    assert comparison.verdicts()[0].needed == 7  # 2^-6 is 0.05 / 3 at most, and 2^-5 is not
    many = comparison.verdicts(("success", "collision", "time"))
    assert next(v for v in many if v.metric == "success" and (v.a, v.b) == ("a", "b")).needed == 9


def test_tables_tell_what_is_told_apart_before_the_rest():
    verdicts, _, _ = told(ENDS)
    rows = [line for line in markdown_of(ENDS).splitlines() if " better than " in line and line.startswith("|")]
    words = ["inconclusive" in row for row in rows]
    assert len(words) == len(verdicts)
    assert words == sorted(words)
    assert 0 < sum(words) < len(words)


def test_a_leader_that_cannot_be_told_from_the_others_is_no_more():
    assert markdown_of(dict.fromkeys("abc", "sss")).startswith(
        "**a leads, but is not conclusively better than any of 2 others in success"
    )
    assert markdown_of(ENDS).startswith("**a_planner_of_a_long_name leads and is better than ")


def markdown_of(ends):
    comparison = Comparison([record for name, letters in ends.items() for record in table(name, letters)])
    return markdown(comparison, METRICS, comparison.verdicts(METRICS))
