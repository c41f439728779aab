"""Verdict on whether one planner is better than another: better, not better, or inconclusive, with its evidence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

import numpy as np

from ..base.words import counted
from .metric import Metric
from .statistics import (
    LEVEL,
    Floats,
    always_valid,
    holm,
    mean_difference,
    paired,
    scenes_needed,
    sign_flip_test,
    superiority,
)

Word = Literal["better", "not better", "inconclusive"]


@dataclass(frozen=True)
class Verdict:
    """Result of testing the claim that a is better than b by more than a margin.

    Attributes:
        word: `better`, `not better` (b is at least as good, or the margin is not reached), or `inconclusive`.
        a: Planner claimed to be better.
        b: The other planner.
        metric: Name of the metric.
        unit: Unit of the metric.
        margin: Claimed minimum difference, in the metric's unit; negative for "not worse by".
        difference: Mean advantage of a; positive means better for either direction of the metric.
        low: Lower end of the confidence interval of the difference.
        high: Upper end of the confidence interval.
        p: Two-sided p value of the difference against the margin; adjusted if several claims are tested together.
        superiority: Probability that a beats b in an episode of the same scene and seed; ties count half.
        scenes: Number of scenes in which both planners have values.
        episodes: Number of pairs of episodes with the same scene and seed in which both planners have values.
        apart: Number of these episodes in which the two planners have different values.
        needed: Estimated total number of scenes (of a single scene: seeds) for a conclusive verdict at this difference;
            None if conclusive or not estimable.
    """

    word: Word
    a: str
    b: str
    metric: str
    unit: str
    margin: float
    difference: float
    low: float
    high: float
    p: float
    superiority: float
    scenes: int
    episodes: int
    apart: int
    needed: int | None

    def as_dict(self) -> dict[str, Any]:
        """Verdict as a dict for JSON; NaN becomes None."""
        return {k: None if isinstance(v, float) and math.isnan(v) else v for k, v in asdict(self).items()}

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        scenes = self.scenes > 1
        kind = "scenes" if scenes else "seeds"
        sample = counted(self.scenes, "scene") if scenes else f"{counted(self.episodes, 'seed')} of one scene"
        ends = "" if math.isnan(self.low) else f" [{self.low:+.3g}, {self.high:+.3g}]"
        evidence = f"{self.difference:+.3g}{unit}{ends}, p {self.p:.2g}"
        more = f"; about {self.needed} {kind} needed" if self.needed else ""
        return f"{self._claim(unit)} in {self.metric}: {evidence}, {sample}{more}"

    def _claim(self, unit: str) -> str:
        by = f" by more than {abs(self.margin):g}{unit}" if self.margin else ""
        yes, no = ("not worse", "worse") if self.margin < 0.0 else ("better", "not better")
        if self.word == "inconclusive":
            return f"inconclusive whether {self.a} is {yes} than {self.b}{by}"
        return f"{self.a} is {yes if self.word == 'better' else no} than {self.b}{by}"


def judge(
    names: tuple[str, str],
    values: tuple[Floats, Floats],
    metric: Metric,
    *,
    margin: float = 0.0,
    level: float = LEVEL,
    span: float = math.nan,
    any_time: bool = False,
    claims: int = 1,
) -> Verdict:
    """Test one claim.

    A verdict is conclusive only if a confidence interval over scenes and a sign-flip test over whole scenes agree. The
    interval does not assume a symmetric distribution; the test is valid for any number of differing scenes. With
    `any_time` a betting test replaces both.

    Args:
        names: Planners a and b.
        values: Values of each planner, shape (n_scenes, n_seeds), NaN if missing; scenes in sampling order.
        metric: Metric of the values.
        margin: Claimed minimum difference.
        level: Confidence level.
        span: Greatest possible difference; NaN if unbounded.
        any_time: Whether the verdict must stay valid if it is computed repeatedly while episodes are added; needs a
            span.
        claims: Number of claims tested together, used for `needed`.
    """
    sign = 1.0 if metric.direction == "up" else -1.0
    a, b = (sign * each for each in values)
    differences = paired(a, b)
    whole = _lattice(a, b) if margin == 0.0 else 0
    if any_time:
        found, p = always_valid(differences, span, margin, level)
    else:
        found, p = mean_difference(differences, level, span), sign_flip_test(differences - margin, whole)
    episodes = ~np.isnan(a - b)
    needed = scenes_needed(differences, margin, 1.0 - (1.0 - level) / claims)
    verdict = Verdict(
        word="inconclusive",
        a=names[0],
        b=names[1],
        metric=metric.name,
        unit=metric.unit,
        margin=margin,
        difference=found.value,
        low=found.low,
        high=found.high,
        p=p,
        superiority=superiority(a, b).value,
        scenes=len(differences),
        episodes=int(episodes.sum()),
        apart=int((a != b)[episodes].sum()),
        needed=needed and max(needed, len(differences) + 1),
    )
    return _decided(verdict, p, level)


def adjusted(verdicts: Sequence[Verdict]) -> list[Verdict]:
    """Verdicts adjusted for testing several claims together, by controlling the family-wise error rate (Holm, 1979)."""
    p = holm(np.array([verdict.p for verdict in verdicts]))
    return [_decided(verdict, float(each), LEVEL) for verdict, each in zip(verdicts, p, strict=True)]


def swapped(verdict: Verdict) -> Verdict:
    """The same verdict with the planners swapped; valid only for verdicts without a margin."""
    words: dict[Word, Word] = {"better": "not better", "not better": "better"}
    return replace(
        verdict,
        word=words.get(verdict.word, verdict.word),
        a=verdict.b,
        b=verdict.a,
        difference=-verdict.difference,
        low=-verdict.high,
        high=-verdict.low,
        superiority=1.0 - verdict.superiority,
    )


def favourable(verdict: Verdict) -> Verdict:
    """The same verdict stated as a claim on the better planner; verdicts with a margin stay unchanged."""
    return swapped(verdict) if verdict.difference < 0.0 and not verdict.margin else verdict


def _decided(verdict: Verdict, p: float, level: float) -> Verdict:
    significant = p <= 1.0 - level + 1e-12
    word: Word = "inconclusive"
    if significant and verdict.low > verdict.margin:
        word = "better"
    elif significant and verdict.high < verdict.margin:
        word = "not better"
    return replace(verdict, word=word, p=p, needed=verdict.needed if word == "inconclusive" else None)


def _lattice(a: Floats, b: Floats) -> int:
    """Number of seeds if all values are 0 or 1, so that scene means are multiples of 1 / seeds; else 0."""
    difference = a - b
    whole = not np.isnan(difference).any() and bool(np.isin(difference, (-1.0, 0.0, 1.0)).all())
    return difference.shape[1] if whole else 0
