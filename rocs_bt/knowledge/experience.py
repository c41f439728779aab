"""Experience: what came of strategies in situations like this one, and how much that says.

A situation is the answers to the questions that are known. Two situations are like each other by the share of the
weight of the questions that were answered alike in both; without questions all are alike. What a strategy may be
expected to come to is the share of its uses that succeeded, each counting as much as its situation is like the present
one, and one success and one failure more than there were (the rule of succession; Laplace, 1814), so that nothing
known is 1/2.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

SHARPNESS = 4
"""The power of the likeness by which a use counts: half alike counts a sixteenth."""

Situation = Mapping[str, bool]
"""The answers, by question."""


@dataclass(frozen=True)
class Use:
    """A use of a strategy that has ended.

    Attributes:
        strategy: Its name.
        situation: What was met.
        success: Whether it succeeded.
    """

    strategy: str
    situation: Situation
    success: bool


@dataclass(frozen=True)
class Expectation:
    """What is expected of a strategy in a situation.

    Attributes:
        share: Of successes, between 0 and 1; 1/2 where nothing is known.
        uses: How many uses it rests on, each counting as much as its situation is like this one.
        successes: How many of them succeeded, counted so.
    """

    share: float
    uses: float
    successes: float


def likeness(a: Situation, b: Situation, weights: Mapping[str, float]) -> float:
    """How like each other two situations are, between 0 and 1; a question that was not asked in both is not alike.

    Args:
        a: One.
        b: The other.
        weights: How much each question matters.
    """
    asked = sorted(a.keys() | b.keys())
    total = sum(weights.get(question, 1.0) for question in asked)
    if total <= 0.0:
        return 1.0
    alike = sum(weights.get(q, 1.0) for q in asked if q in a and q in b and a[q] == b[q])
    return alike / total


def expected(strategy: str, now: Situation, uses: list[Use], weights: Mapping[str, float]) -> Expectation:
    """What may be expected of a strategy now."""
    own = [
        (likeness(now, use.situation, weights) ** SHARPNESS, use.success) for use in uses if use.strategy == strategy
    ]
    count, good = sum(weight for weight, _ in own), sum(weight for weight, success in own if success)
    return Expectation((good + 1.0) / (count + 2.0), count, good)
