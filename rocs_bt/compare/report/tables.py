"""Texts for the tables of a report: results per planner, and verdicts per pair."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..cold import Loss
from ..comparison import Comparison
from ..metric import METRICS, SHARES, Metric, metric
from ..record import OUTCOMES
from ..statistics import Estimate, SampleSize, bootstrapped, interquartile_mean
from ..verdict import Verdict, favourable, swapped

BEST_FIRST = sorted(
    OUTCOMES, key=("success", "stuck", "failed", "timeout", "interrupted", "fell", "collision", "limit", "error").index
)


@dataclass(frozen=True)
class LeaderboardRow:
    """Results of one planner."""

    planner: str
    number: int  # index among all planners, which determines the planner's colour
    estimates: Mapping[str, Estimate]
    most_collisions: float  # upper confidence bound of the collision rate
    outcomes: Mapping[str, int]  # number of episodes by outcome, the best outcome first
    size: SampleSize

    @property
    def episodes(self) -> int:
        """Number of episodes."""
        return sum(self.outcomes.values())


def standings(comparison: Comparison, metrics: Sequence[str]) -> list[LeaderboardRow]:
    """Leaderboard: a row for each planner, ordered by success rate, then by mean time."""
    found = []
    for number, planner in enumerate(comparison.planners):
        counts = comparison.outcomes(planner)
        wanted = dict.fromkeys((*SHARES, "time", *metrics))
        found.append(
            LeaderboardRow(
                planner=planner,
                number=number,
                estimates={name: comparison.estimate(planner, name) for name in wanted},
                most_collisions=comparison.bounds(planner, "collision")[1],
                outcomes={name: counts[name] for name in BEST_FIRST if name in counts},
                size=comparison.size(planner),
            )
        )
    return sorted(found, key=lambda s: (-_or_nothing(s.estimates["success"].value), s.estimates["time"].value))


def headline(rows: Sequence[LeaderboardRow], verdicts: Sequence[Verdict]) -> str:
    """The main result in one sentence."""
    if not verdicts:
        return f"{rows[0].planner} succeeds in {text(rows[0].estimates['success'], metric('success'))}"
    if len(rows) == 2:
        stated = [favourable(verdict) for verdict in verdicts]
        better = [verdict for verdict in stated if verdict.word == "better"]
        if not better:
            return f"Inconclusive: {stated[0].a} against {stated[0].b}"
        return "; ".join(f"{v.a} is better than {v.b} in {v.metric}" for v in better)
    leader = rows[0].planner
    in_success = [v for v in map(favourable, verdicts) if v.metric == verdicts[0].metric and leader in (v.a, v.b)]
    beaten = [v.b for v in in_success if v.word == "better" and v.a == leader]
    if not beaten:
        return (
            f"{leader} leads, but is not conclusively better than any of {len(rows) - 1} others in {verdicts[0].metric}"
        )
    return f"{leader} leads and is better than {len(beaten)} of {len(rows) - 1} others in {verdicts[0].metric}"


def conclusive_first(verdicts: Sequence[Verdict]) -> list[Verdict]:
    """Verdicts, each stated for the better planner of its pair, with conclusive ones first."""
    return sorted(map(favourable, verdicts), key=lambda verdict: verdict.word == "inconclusive")


def matrix(verdicts: Sequence[Verdict], planners: Sequence[str]) -> list[list[Verdict | None]]:
    """Verdicts of one metric as a square matrix, row planner against column planner; None on the diagonal."""
    by_pair = {(each.a, each.b): each for verdict in verdicts for each in (verdict, swapped(verdict))}
    return [[by_pair.get((row, column)) for column in planners] for row in planners]


def points(verdict: Verdict) -> str:
    """Format the difference of a verdict without its unit; differences of rates are in percentage points."""
    if math.isnan(verdict.difference):
        return "–"
    return f"{100.0 * verdict.difference:+z.1f}" if verdict.metric in SHARES else f"{verdict.difference:+z.3g}"


def text(found: Estimate, of: Metric) -> str:
    """Format an estimate with its interval, if it has one, and the metric's unit."""
    shown, unit = (_percent, " %") if of.name in SHARES else (number, f" {of.unit}" if of.unit else "")
    ends = "" if math.isnan(found.low) else f" ({shown(found.low)} to {shown(found.high)})"
    return f"{shown(found.value)}{unit}{ends}"


def number(value: float) -> str:
    """Format a number with three significant digits; a dash for NaN."""
    return "–" if math.isnan(value) else f"{value:.3g}"


def difference(verdict: Verdict) -> str:
    """Format the difference of two planners in a metric: value, unit and confidence interval, if it has one."""
    if math.isnan(verdict.difference):
        return "–"
    if verdict.metric in SHARES:
        value, low, high = (f"{100.0 * end:+z.1f}" for end in (verdict.difference, verdict.low, verdict.high))
        unit = " points"
    else:
        value, low, high = (f"{end:+z.3g}" for end in (verdict.difference, verdict.low, verdict.high))
        unit = f" {verdict.unit}" if verdict.unit else ""
    return f"{value}{unit}" + ("" if math.isnan(verdict.low) else f" ({low} to {high})")


def everything(comparison: Comparison) -> list[tuple[Metric, str, list[str]]]:
    """Table of all metrics with values: the metric, the episodes over which it is averaged, each planner's mean.

    Metrics with `until_failure` are averaged over the episodes in which all planners succeed.
    """
    all_succeed = np.all([comparison.sample(p, "success") == 1.0 for p in comparison.planners], axis=0)
    names = {name for record in comparison.records for name, value in record.metrics.items() if value is not None}
    rows = []
    for of in [m for name, m in METRICS.items() if name in names]:
        if not of.until_failure:
            rows.append((of, "all", [text(comparison.estimate(p, of), of) for p in comparison.planners]))
            continue
        over = f"{int(all_succeed.sum())} in which all succeed"
        rows.append((of, over, [text(comparison.estimate(p, of, all_succeed), of) for p in comparison.planners]))
    return rows


def middle(comparison: Comparison) -> list[str]:
    """Format the interquartile mean of the time for each planner; it ignores failures if they are few."""
    samples = [comparison.sample(planner, "time") for planner in comparison.planners]
    return [text(bootstrapped(sample, interquartile_mean), metric("time")) for sample in samples]


COLD_HEAD = ("planner", "perturbation", "metric", "warm", "cold", "loss")
"""Head of the table of losses; a positive loss means that the planner is worse with the perturbation, in any metric."""


def cold_rows(losses: Sequence[Loss]) -> list[list[str]]:
    """Losses of a cold comparison as texts, a row for each planner, perturbation and metric."""
    rows = []
    for loss in losses:
        warm, cold = (text(estimate, metric(loss.verdict.metric)) for estimate in (loss.warm, loss.cold))
        rows.append([loss.planner, loss.perturbation, loss.verdict.metric, warm, cold, difference(loss.verdict)])
    return rows


def _percent(share: float) -> str:
    return "–" if math.isnan(share) else f"{100.0 * share:.1f}"


def _or_nothing(value: float) -> float:
    return -1.0 if math.isnan(value) else value
