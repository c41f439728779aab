"""Strategies: the ways to act that the robot knows, what came of them, and which serves now (paper, 4.2 and 5.1).

A situation is the answers to the questions that are known. Two situations are like each other by the share of the
weight of the questions that were answered alike in both; without questions all are alike. The expected success of a
strategy is the share of its uses that succeeded, each weighted by how like its situation is to the present one, with
one success and one failure added (the rule of succession; Laplace, 1814), so that nothing known is 1/2.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from ..errors import InputError, KnowledgeError
from .model import Model

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


def similarity(a: Situation, b: Situation, weights: Mapping[str, float]) -> float:
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
        (similarity(now, use.situation, weights) ** SHARPNESS, use.success) for use in uses if use.strategy == strategy
    ]
    count, good = sum(weight for weight, _ in own), sum(weight for weight, success in own if success)
    return Expectation((good + 1.0) / (count + 2.0), count, good)


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


KEPT = 200
"""Uses that are kept; with one more the oldest that ended is forgotten."""


class StrategyModel(Model):
    """Named strategies as nodes, the one in force, their fallbacks, and what came of each use."""

    def add(self, name: str, falls_back_to: str | None = None, **attributes: Any) -> None:
        """Add a strategy.

        Args:
            name: Its node.
            falls_back_to: The strategy to take when this one does not serve; it must exist.
            attributes: What a strategy holds, such as `mission`.
        """
        with self.graph.locked():
            if falls_back_to is not None:
                self.graph.kind(falls_back_to)
            self.graph.add(name, "strategy", **attributes)
            if falls_back_to is not None:
                self.graph.relate(name, "falls_back_to", falls_back_to)

    def names(self) -> list[str]:
        """All strategies."""
        return self.graph.nodes("strategy")

    def use(self, name: str) -> None:
        """Put a strategy in force; what comes of it is not kept."""
        self.graph.relate(self.name, "uses", name)

    def begin(self, name: str, why: str = "asked for by name", situation: Situation | None = None) -> str:
        """Put a strategy in force, and begin to keep what comes of it.

        Args:
            name: The strategy.
            why: Why it was chosen.
            situation: The answers to the questions; asked now where none are given.

        Returns:
            The node of this use, for `end`.
        """
        with self.graph.locked():
            self.use(name)
            met = self.situation() if situation is None else situation
            numbers = [int(use.rpartition("_")[2]) for use in self.graph.nodes("use") if use.startswith("use_")]
            node = f"use_{max(numbers, default=0) + 1}"
            self.graph.add(node, "use", began=self.graph.clock.now(), why=why)
            self.graph.relate(node, "use_of", name)
            for question, answer in met.items():
                self.graph.relate(node, "met", question, answer=answer)
            self._forget()
        return node

    def end(self, use: str, outcome: str, reason: str = "") -> None:
        """Say what came of a use; one that has ended stays as it is.

        Args:
            use: Its node; one that is forgotten by now is passed over.
            outcome: `success`, `failure` or `halted`.
            reason: Of a failure.
        """
        with self.graph.locked():
            if self.graph.has(use) and self.graph.get(use, "outcome") is None:
                self.graph.set(use, outcome=outcome, ended=self.graph.clock.now(), reason=reason or None)

    def used(self) -> str | None:
        """The strategy in force; None where there is none."""
        found = self.graph.related(self.name, "uses")
        return found[0] if found else None

    def fallbacks(self, name: str) -> list[str]:
        """What a strategy falls back to, one after the other; a circle ends where it closes."""
        chain, at = [name], name
        while (found := self.graph.related(at, "falls_back_to")) and found[0] not in chain:
            at = found[0]
            chain.append(at)
        return chain[1:]

    def situation(self) -> dict[str, bool]:
        """The answers to all questions that are known, by question.

        Raises:
            KnowledgeError: A question cannot be asked; says which.
        """
        return {question: self._holds(question, "query") for question in self.graph.nodes("question")}

    def choose(self, role: str = "", tried: Collection[str] = ()) -> Choice:
        """Weigh all strategies in the present situation.

        A strategy serves if its guard holds and it suits the role: that which is asked for, or one that the robot
        plays; of those that serve the best has the highest score, and of equal ones the first that was added.

        Args:
            role: The role that it must suit; one of the robot's own where empty.
            tried: Strategies that have failed just now.

        Raises:
            KnowledgeError: No such role, or a guard or question cannot be asked; says which.
        """
        if role:
            self.graph.kind(role)
        roles = {role} if role else set(self.graph.related(self.name, "plays"))
        now, uses = self.situation(), self.uses()
        weights: Mapping[str, float] = {q: self.graph.get(q, "weight") for q in self.graph.nodes("question")}
        found = []
        for name in self.names():
            preference, told = self.graph.get(name, "preference"), expected(name, now, uses, weights)
            score = preference + 2.0 * (told.share - 0.5)
            found.append(Candidate(name, score, preference, told, self._obstacle(name, roles, tried)))
        return Choice(now, tuple(sorted(found, key=lambda c: (bool(c.obstacle), -c.score))))

    def after(self, name: str, tried: Collection[str]) -> str | None:
        """What to use when a strategy has failed: the first of its fallbacks that serves; None without one."""
        roles = set(self.graph.related(self.name, "plays"))
        return next((n for n in self.fallbacks(name) if not self._obstacle(n, roles, tried)), None)

    def uses(self) -> list[Use]:
        """All uses that have succeeded or failed, in their order."""
        found = []
        for node in self.graph.nodes("use"):
            outcome, of = self.graph.get(node, "outcome"), self.graph.related(node, "use_of")
            if outcome in ("success", "failure") and of:
                answers = {q: bool(edge["answer"]) for q, edge in self.graph.targets(node, "met").items()}
                found.append(Use(of[0], answers, outcome == "success"))
        return found

    def _obstacle(self, name: str, roles: set[str], tried: Collection[str]) -> str:
        suits = self.graph.related(name, "suits")
        if name in tried:
            return "it has just failed"
        if suits and not roles.intersection(suits):
            return f"it is for {', '.join(suits)}"
        if self.graph.get(name, "guard") and not self._holds(name, "guard"):
            return f"its guard does not hold: {self.graph.get(name, 'guard')}"
        return ""

    def _holds(self, node: str, attribute: str) -> bool:
        try:
            return self.knowledge.holds(self.graph.get(node, attribute))
        except InputError as error:
            raise KnowledgeError(f"the {attribute} of '{node}' cannot be asked: {error}") from error

    def _forget(self) -> None:
        ended = [use for use in self.graph.nodes("use") if self.graph.get(use, "outcome") is not None]
        for use in ended[: max(0, len(self.graph.nodes("use")) - KEPT)]:
            self.graph.remove(use)
