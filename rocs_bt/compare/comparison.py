"""Comparison: episodes of several planners in the same scenes, with estimates per planner and verdicts per pair."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np
import numpy.typing as npt

from ..base.errors import InputError, UnknownName, unknown
from .metric import BARN_YEARS, HOLDS_PREFIX, SHARES, ZERO_ON_FAILURE, Metric, metric
from .record import EpisodeRecord
from .statistics import (
    LEVEL,
    Estimate,
    Floats,
    SampleSize,
    equal,
    lower_bound,
    mean_over_scenes,
    rate,
    sample_size,
    upper_bound,
)
from .verdict import Verdict, adjusted, judge

_SPANS = dict.fromkeys((*SHARES, "spl", "path_efficiency", "intimate", "personal", "reflex_share"), 1.0) | {
    year: 1.0 / low for year, (low, _) in BARN_YEARS.items()
}


@dataclass(frozen=True)
class Disagreement:
    """Two episodes of the same scene and seed, of which exactly one succeeded."""

    winner: EpisodeRecord
    loser: EpisodeRecord


class Comparison:
    """Episodes of several planners in the same scenes, with the statistics of their metrics.

    With several scenes, the scenes are the sample units, since episodes of one scene with different seeds are
    correlated. With a single scene, the seeds are the sample units, and all statements apply to that scene only.

    Args:
        records: Episodes; scenes keep their order of first occurrence, which sequential verdicts use.

    Attributes:
        planners: Planner names, in order of first occurrence.
        scenes: Scene names, in order of first occurrence.
        seeds: Seeds in ascending order.

    Raises:
        InputError: There are no episodes, or two different episodes share a planner, scene and seed.
    """

    def __init__(self, records: Iterable[EpisodeRecord]) -> None:
        self._records: dict[tuple[str, str, int], EpisodeRecord] = {}
        for record in records:
            index = record.planner, record.scene, record.seed
            if self._records.setdefault(index, record).key != record.key:
                raise InputError(
                    f"two different episodes of {record.planner} in {record.scene} with seed {record.seed}: "
                    "the planner or the scene changed between them. Compare episodes of one version of both."
                )
        if not self._records:
            raise InputError("No episodes to compare. Run a sweep first.")
        self.planners = tuple(dict.fromkeys(planner for planner, _, _ in self._records))
        self.scenes = tuple(dict.fromkeys(scene for _, scene, _ in self._records))
        self.seeds = tuple(sorted({seed for _, _, seed in self._records}))

    @property
    def records(self) -> tuple[EpisodeRecord, ...]:
        """All episodes."""
        return tuple(self._records.values())

    @cached_property
    def time_limit(self) -> float:
        """Longest time limit of all episodes [s]."""
        return max(record.time_limit for record in self._records.values())

    @property
    def kind(self) -> str:
        """Sample units in words: `scenes`, or `seeds of one scene`."""
        return "scenes" if len(self.scenes) > 1 else "seeds of one scene"

    def of(self, planner: str) -> list[EpisodeRecord]:
        """Episodes of a planner.

        Raises:
            UnknownName: The planner has no episodes.
        """
        if planner not in self.planners:
            raise UnknownName(unknown("planner", planner, self.planners))
        return [record for (name, _, _), record in self._records.items() if name == planner]

    def find(self, planner: str, scene: str, seed: int) -> EpisodeRecord | None:
        """One episode, or None if it was not played."""
        return self._records.get((planner, scene, seed))

    def values(self, planner: str, of: str | Metric) -> Floats:
        """Metric values of all episodes of a planner.

        Returns:
            Values, shape (n_scenes, n_seeds); NaN if the episode is missing or the metric is undefined for it.

        Raises:
            UnknownName: The planner or metric does not exist.
        """
        name = _metric(of).name
        found = np.full((len(self.scenes), len(self.seeds)), math.nan)
        rows = {scene: i for i, scene in enumerate(self.scenes)}
        columns = {seed: i for i, seed in enumerate(self.seeds)}
        for record in self.of(planner):
            value = record.metrics.get(name) if record.metrics else self._on_error(name)
            if value is not None and math.isfinite(value):
                found[rows[record.scene], columns[record.seed]] = value
        return found

    def _on_error(self, name: str) -> float | None:
        """Metric value of an episode that ended in an error without measurements: it counts as a failure."""
        return self.time_limit if name == "time" else 0.0 if name in ZERO_ON_FAILURE else None

    def estimate(self, planner: str, of: str | Metric, where: npt.NDArray[np.bool_] | None = None) -> Estimate:
        """Mean of a metric over the episodes of a planner, with a confidence interval within the metric's range.

        Args:
            planner: Name of the planner.
            of: The metric.
            where: Mask of the episodes to include, of the shape of `sample`; all by default.
        """
        values, most = self.sample(planner, of), self.span(of)
        values = values if where is None else np.where(where, values, math.nan)
        if _metric(of).name in SHARES or _metric(of).name.startswith(HOLDS_PREFIX):
            return rate(values)
        found = mean_over_scenes(values, unseen=self._unseen(planner, of, values))
        if math.isnan(most):
            return found
        return replace(found, low=float(np.maximum(found.low, 0.0)), high=float(np.minimum(found.high, most)))

    def _unseen(self, planner: str, of: str | Metric, values: Floats) -> tuple[float, ...]:
        """Values of a metric that further episodes may have although no episode of a planner has them."""
        name, span, succeeded = _metric(of).name, self.span(of), self.sample(planner, "success")
        known, failure = values[~np.isnan(values)], self._on_error(name)
        if len(known) == 0 or math.isnan(span):
            return ()
        if equal(known) or np.nanmax(succeeded) == 0.0:
            return 0.0, span
        return (failure,) if failure is not None and np.nanmin(succeeded) == 1.0 else ()

    def size(self, planner: str, of: str | Metric = "success") -> SampleSize:
        """Sample size and effective sample size of a planner for a metric."""
        return sample_size(self.sample(planner, of))

    def bounds(self, planner: str, of: str | Metric, level: float = LEVEL) -> tuple[float, float]:
        """One-sided lower and upper confidence bounds of the true share of a planner's episodes (SHARES).

        Raises:
            InputError: The metric is not a share.
        """
        if _metric(of).name not in SHARES:
            raise InputError(
                f"{_metric(of).name} is not a share, and only shares have exact bounds: {', '.join(SHARES)}."
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
        """Verdict on the claim that planner a is better than planner b by more than a margin.

        Metrics with `until_failure` are compared on the episodes in which both succeed.

        Args:
            a: Name of a planner.
            b: Name of another planner.
            of: The metric.
            margin: Margin in the metric's unit; a negative margin claims that a is not worse than b by more than its
                absolute value.
            level: Confidence level.
            any_time: Whether the verdict must stay valid if it is computed repeatedly while episodes are added
                (sequential testing).
            claims: Number of claims that are tested together; more claims need more scenes.

        Raises:
            InputError: The planner or metric does not exist, or `any_time` is set for a metric without a bound.
        """
        what = _metric(of)
        span = self.span(what)
        if any_time and math.isnan(span):
            known = ", ".join([*_SPANS, "time"])
            message = f"no any-time verdict on {what.name}, since its differences are unbounded."
            raise InputError(f"{message} Bounded metrics: {known}.")
        values = self.sample(a, what), self.sample(b, what)
        if what.until_failure:
            failed = (self.sample(a, "success") != 1.0) | (self.sample(b, "success") != 1.0)
            values = np.where(failed, math.nan, values[0]), np.where(failed, math.nan, values[1])
        found = judge((a, b), values, what, margin=margin, level=level, span=span, any_time=any_time, claims=claims)
        return found if len(self.scenes) > 1 else replace(found, scenes=1)

    def verdicts(self, of: Sequence[str | Metric] = ("success",), *, any_time: bool = False) -> list[Verdict]:
        """Verdicts on all pairs of planners for some metrics, adjusted for multiple claims (Holm)."""
        pairs = list(combinations(self.planners, 2))
        claims = len(of) * len(pairs)
        return adjusted([self.verdict(a, b, m, any_time=any_time, claims=claims) for m in of for a, b in pairs])

    def settled(self, of: Sequence[str | Metric] = ("success",)) -> bool:
        """Whether all pairs of planners have a conclusive verdict in all metrics, so that a sweep may stop.

        It may be called after every scene, if the scenes are complete (all planners, all seeds) and in order. Verdicts
        of a sweep that was stopped this way need `any_time`.
        """
        return all(verdict.word != "inconclusive" for verdict in self.verdicts(of, any_time=True))

    def span(self, of: str | Metric) -> float:
        """Greatest possible difference of a metric between two episodes, in the metric's unit; NaN if unbounded."""
        name = _metric(of).name
        return self.time_limit if name == "time" else _SPANS.get(name, math.nan)

    def sample(self, planner: str, of: str | Metric) -> Floats:
        """Metric values with one row per sample unit: per scene, or per seed of a single scene.

        Returns:
            Values, shape (n, m); NaN if the episode is missing or the metric is undefined for it.
        """
        values = self.values(planner, of)
        return values if len(self.scenes) > 1 else values.T

    def disagreements(self, a: str, b: str) -> list[Disagreement]:
        """Episode pairs in which exactly one of two planners succeeds, ordered by scene and seed."""
        found = []
        for scene in self.scenes:
            for seed in self.seeds:
                one, other = self.find(a, scene, seed), self.find(b, scene, seed)
                if one and other and one.success != other.success:
                    found.append(Disagreement(one, other) if one.success else Disagreement(other, one))
        return found

    def outcomes(self, planner: str) -> Mapping[str, int]:
        """Number of episodes of a planner by outcome."""
        found: dict[str, int] = {}
        for record in self.of(planner):
            found[record.outcome] = found.get(record.outcome, 0) + 1
        return found


def _metric(of: str | Metric) -> Metric:
    return metric(of) if isinstance(of, str) else of
