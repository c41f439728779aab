"""Exactly one outcome, the weightiest."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.base.errors import BlockError
from rocs_bt.base.geometry import Pose2
from rocs_bt.simulation import OUTCOMES, Goal, Judge

GOAL = Goal("dock", Pose2(1.0, 0.0), 0.1)


@dataclass
class Mind:
    status: str = "RUNNING"
    reason: str = ""
    failure: BlockError | None = None
    reflex: str = ""
    held: bool = False
    waiting: bool = False

    def reading(self, rule: str) -> str:
        return "front = 0.21 m"


def judged(judge: Judge, outcome: str, t: float) -> None:
    """Show a judge what makes an outcome, from a time on [s]."""
    mind, pose, hit = Mind(), Pose2(0.0, 0.0), []
    if outcome == "error":
        mind.failure = BlockError("R2/plan", "raised", "ValueError: 3")
    elif outcome == "collision":
        hit = ["box"]
    elif outcome == "success":
        mind.status, pose = "SUCCESS", Pose2(0.95, 0.0)
    elif outcome == "failed":
        mind.status, mind.reason = "FAILURE", "STUCK: 5 pre-emptions"
    elif outcome == "stuck":
        for k in range(16):
            judge.update(t + k, pose, mind, commanded=True)
    elif outcome == "fell":
        for k in range(16):
            judge.update(t + k, pose, mind, commanded=False, ground="hull")
    elif outcome == "interrupted":
        judge.interrupt("SIGTERM")
    judge.update(t + 16.0, pose, mind, commanded=False, collisions=hit)


@pytest.mark.parametrize("pair", list(combinations(OUTCOMES, 2)))
@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_an_earlier_outcome_outranks_a_later_one(pair: tuple[str, str], order: tuple[int, int]) -> None:
    judge = Judge(GOAL)
    for k, i in enumerate(order):
        judged(judge, pair[i], 20.0 * k)
    assert judge.verdict().outcome == pair[0]
    assert judge.verdict().fell == ("fell" in pair)


def test_the_outcomes_are_documented_in_order_of_precedence() -> None:
    page = Path(__file__).parents[2] / "docs" / "architecture.md"
    table = page.read_text("utf-8").partition("| outcome | condition |")[2].partition("\n\n")[0]
    assert tuple(re.findall(r"^\| `(\w+)` \|", table, re.MULTILINE)) == OUTCOMES


@pytest.mark.parametrize(
    ("at", "z", "reached"),
    [((0.95, 0.0), 0.65, True), ((0.95, 0.0), 0.75, False), ((0.85, 0.0), 0.5, False), ((0.95, 0.0), math.nan, True)],
)
def test_a_goal_with_a_height_tolerance_is_a_cylinder(at, z, reached) -> None:
    goal = Goal("shelf", Pose2(1.0, 0.0), 0.1, 0.5, 0.2)
    judge, mind = Judge(goal), Mind(status="SUCCESS")
    judge.update(1.0, Pose2(*at), mind, commanded=False, z=z)
    assert judge.decided == reached
    if not reached:
        assert "(tolerance 0.1 m, in height 0.2 m)" in judge.verdict().reason


def test_success_needs_the_truth_as_well_as_the_missions_word() -> None:
    judge, mind = Judge(GOAL), Mind(status="SUCCESS")
    judge.update(1.0, Pose2(0.7, 0.0), mind, commanded=False)
    assert not judge.decided
    assert judge.verdict().outcome == "timeout"
    assert "returned SUCCESS, but it is 0.30 m from 'dock' (tolerance 0.1 m)" in judge.verdict().reason
    judge.update(2.0, Pose2(0.91, 0.0), mind, commanded=False)
    assert judge.decided
    assert (judge.verdict().outcome, judge.verdict().time_to_goal) == ("success", 2.0)


def test_without_a_goal_check_the_missions_word_is_enough() -> None:
    judge = Judge()
    assert judge.update(1.0, Pose2(0.0, 0.0), Mind(status="SUCCESS"), commanded=False)
    assert judge.verdict().outcome == "success"


def test_a_collision_ends_the_run_only_if_the_scenario_says_so() -> None:
    for ends in (False, True):
        judge = Judge(GOAL, end_on_collision=ends)
        judged(judge, "collision", 1.0)
        assert judge.decided is ends
        assert judge.verdict().reason == "it ran into box at 17.00 s"


def test_a_collision_on_the_way_keeps_the_time_to_the_goal() -> None:
    judge = Judge(GOAL)
    judged(judge, "collision", 1.0)
    judged(judge, "success", 2.0)
    assert (judge.verdict().outcome, judge.verdict().time_to_goal) == ("collision", 18.0)


@given(st.floats(0.0, 0.049), st.booleans())
def test_stuck_is_no_progress_while_commanded(wobble: float, commanded: bool) -> None:
    judge, t = Judge(GOAL), 0.0
    while t < 20.0 and not judge.decided:
        judge.update(t, Pose2(wobble if int(t * 20) % 2 else 0.0, 0.0), Mind(), commanded=commanded)
        t += 0.05
    assert judge.decided is commanded
    if commanded:
        assert t == pytest.approx(15.05, abs=0.06)
        assert judge.verdict().outcome == "stuck"
        assert "less than 0.05 m in 15 s" in judge.verdict().reason


@pytest.mark.parametrize(("climb", "stuck"), [(0.3, False), (-0.3, False), (0.0, True), (None, True)])
def test_a_climb_is_progress(climb: float | None, stuck: bool) -> None:
    judge, t = Judge(GOAL), 0.0
    while t < 20.0 and not judge.decided:
        height = {} if climb is None else {"z": 8.0 + climb * t}
        judge.update(t, Pose2(0.0, 0.0), Mind(), commanded=True, **height)
        t += 0.05
    assert judge.decided is stuck


@given(st.booleans(), st.booleans(), st.booleans())
def test_stuck_by_a_reflex_only_while_an_action_of_the_plan_waits_for_it(held: bool, active: bool, there: bool) -> None:
    """A plan that waits of its own accord is not stuck, whatever a reflex does; nor is a robot whose place counts."""
    judge, mind, t = Judge(GOAL, at_end=there), Mind(reflex="r/Halt" if active else "", held=held and active), 0.0
    while t < 20.0 and not judge.decided:
        judge.update(t, Pose2(1.0 if there else 0.0, 0.0), mind, commanded=False)
        t += 0.05
    assert judge.decided is (held and active and not there)
    if judge.decided:
        assert judge.verdict().outcome == "stuck"
        assert judge.verdict().reason.endswith("held by r/Halt for 15.0 s (front = 0.21 m)")


def test_the_clock_of_stuck_stops_in_between_and_its_reason_names_the_rule_that_held_longest() -> None:
    judge, mind, t = Judge(GOAL), Mind(), 0.0
    phases = ((4, "r/A", True), (30, "", False), (6, "r/B", False), (30, "", False), (4, "", True))
    for seconds, rule, commanded in phases:
        mind.reflex, mind.held = rule, bool(rule)
        for _ in range(20 * seconds):
            t += 0.05
            judge.update(t, Pose2(0.0, 0.0), mind, commanded=commanded)
    assert not judge.decided
    for _ in range(22):
        t += 0.05
        judge.update(t, Pose2(0.0, 0.0), mind, commanded=True)
    assert judge.verdict().outcome == "stuck"
    assert "held by r/B for 6.0 s" in judge.verdict().reason


@pytest.mark.parametrize(("paused", "waiting"), [(False, False), (True, False), (False, True)])
def test_the_clock_of_stuck_stops_in_neutral_and_while_a_rule_waits(paused: bool, waiting: bool) -> None:
    judge, mind = Judge(GOAL), Mind(reflex="r/Halt", held=True, waiting=waiting)
    for i in range(400):
        judge.update(0.05 * i, Pose2(0.0, 0.0), mind, commanded=True, paused=paused)
    assert judge.decided is not (paused or waiting)


def test_the_time_to_the_goal_counts_from_the_start() -> None:
    judge = Judge(start=3.0)
    judge.update(3.5, Pose2(0.0, 0.0), Mind(), commanded=False)
    judge.update(7.0, Pose2(0.0, 0.0), Mind(status="SUCCESS"), commanded=False)
    assert judge.verdict().time_to_goal == 4.0


def test_slow_progress_is_progress() -> None:
    judge = Judge(GOAL)
    for i in range(1200):
        judge.update(i * 0.05, Pose2(0.0, i * 0.05 * 0.004), Mind(), commanded=True)
    assert not judge.decided


def test_a_mission_that_never_ends_succeeds_where_it_is_at_the_end() -> None:
    judge = Judge(GOAL, at_end=True)
    for t, x in ((1.0, 0.5), (2.0, 0.95), (3.0, 0.7), (4.0, 1.0)):
        judge.update(t, Pose2(x, 0.0), Mind(), commanded=False)
    assert not judge.decided, "it may still be pushed off"
    assert (judge.verdict().outcome, judge.verdict().time_to_goal) == ("success", 2.0)
    judge.update(5.0, Pose2(0.6, 0.0), Mind(), commanded=False)
    assert judge.verdict().outcome == "timeout"
    assert judge.verdict().reason == "it reached 'dock' at 2.0 s, but at the end it is 0.40 m from 'dock'"


def test_at_the_end_the_missions_word_counts_for_nothing_but_its_failure_does() -> None:
    judge = Judge(GOAL, at_end=True)
    judge.update(1.0, Pose2(0.0, 0.0), Mind(status="SUCCESS"), commanded=False)
    assert (judge.decided, judge.verdict().outcome) == (False, "timeout")
    judge.update(2.0, Pose2(1.0, 0.0), Mind(status="FAILURE", reason="NO_GOAL"), commanded=False)
    assert judge.decided
    assert (judge.verdict().outcome, judge.verdict().reason) == ("failed", "the mission failed: NO_GOAL")


@pytest.mark.parametrize("worse", ["error", "collision"])
def test_being_there_at_the_end_makes_up_for_nothing(worse: str) -> None:
    judge = Judge(GOAL, at_end=True)
    judged(judge, worse, 1.0)
    judge.update(2.0, Pose2(1.0, 0.0), Mind(), commanded=False)
    assert judge.verdict().outcome == worse


@given(st.lists(st.sampled_from(["", "r/A", "r/B"]), min_size=40, max_size=200), st.sampled_from(["timeout", "failed"]))
def test_a_timeout_or_failure_under_reflexes_names_the_rules_and_their_time(rules: list[str], outcome: str) -> None:
    """The reason counts what a second count of the periods gives."""
    judge, mind = Judge(GOAL, end_on_stuck=False), Mind()
    for k, rule in enumerate(rules, 1):
        mind.reflex, mind.held = rule, bool(rule)
        mind.status = "FAILURE" if k == len(rules) and outcome == "failed" else "RUNNING"
        judge.update(0.5 * k, Pose2(0.1 * k + 2.0, 0.0), mind, commanded=True)
    judge.running = "GoTo(dock) has run"
    verdict = judge.verdict()
    assert verdict.outcome == outcome
    times = {rule: 0.5 * rules.count(rule) for rule in ("r/A", "r/B")}
    total = sum(times.values())
    named = [rule for rule in times if f"{rule} for {times[rule]:.1f} s (front = 0.21 m)" in verdict.reason]
    if total > 0.25 * 0.5 * len(rules):
        assert max(times.values()) in [times[rule] for rule in named]
        assert (len(named) == 2) == (min(times.values()) >= 0.1 * total)
    else:
        assert named == []
    assert (f"reflexes held it for {total:.1f} s of {0.5 * len(rules):.1f} s" in verdict.reason) == bool(named)
