"""Comparison: the episodes of several planners in the same scenes, and what they say of each planner and each pair."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np

from ..errors import InputError, UnknownName, unknown
from .metric import BARN_YEARS, SHARES, ZERO_ON_FAILURE, Metric, metric
from .record import EpisodeRecord
from .statistics import (
    LEVEL,
    Estimate,
    Floats,
    SampleSize,
    lower_bound,
    mean_over_scenes,
    rate,
    sample_size,
    upper_bound,
)
from .verdict import Verdict, adjusted, judge

_SPANS = {"success": 1.0, "collision": 1.0, "spl": 1.0, "reflex_share": 1.0} | {
    year: 1.0 / low for year, (low, _) in BARN_YEARS.items()
}


@dataclass(frozen=True)
class Disagreement:
    """An episode in which one planner succeeds and another does not: same scene, same seed.

    Attributes:
        winner: The episode that succeeded.
        loser: The other's.
    """

    winner: EpisodeRecord
    loser: EpisodeRecord


class Comparison:
    """Episodes by planner, scene and seed.

    Scenes are the sample from which it judges, and their seeds are alike. Of a single scene the seeds are the sample,
    and what it says is said of that scene alone.

    Args:
        records: The episodes; scenes keep the order in which they first come, which is that of sequential verdicts.

    Attributes:
        planners: Their names, in the order in which they first come.
        scenes: Likewise.
        seeds: In ascending order.

    Raises:
        InputError: Two different episodes are of one planner, scene and seed, or there are none.
    """

    def __init__(self, records: Iterable[EpisodeRecord]) -> None:
        self._records: dict[tuple[str, str, int], EpisodeRecord] = {}
        for record in records:
            place = record.planner, record.scene, record.seed
            if self._records.setdefault(place, record).key != record.key:
                raise InputError(
                    f"two different episodes are of {record.planner} in {record.scene} with seed {record.seed}: "
                    "the planner or the scene has changed meanwhile. Compare what was made with one version of both."
                )
        if not self._records:
            raise InputError("there are no episodes to compare. Run a sweep first.")
        self.planners = tuple(dict.fromkeys(planner for planner, _, _ in self._records))
        self.scenes = tuple(dict.fromkeys(scene for _, scene, _ in self._records))
        self.seeds = tuple(sorted({seed for _, _, seed in self._records}))

    @property
    def records(self) -> tuple[EpisodeRecord, ...]:
        """All episodes."""
        return tuple(self._records.values())

    @cached_property
    def time_limit(self) -> float:
        """The longest that an episode may take [s]."""
        return max(record.time_limit for record in self._records.values())

    @property
    def kind(self) -> str:
        """What the sample consists of."""
        return "scenes" if len(self.scenes) > 1 else "seeds of one scene"

    def of(self, planner: str) -> list[EpisodeRecord]:
        """A planner's episodes.

        Raises:
            UnknownName: It has none.
        """
        if planner not in self.planners:
            raise UnknownName(unknown("planner", planner, self.planners))
        return [record for (name, _, _), record in self._records.items() if name == planner]

    def find(self, planner: str, scene: str, seed: int) -> EpisodeRecord | None:
        """One episode; None where it has not been run."""
        return self._records.get((planner, scene, seed))

    def values(self, planner: str, of: str | Metric) -> Floats:
        """A metric of every episode of a planner.

        Returns:
            (n_scenes, n_seeds) NaN where there is no such episode, or it says nothing of it.

        Raises:
            UnknownName: There is no such planner or metric.
        """
        name = _metric(of).name
        found = np.full((len(self.scenes), len(self.seeds)), math.nan)
        rows = {scene: i for i, scene in enumerate(self.scenes)}
        columns = {seed: i for i, seed in enumerate(self.seeds)}
        for record in self.of(planner):
            value = record.metrics.get(name) if record.metrics else self._broken(name)
            if value is not None and math.isfinite(value):
                found[rows[record.scene], columns[record.seed]] = value
        return found

    def _broken(self, name: str) -> float | None:
        """What a metric is where an episode broke down before anything could be measured: a failure counts as one."""
        return self.time_limit if name == "time" else 0.0 if name in ZERO_ON_FAILURE else None

    def estimate(self, planner: str, of: str | Metric) -> Estimate:
        """A planner's mean of a metric over all its episodes, with its interval, which ends where the metric does."""
        values, most = self.sample(planner, of), self.span(of)
        if _metric(of).name in SHARES:
            return rate(values)
        found = mean_over_scenes(values)
        if math.isnan(most):
            return found
        return replace(found, low=float(np.maximum(found.low, 0.0)), high=float(np.minimum(found.high, most)))

    def size(self, planner: str, of: str | Metric = "success") -> SampleSize:
        """How much a planner's episodes are worth, for a metric."""
        return sample_size(self.sample(planner, of))

    def bounds(self, planner: str, of: str | Metric, level: float = LEVEL) -> tuple[float, float]:
        """What a planner's true share of successes or collisions is at least, and at most: each with the confidence.

        Raises:
            InputError: The metric is no share.
        """
        if _metric(of).name not in SHARES:
            raise InputError(
                f"only a share has an exact bound, and {_metric(of).name} is none. {' and '.join(SHARES)} are."
            )
        values = self.sample(planner, of)
        return lower_bound(values, level), upper_bound(values, level)

    def verdict(
        self,
        a: str,
        b: str,
        of: str | Metric = "success",
        *,
        margin: float = 0.0,
        level: float = LEVEL,
        any_time: bool = False,
        claims: int = 1,
    ) -> Verdict:
        """Whether planner a is better than planner b by more than a margin.

        What tells of the way until a failure is compared on the episodes in which both succeed.

        Args:
            a: A planner.
            b: Another.
            of: The metric.
            margin: By how much more than this, in the metric's unit; below 0 for "not worse by".
            level: The verdict's confidence.
            any_time: Whether it must hold however often one looked before.
            claims: How many verdicts are looked at together: who makes many needs more scenes to settle one.

        Raises:
            InputError: There is no such planner or metric, or the metric has no bound and must hold at any time.
        """
        what = _metric(of)
        span = self.span(what)
        if any_time and math.isnan(span):
            known = ", ".join([*_SPANS, "time"])
            message = f"a verdict on {what.name} cannot hold at any time, since its differences have no bound."
            raise InputError(f"{message} These have: {known}.")
        values = self.sample(a, what), self.sample(b, what)
        if what.on_failure == "until_failure":
            failed = (self.sample(a, "success") != 1.0) | (self.sample(b, "success") != 1.0)
            values = np.where(failed, math.nan, values[0]), np.where(failed, math.nan, values[1])
        found = judge((a, b), values, what, margin=margin, level=level, span=span, any_time=any_time, claims=claims)
        return found if len(self.scenes) > 1 else replace(found, scenes=1)

    def verdicts(
        self, of: Sequence[str | Metric] = ("success",), *, level: float = LEVEL, any_time: bool = False
    ) -> list[Verdict]:
        """The verdict on every pair in some metrics, judged together (Holm)."""
        pairs = list(combinations(self.planners, 2))
        claims = len(of) * len(pairs)
        found = [self.verdict(a, b, m, level=level, any_time=any_time, claims=claims) for m in of for a, b in pairs]
        return adjusted(found, level)

    def settled(self, of: Sequence[str | Metric] = ("success",), *, level: float = LEVEL) -> bool:
        """Whether every pair is told apart in every metric, so that a sweep may stop.

        It may be asked after every scene, if scenes come in their order and whole: for every planner, with all seeds.
        Verdicts that follow must be asked for with `any_time`.
        """
        return all(verdict.word != "inconclusive" for verdict in self.verdicts(of, level=level, any_time=True))

    def span(self, of: str | Metric) -> float:
        """The greatest difference possible between two episodes, in the metric's unit; NaN where there is no bound."""
        name = _metric(of).name
        return self.time_limit if name == "time" else _SPANS.get(name, math.nan)

    def sample(self, planner: str, of: str | Metric) -> Floats:
        """A metric by what is independent of each other, a row each: scenes, or the seeds of a single one.

        Returns:
            (n, m) NaN where there is no such episode, or it says nothing of it.
        """
        values = self.values(planner, of)
        return values if len(self.scenes) > 1 else values.T

    def disagreements(self, a: str, b: str) -> list[Disagreement]:
        """The episodes in which just one of two planners succeeds, in the order of scenes and seeds."""
        found = []
        for scene in self.scenes:
            for seed in self.seeds:
                one, other = self.find(a, scene, seed), self.find(b, scene, seed)
                if one and other and one.success != other.success:
                    found.append(Disagreement(one, other) if one.success else Disagreement(other, one))
        return found

    def outcomes(self, planner: str) -> Mapping[str, int]:
        """How often each outcome came of a planner's episodes."""
        found: dict[str, int] = {}
        for record in self.of(planner):
            found[record.outcome] = found.get(record.outcome, 0) + 1
        return found


def _metric(of: str | Metric) -> Metric:
    return metric(of) if isinstance(of, str) else of
