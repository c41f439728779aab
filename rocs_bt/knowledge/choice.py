"""Choice: strategies weighed in one situation, with the reasons."""

from __future__ import annotations

from dataclasses import dataclass

from .experience import Expectation, Situation


@dataclass(frozen=True)
class Candidate:
    """A strategy, weighed.

    Attributes:
        name: The strategy.
        score: The greater the better: its preference, and twice what is expected of it above one half.
        preference: Its own.
        expectation: What came of it in situations like this one.
        obstacle: Why it does not serve now; empty where it does.
    """

    name: str
    score: float
    preference: float
    expectation: Expectation
    obstacle: str = ""

    def __str__(self) -> str:
        if self.obstacle:
            return f"{self.name}: no, {self.obstacle}"
        told = self.expectation
        known = f"worked in {told.successes:.3g} of {told.uses:.3g} like situations" if told.uses > 0.0 else "not tried"
        return f"{self.name}: {self.score:+.2f} (preference {self.preference:g}, {known})"


@dataclass(frozen=True)
class Choice:
    """All strategies, weighed in one situation.

    Attributes:
        situation: The answers to what is asked of it.
        candidates: The best first; those that do not serve last.
    """

    situation: Situation
    candidates: tuple[Candidate, ...]

    @property
    def best(self) -> str | None:
        """The strategy to use; None where none serves."""
        return next((c.name for c in self.candidates if not c.obstacle), None)

    def __str__(self) -> str:
        answers = ", ".join(f"{name} {'yes' if yes else 'no'}" for name, yes in self.situation.items())
        return "\n".join([f"situation: {answers or 'nothing is asked'}", *map(str, self.candidates)])
