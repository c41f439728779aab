"""Verdict: is one planner better than another? Better, not better, or inconclusive, and what it rests on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

import numpy as np

from ..words import counted
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
    """What became of the claim that a is better than b by more than a margin.

    Attributes:
        word: `better`, `not better` (b is at least as good, or the margin is not reached), or `inconclusive`.
        a: The planner that is claimed to be better.
        b: The other.
        metric: The metric's name.
        unit: Its unit.
        margin: By how much more than this a is claimed to be better, in the metric's unit; below 0 for "not worse by".
        difference: How much better a is on average: above 0 is better, whichever way the metric counts.
        low: The lower end of its interval.
        high: The upper end.
        p: How likely a difference so far from the margin is where there is none; adjusted where several claims were
            looked at together.
        superiority: How likely a is better than b in an episode of the same scene and seed, ties counted half.
        scenes: In how many scenes both were measured.
        episodes: In how many episodes of the same scene and seed.
        apart: In how many of these they differ.
        needed: How many scenes in all (of a single scene: seeds) would probably settle it, going by this difference;
            None where that cannot be told, or it is settled.
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
        """As JSON has it, which knows no NaN."""
        return {k: None if isinstance(v, float) and math.isnan(v) else v for k, v in asdict(self).items()}

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        scenes = self.scenes > 1
        kind = "scenes" if scenes else "seeds"
        sample = counted(self.scenes, "scene") if scenes else f"{counted(self.episodes, 'seed')} of one scene"
        ends = "" if math.isnan(self.low) else f" [{self.low:+.3g}, {self.high:+.3g}]"
        told = f"{self.difference:+.3g}{unit}{ends}, p {self.p:.2g}"
        more = f"; about {self.needed} {kind} would settle it" if self.needed else ""
        return f"{self._claim(unit)} in {self.metric}: {told}, {sample}{more}"

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
    """Judge one claim.

    It takes an interval and a test to agree: an interval over scenes, which assumes no symmetry, and
    flips of whole scenes, which need none on how many differ. With `any_time` betting takes the place of both.

    Args:
        names: The planners a and b.
        values: (n_scenes, n_seeds) For each, NaN where there is none; in the order in which scenes were drawn.
        metric: What the values are.
        margin: By how much more than this a is claimed to be better.
        level: The confidence.
        span: The greatest difference that is possible; NaN where there is no such bound.
        any_time: Whether the verdict must hold however often one looked before; needs a span.
        claims: How many are looked at together, with which `needed` reckons.
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
    needed = scenes_needed(differences, margin, level=1.0 - (1.0 - level) / claims)
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


def adjusted(verdicts: Sequence[Verdict], level: float = LEVEL) -> list[Verdict]:
    """Verdicts that were looked at together, so that any false one is as rare as if there were one (Holm, 1979)."""
    p = holm(np.array([verdict.p for verdict in verdicts]))
    return [_decided(verdict, float(each), level) for verdict, each in zip(verdicts, p, strict=True)]


def swapped(verdict: Verdict) -> Verdict:
    """The same verdict without a margin, told of the other planner: `not better` becomes `better`, and back."""
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
    """The same verdict, told of the planner that did better; one with a margin is left as it is."""
    return swapped(verdict) if verdict.difference < 0.0 and not verdict.margin else verdict


def _decided(verdict: Verdict, p: float, level: float) -> Verdict:
    told = p <= 1.0 - level + 1e-12
    word: Word = "inconclusive"
    if told and verdict.low > verdict.margin:
        word = "better"
    elif told and verdict.high < verdict.margin:
        word = "not better"
    return replace(verdict, word=word, p=p, needed=verdict.needed if word == "inconclusive" else None)


def _lattice(a: Floats, b: Floats) -> int:
    """The number of seeds, where values are 0 or 1 in every one of them: means of scenes are its fractions."""
    difference = a - b
    whole = not np.isnan(difference).any() and bool(np.isin(difference, (-1.0, 0.0, 1.0)).all())
    return difference.shape[1] if whole else 0
