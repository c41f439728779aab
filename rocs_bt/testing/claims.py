"""Claims about planners, as assertions that pass, fail, or are inconclusive."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest

from ..compare import Comparison
from ..compare.metric import HOLDS_PREFIX, MARGIN_PREFIX, metric
from ..compare.record import EpisodeRecord
from ..compare.replay import replay_command
from ..compare.statistics import LEVEL, Floats, upper_bound
from ..compare.verdict import Verdict
from ..words import counted

_TOLD = 5  # episodes that are listed
_MANY = 200  # times as many scenes, at most

Check = Callable[[str, str], Sequence[EpisodeRecord]]


class Inconclusive(Exception):
    """The episodes neither bear a claim out nor refute it."""


class Claims:
    """What tests say of the episodes of a comparison; the fixture `comparison`.

    Each assertion is one claim, whose confidence is its own. A claim that fails names the episodes that speak against
    it, each with the command that plays it again.

    Args:
        comparison: The episodes.
        check: Gives the episodes of a planner, played with one more requirement.

    Attributes:
        comparison: The episodes, for whatever else a test asks of them.
    """

    def __init__(self, comparison: Comparison, check: Check) -> None:
        self.comparison = comparison
        self._check = check

    def assert_better(
        self, a: str, b: str, metric: str = "success", *, margin: float = 0.0, level: float = LEVEL
    ) -> Verdict:
        """Planner a is better than planner b, by more than a margin.

        Args:
            a: A planner.
            b: Another.
            metric: In what.
            margin: By how much more than this, in the metric's unit.
            level: The confidence.

        Raises:
            Inconclusive: That cannot be told from these episodes.
        """
        return self._judged(self.comparison.verdict(a, b, metric, margin=margin, level=level))

    def assert_not_worse(
        self, a: str, b: str, metric: str = "success", *, margin: float, level: float = LEVEL
    ) -> Verdict:
        """Planner a is not worse than planner b by more than a margin: the whole interval lies above it.

        Args:
            a: A planner.
            b: Another, such as the one before a change.
            metric: In what.
            margin: How much worse would do, in the metric's unit; above 0.
            level: The confidence.

        Raises:
            Inconclusive: That cannot be told from these episodes.
        """
        if not margin > 0.0:
            raise ValueError(
                f"a margin is above 0, found {margin:g}: nobody is ever seen to be worse by nothing at all."
            )
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
        """The true share of successes, or of collisions, is at most `upper`, or at least `lower`, by its exact bound.

        Args:
            planner: Whose.
            metric: `success` or `collision`.
            upper: What it must not be above.
            lower: What it must not be below.
            level: The confidence of each.

        Raises:
            Inconclusive: That cannot be told from these episodes.
        """
        if (upper is None) == (lower is None):
            raise ValueError("say either upper=... or lower=... of a rate.")
        least, most = self.comparison.bounds(planner, metric, level)
        values = self.comparison.sample(planner, metric)
        limit = upper if upper is not None else lower or 0.0
        good, bad = (most <= limit, least > limit) if upper is not None else (least >= limit, most < limit)
        if good:
            return
        count = f"{np.nansum(values):g} of {counted(int((~np.isnan(values)).sum()), 'episode')}"
        words = "at most" if upper is not None else "at least"
        told = f"{planner}'s {metric} rate, {count}, is {least:.3g} at least and {most:.3g} at most ({level:.0%} each)"
        if bad:
            sign = 1.0 if upper is not None else 0.0
            against = [r for r in self.comparison.of(planner) if r.metrics.get(metric) == sign]
            pytest.fail(f"{told}, and so not {words} {limit:g}\n{_listed(against)}", pytrace=False)
        needed = _needed(values, upper, lower, level)
        more = f"; about {needed} {self.comparison.kind} would do" if needed else ""
        raise Inconclusive(f"inconclusive whether it is {words} {limit:g}: {told}{more}")

    def assert_always(self, planner: str, requirement: str) -> None:
        """A requirement holds at every moment of every episode, in the language of requirements.

        The planner's episodes are played once more, with the requirement watched; they are kept as others are.

        Args:
            planner: Whose.
            requirement: Such as `min(front) > 0.05 m`, with the robot's signals and the truth.

        Raises:
            Inconclusive: It is never violated, but in some episode it cannot be told.
            InputError: The requirement does not fit the robot.
        """
        text = requirement.strip()
        text = text if text.split()[:1] == ["always"] else f"always ({text})"
        records = self._check(planner, text)
        violated = [r for r in records if r.metrics.get(f"{HOLDS_PREFIX}{text}") == 0.0]
        if violated:
            least = sorted(violated, key=lambda r: _least(r, text))
            of = f"{len(violated)} of {counted(len(records), 'episode')}"
            head = f"{planner} violates '{requirement}' in {of}; the worst first"
            pytest.fail(f"{head}\n{_listed(least, lambda r: f'least margin {_least(r, text):.3g}')}", pytrace=False)
        unknown = [r for r in records if r.metrics.get(f"{HOLDS_PREFIX}{text}") is None]
        if unknown:
            of = f"{len(unknown)} of {counted(len(records), 'episode')}"
            head = f"'{requirement}' is violated nowhere, but cannot be told in {of}"
            raise Inconclusive(f"{head}\n{_listed(unknown)}")

    def _judged(self, verdict: Verdict) -> Verdict:
        if verdict.word == "better":
            return verdict
        text = f"{verdict}\n{self._against(verdict)}"
        if verdict.word == "not better":
            pytest.fail(text, pytrace=False)
        raise Inconclusive(text)

    def _against(self, verdict: Verdict) -> str:
        """The episodes that speak against a claim, those most that do it most."""
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
            return f"In no episode is {verdict.b} better."
        lines = [f"In {len(lost)} of {counted(verdict.episodes, 'episode')} {verdict.b} is better:"]
        for _, one, other in lost[:_TOLD]:
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


def _listed(records: Sequence[EpisodeRecord], told: Callable[[EpisodeRecord], str] = _ended) -> str:
    lines = [f"  {r.scene} seed {r.seed}: {told(r)}\n    {replay_command(r)}" for r in records[:_TOLD]]
    if (more := len(records) - _TOLD) > 0:
        lines.append(f"  and {more} more")
    return "\n".join(lines)


def _needed(values: Floats, upper: float | None, lower: float | None, level: float) -> int:
    """How many scenes like these would be enough; 0 where no number would."""
    bad, limit = (values, upper) if upper is not None else (1.0 - values, 1.0 - (lower or 0.0))
    for times in range(2, _MANY):
        if limit is not None and upper_bound(np.tile(bad, (times, 1)), level) <= limit:
            return times * len(bad)
    return 0
