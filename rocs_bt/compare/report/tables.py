"""The tables of a report, as texts: how each planner did, and the verdict on each pair."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..comparison import Comparison
from ..metric import METRICS, SHARES, Metric, metric
from ..record import OUTCOMES
from ..statistics import Estimate, SampleSize, bootstrapped, interquartile_mean, mean_over_scenes
from ..verdict import Verdict, favourable, swapped

BEST_FIRST = sorted(OUTCOMES, key=("success", "stuck", "failed", "timeout", "interrupted", "collision", "error").index)


@dataclass(frozen=True)
class LeaderboardRow:
    """How one planner did.

    Attributes:
        planner: Its name.
        number: Its place among all planners, which is its colour's.
        estimates: Its means by metric, as `Comparison.estimate` gives.
        most_collisions: What its true share of collisions is at most.
        outcomes: How often each outcome came, the best first.
        size: What its episodes are worth, for success.
    """

    planner: str
    number: int
    estimates: Mapping[str, Estimate]
    most_collisions: float
    outcomes: Mapping[str, int]
    size: SampleSize

    @property
    def episodes(self) -> int:
        """How many episodes it has."""
        return sum(self.outcomes.values())


def standings(comparison: Comparison, metrics: Sequence[str]) -> list[LeaderboardRow]:
    """All planners, the one with most successes first; of two with as many the faster one."""
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
    """What came out, in one sentence."""
    if not verdicts:
        return f"{rows[0].planner} succeeds in {text(rows[0].estimates['success'], metric('success'))}"
    if len(rows) == 2:
        told = [favourable(verdict) for verdict in verdicts]
        better = [verdict for verdict in told if verdict.word == "better"]
        if not better:
            return f"It cannot be told whether {told[0].a} or {told[0].b} is better"
        return "; ".join(f"{v.a} is better than {v.b} in {v.metric}" for v in better)
    leader = rows[0].planner
    in_success = [v for v in map(favourable, verdicts) if v.metric == verdicts[0].metric and leader in (v.a, v.b)]
    beaten = [v.b for v in in_success if v.word == "better" and v.a == leader]
    if not beaten:
        return f"{leader} leads, but cannot be told from any of {len(rows) - 1} others in {verdicts[0].metric}"
    return f"{leader} leads; it is better than {len(beaten)} of {len(rows) - 1} others in {verdicts[0].metric}"


def conclusive_first(verdicts: Sequence[Verdict]) -> list[Verdict]:
    """Each told of the planner that did better; those that are told apart before those that are not."""
    return sorted(map(favourable, verdicts), key=lambda verdict: verdict.word == "inconclusive")


def matrix(verdicts: Sequence[Verdict], planners: Sequence[str]) -> list[list[Verdict | None]]:
    """The verdicts of one metric as a square, told of the row's planner against the column's; None on the diagonal.

    Args:
        verdicts: On all pairs of the planners.
        planners: Their names, in the order of rows and columns.
    """
    told = {(each.a, each.b): each for verdict in verdicts for each in (verdict, swapped(verdict))}
    return [[told.get((row, column)) for column in planners] for row in planners]


def points(verdict: Verdict) -> str:
    """How much better, without a unit: of shares in points of a percent."""
    if math.isnan(verdict.difference):
        return "–"
    return f"{100.0 * verdict.difference:+z.1f}" if verdict.metric in SHARES else f"{verdict.difference:+z.3g}"


def text(found: Estimate, of: Metric) -> str:
    """An estimate and its interval in the metric's unit."""
    if of.name in SHARES:
        return f"{_percent(found.value)} % ({_percent(found.low)} to {_percent(found.high)})"
    unit = f" {of.unit}" if of.unit else ""
    return f"{number(found.value)}{unit} ({number(found.low)} to {number(found.high)})"


def number(value: float) -> str:
    """A number as tables have it; a dash for none."""
    return "–" if math.isnan(value) else f"{value:.3g}"


def difference(verdict: Verdict) -> str:
    """How much better, with its interval."""
    if verdict.metric in SHARES:
        ends = [f"{100.0 * end:+z.1f}" for end in (verdict.difference, verdict.low, verdict.high)]
        return f"{ends[0]} points ({ends[1]} to {ends[2]})"
    unit = f" {verdict.unit}" if verdict.unit else ""
    return f"{verdict.difference:+z.3g}{unit} ({verdict.low:+z.3g} to {verdict.high:+z.3g})"


def everything(comparison: Comparison) -> list[tuple[Metric, str, list[str]]]:
    """Every metric that has a value: the metric, over which episodes, and each planner's mean in its order.

    What tells of the way until a failure is told of the episodes in which every planner succeeds.
    """
    all_succeed = np.all([comparison.sample(p, "success") == 1.0 for p in comparison.planners], axis=0)
    names = {name for record in comparison.records for name, value in record.metrics.items() if value is not None}
    rows = []
    for of in [m for name, m in METRICS.items() if name in names]:
        if of.on_failure == "counts":
            rows.append((of, "all", [text(comparison.estimate(p, of), of) for p in comparison.planners]))
            continue
        samples = [np.where(all_succeed, comparison.sample(p, of), math.nan) for p in comparison.planners]
        told = f"{int(all_succeed.sum())} in which all succeed"
        rows.append((of, told, [text(mean_over_scenes(sample), of) for sample in samples]))
    return rows


def middle(comparison: Comparison, of: str = "time") -> list[str]:
    """Each planner's mean of the middle half of its episodes, which says nothing of its failures."""
    samples = [comparison.sample(planner, of) for planner in comparison.planners]
    return [text(bootstrapped(sample, interquartile_mean), metric(of)) for sample in samples]


def _percent(share: float) -> str:
    return "–" if math.isnan(share) else f"{100.0 * share:.1f}"


def _or_nothing(value: float) -> float:
    return -1.0 if math.isnan(value) else value
