"""Claims about planners as assertions that pass, fail, or are inconclusive."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest

from ..base.words import counted
from ..compare import Comparison
from ..compare.metric import HOLDS_PREFIX, MARGIN_PREFIX, metric
from ..compare.record import EpisodeRecord
from ..compare.replay import replay_command
from ..compare.statistics import LEVEL, Floats, upper_bound
from ..compare.verdict import Verdict

_LISTED = 5  # maximum number of listed episodes
_MAX_FACTOR = 200  # largest multiple of the sample size that `_needed` tries

Check = Callable[[str, str], Sequence[EpisodeRecord]]


class Inconclusive(Exception):
    """Exception: the episodes neither confirm nor refute a claim."""


class Claims:
    """Assertions about the episodes of a comparison; tests get them as the fixture `comparison`.

    Each assertion is one claim with its own confidence level. A failed claim lists the episodes against it, each with
    the command that replays it.

    Args:
        comparison: The episodes.
        check: Function of a planner's name and a requirement's text, which returns the planner's episodes, played while
            this requirement is monitored.

    Attributes:
        comparison: The episodes, for other assertions.
    """

    def __init__(self, comparison: Comparison, check: Check) -> None:
        self.comparison = comparison
        self._check = check

    def assert_better(
        self, a: str, b: str, metric: str = "success", *, margin: float = 0.0, level: float = LEVEL
    ) -> Verdict:
        """Assert that planner `a` is better than planner `b` by more than a margin.

        Args:
            a: Name of a planner.
            b: Name of another planner.
            metric: The metric.
            margin: Advantage that must be exceeded, in the metric's unit.
            level: Confidence level.

        Raises:
            Inconclusive: The episodes do not decide the claim.
        """
        return self._judged(self.comparison.verdict(a, b, metric, margin=margin, level=level))

    def assert_not_worse(
        self, a: str, b: str, metric: str = "success", *, margin: float, level: float = LEVEL
    ) -> Verdict:
        """Assert that planner `a` is worse than planner `b` by at most a margin.

        The whole confidence interval of the advantage of `a` must lie above `-margin`.

        Args:
            a: Name of a planner.
            b: Name of another planner, such as the version before a change.
            metric: The metric.
            margin: Largest accepted disadvantage, in the metric's unit; above 0.
            level: Confidence level.

        Raises:
            Inconclusive: The episodes do not decide the claim.
        """
        if not margin > 0.0:
            raise ValueError(f"the margin must be above 0, found {margin:g}: no sample can confirm a margin of 0.")
        return self._judged(self.comparison.verdict(a, b, metric, margin=-margin, level=level))

    def assert_rate(
        self,
        planner: str,
        metric: str = "success",
        *,
        upper: float | None = None,
        lower: float | None = None,
        level: float = LEVEL,
    ) -> None:
        """Assert that a planner's true rate is at most `upper`, or that it is at least `lower`.

        The exact confidence bound of the rate decides; exactly one of the two limits must be given.

        Args:
            planner: Name of the planner.
            metric: `success`, `collision`, `fell` or `clean`.
            upper: Upper limit of the rate.
            lower: Lower limit of the rate.
            level: Confidence level of the bound, which is one-sided.

        Raises:
            Inconclusive: The episodes do not decide the claim.
        """
        if (upper is None) == (lower is None):
            raise ValueError("give either upper= or lower=.")
        least, most = self.comparison.bounds(planner, metric, level)
        values = self.comparison.sample(planner, metric)
        limit = upper if upper is not None else lower or 0.0
        good, bad = (most <= limit, least > limit) if upper is not None else (least >= limit, most < limit)
        if good:
            return
        count = f"{np.nansum(values):g} of {counted(int((~np.isnan(values)).sum()), 'episode')}"
        words = "at most" if upper is not None else "at least"
        found = f"{planner}'s {metric} rate, {count}, is at least {least:.3g} and at most {most:.3g} ({level:.0%} each)"
        if bad:
            sign = 1.0 if upper is not None else 0.0
            against = [r for r in self.comparison.of(planner) if r.metrics.get(metric) == sign]
            pytest.fail(f"{found}, and so not {words} {limit:g}\n{_listed(against)}", pytrace=False)
        needed = _needed(values, upper, lower, level)
        more = f"; about {needed} {self.comparison.kind} needed" if needed else ""
        raise Inconclusive(f"inconclusive whether it is {words} {limit:g}: {found}{more}")

    def assert_always(self, planner: str, requirement: str) -> None:
        """Assert that a requirement holds at every moment of every episode.

        The planner's episodes are played again, with the requirement monitored, and stored like other episodes.

        Args:
            planner: Name of the planner.
            requirement: Expression over the robot's signals and the ground truth, such as `min(front) > 0.05 m`.

        Raises:
            Inconclusive: No episode violates the requirement, but in some episodes its value is unknown.
            InputError: The requirement does not fit the robot.
        """
        text = requirement.strip()
        text = text if text.split()[:1] == ["always"] else f"always ({text})"
        records = self._check(planner, text)
        violated = [r for r in records if r.metrics.get(f"{HOLDS_PREFIX}{text}") == 0.0]
        if violated:
            least = sorted(violated, key=lambda r: _least(r, text))
            of = f"{len(violated)} of {counted(len(records), 'episode')}"
            head = f"{planner} violates '{requirement}' in {of}; worst first"
            pytest.fail(f"{head}\n{_listed(least, lambda r: f'least margin {_least(r, text):.3g}')}", pytrace=False)
        unknown = [r for r in records if r.metrics.get(f"{HOLDS_PREFIX}{text}") is None]
        if unknown:
            of = f"{len(unknown)} of {counted(len(records), 'episode')}"
            head = f"no episode violates '{requirement}', but its value is unknown in {of}"
            raise Inconclusive(f"{head}\n{_listed(unknown)}")

    def _judged(self, verdict: Verdict) -> Verdict:
        if verdict.word == "better":
            return verdict
        text = f"{verdict}\n{self._against(verdict)}"
        if verdict.word == "not better":
            pytest.fail(text, pytrace=False)
        raise Inconclusive(text)

    def _against(self, verdict: Verdict) -> str:
        """Lines about the episodes in which planner `b` was better, the largest differences first."""
        name = verdict.metric
        sign = 1.0 if metric(name).direction == "up" else -1.0
        lost: list[tuple[float, EpisodeRecord, EpisodeRecord]] = []
        for one in self.comparison.of(verdict.a):
            other = self.comparison.find(verdict.b, one.scene, one.seed)
            mine, theirs = one.metrics.get(name), other.metrics.get(name) if other else None
            if other is not None and mine is not None and theirs is not None and sign * (theirs - mine) > 0.0:
                lost.append((sign * (theirs - mine), one, other))
        lost.sort(key=lambda found: -found[0])
        if not lost:
            return f"{verdict.b} is better in no episode."
        lines = [f"{verdict.b} is better in {len(lost)} of {counted(verdict.episodes, 'episode')}:"]
        for _, one, other in lost[:_LISTED]:
            ends = f"{one.planner} {_ended(one)}, {other.planner} {_ended(other)}"
            lines.append(
                f"  {one.scene} seed {one.seed}: {name} {one.metrics[name]:g} and {other.metrics[name]:g}; {ends}"
            )
            lines += [f"    {replay_command(each)}" for each in (one, other)]
        return "\n".join(lines)


def _ended(record: EpisodeRecord) -> str:
    return f"{record.outcome} at {record.sim_time:.1f} s"


def _least(record: EpisodeRecord, text: str) -> float:
    margin = record.metrics.get(f"{MARGIN_PREFIX}{text}")
    return -math.inf if margin is None else margin


def _listed(records: Sequence[EpisodeRecord], describe: Callable[[EpisodeRecord], str] = _ended) -> str:
    lines = [f"  {r.scene} seed {r.seed}: {describe(r)}\n    {replay_command(r)}" for r in records[:_LISTED]]
    if (more := len(records) - _LISTED) > 0:
        lines.append(f"  and {more} more")
    return "\n".join(lines)


def _needed(values: Floats, upper: float | None, lower: float | None, level: float) -> int:
    """Estimate the number of scenes that would confirm a claim about a rate if their results were like `values`.

    Returns 0 if no tried number would confirm it.
    """
    bad, limit = (values, upper) if upper is not None else (1.0 - values, 1.0 - (lower or 0.0))
    for times in range(2, _MAX_FACTOR):
        if limit is not None and upper_bound(np.tile(bad, (times, 1)), level) <= limit:
            return times * len(bad)
    return 0
