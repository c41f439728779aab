"""StrategyModel: known strategies, their outcomes so far, and the choice among them (paper, 4.2 and 5.1).

A situation is the set of answers to the known questions. The similarity of two situations is the weighted share of the
questions that have the same answer in both; without questions it is 1. The expected success of a strategy is the share
of its uses that succeeded. Each use is weighted by the similarity of its situation to the present one. One success and
one failure are added (the rule of succession; Laplace, 1814), so the expected success is 1/2 without data.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from ..base.errors import InputError, KnowledgeError
from .base import Model

SHARPNESS = 4
"""Exponent of the similarity in the weight of a use: a use of similarity 1/2 has the weight 1/16."""

Situation = Mapping[str, bool]
"""Answers by question."""


@dataclass(frozen=True)
class Use:
    """Finished use of a strategy.

    Attributes:
        strategy: Name of the strategy.
        situation: Situation when the use began.
        success: Whether the strategy succeeded.
    """

    strategy: str
    situation: Situation
    success: bool


@dataclass(frozen=True)
class Expectation:
    """Expected success of a strategy in a situation."""

    share: float  # between 0 and 1; 1/2 without data
    uses: float  # sum of the weights of the uses
    successes: float


def similarity(a: Situation, b: Situation, weights: Mapping[str, float]) -> float:
    """Similarity of two situations, between 0 and 1; a question missing in one of them counts as different.

    Weights of questions are 1 by default.
    """
    asked = sorted(a.keys() | b.keys())
    total = sum(weights.get(question, 1.0) for question in asked)
    if total <= 0.0:
        return 1.0
    alike = sum(weights.get(q, 1.0) for q in asked if q in a and q in b and a[q] == b[q])
    return alike / total


def expected(strategy: str, now: Situation, uses: list[Use], weights: Mapping[str, float]) -> Expectation:
    """Expected success of a strategy in the present situation."""
    weighted = [
        (similarity(now, use.situation, weights) ** SHARPNESS, use.success) for use in uses if use.strategy == strategy
    ]
    count, good = sum(weight for weight, _ in weighted), sum(weight for weight, success in weighted if success)
    return Expectation((good + 1.0) / (count + 2.0), count, good)


@dataclass(frozen=True)
class Candidate:
    """A strategy with its score in the present situation.

    Attributes:
        name: Name of the strategy.
        score: `preference + 2 * (expectation.share - 1/2)`; the strategy with the highest score is the best.
        preference: Preference declared for the strategy.
        expectation: Expected success, from uses in similar situations.
        rejection: Reason why the strategy is not applicable now; empty if it is applicable.
    """

    name: str
    score: float
    preference: float
    expectation: Expectation
    rejection: str = ""

    def __str__(self) -> str:
        if self.rejection:
            return f"{self.name}: no, {self.rejection}"
        expected = self.expectation
        uses = f"{expected.successes:.3g} of {expected.uses:.3g}"
        known = f"succeeded in {uses} similar situations" if expected.uses > 0.0 else "not tried"
        return f"{self.name}: {self.score:+.2f} (preference {self.preference:g}, {known})"


@dataclass(frozen=True)
class Choice:
    """All strategies, scored in one situation.

    Attributes:
        situation: Answers to the questions.
        candidates: Strategies, the best first; those that are not applicable last.
    """

    situation: Situation
    candidates: tuple[Candidate, ...]

    @property
    def best(self) -> str | None:
        """The best applicable strategy; None if there is none."""
        return next((c.name for c in self.candidates if not c.rejection), None)

    def __str__(self) -> str:
        answers = ", ".join(f"{name} {'yes' if yes else 'no'}" for name, yes in self.situation.items())
        return "\n".join([f"situation: {answers or 'no questions'}", *map(str, self.candidates)])


KEPT = 200
"""Maximum number of uses that the graph keeps; the oldest finished use is removed first."""


class StrategyModel(Model):
    """View of knowledge as strategies: their fallbacks, the strategy in use, and the outcome of each use."""

    def add(self, name: str, falls_back_to: str | None = None, **attributes: Any) -> None:
        """Add a strategy.

        Args:
            name: Name of the strategy and of its node.
            falls_back_to: Fallback when this strategy is not applicable; it must exist.
            attributes: Attributes of a strategy, such as `mission`.
        """
        with self.graph.locked():
            if falls_back_to is not None:
                self.graph.kind(falls_back_to)
            self.graph.add(name, "strategy", **attributes)
            if falls_back_to is not None:
                self.graph.relate(name, "falls_back_to", falls_back_to)

    def names(self) -> list[str]:
        """Names of all strategies."""
        return self.graph.nodes("strategy")

    def use(self, name: str) -> None:
        """Set the strategy in use, without recording its outcome."""
        self.graph.relate(self.name, "uses", name)

    def begin(self, name: str, why: str = "asked for by name", situation: Situation | None = None) -> str:
        """Set the strategy in use, and record the use.

        Args:
            name: Name of the strategy.
            why: Reason for the choice.
            situation: Answers to the questions; None to evaluate the questions now.

        Returns:
            Name of the node that records this use, to be passed to `end`.
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
        """Record the outcome of a use; has no effect on a use that has ended already.

        Args:
            use: Node of the use; ignored if it has been removed.
            outcome: `success`, `failure` or `halted`.
            reason: Reason of a failure.
        """
        with self.graph.locked():
            if self.graph.has(use) and self.graph.get(use, "outcome") is None:
                self.graph.set(use, outcome=outcome, ended=self.graph.clock.now(), reason=reason or None)

    def used(self) -> str | None:
        """The strategy in use; None if there is none."""
        found = self.graph.related(self.name, "uses")
        return found[0] if found else None

    def fallbacks(self, name: str) -> list[str]:
        """Fallback of a strategy, the fallback of this fallback, and so on, until a strategy would occur twice."""
        chain, at = [name], name
        while (found := self.graph.related(at, "falls_back_to")) and found[0] not in chain:
            at = found[0]
            chain.append(at)
        return chain[1:]

    def situation(self) -> dict[str, bool]:
        """Evaluate all known questions.

        Returns:
            Answers by question.

        Raises:
            KnowledgeError: The query of a question is invalid; names the question.
        """
        return {question: self._holds(question, "query") for question in self.graph.nodes("question")}

    def choose(self, role: str = "", tried: Collection[str] = ()) -> Choice:
        """Score all strategies in the present situation.

        A strategy is applicable if its guard holds, it has not just failed, and it suits the given role or, without
        one, a role that the robot plays. The best strategy is the applicable one with the highest score; of equal ones,
        the one that was added first.

        Args:
            role: Role that the strategy must suit; empty for the robot's own roles.
            tried: Strategies that have just failed.

        Raises:
            KnowledgeError: No such role, or the query of a guard or question is invalid; names it.
        """
        if role:
            self.graph.kind(role)
        roles = {role} if role else set(self.graph.related(self.name, "plays"))
        now, uses = self.situation(), self.uses()
        weights: Mapping[str, float] = {q: self.graph.get(q, "weight") for q in self.graph.nodes("question")}
        found = []
        for name in self.names():
            preference, expectation = self.graph.get(name, "preference"), expected(name, now, uses, weights)
            score = preference + 2.0 * (expectation.share - 0.5)
            found.append(Candidate(name, score, preference, expectation, self._rejection(name, roles, tried)))
        return Choice(now, tuple(sorted(found, key=lambda c: (bool(c.rejection), -c.score))))

    def after(self, name: str, tried: Collection[str]) -> str | None:
        """First applicable fallback of a failed strategy, except strategies in `tried`; None if there is none."""
        roles = set(self.graph.related(self.name, "plays"))
        return next((n for n in self.fallbacks(name) if not self._rejection(n, roles, tried)), None)

    def uses(self) -> list[Use]:
        """All uses that have succeeded or failed, in order."""
        found = []
        for node in self.graph.nodes("use"):
            outcome, of = self.graph.get(node, "outcome"), self.graph.related(node, "use_of")
            if outcome in ("success", "failure") and of:
                answers = {q: bool(edge["answer"]) for q, edge in self.graph.targets(node, "met").items()}
                found.append(Use(of[0], answers, outcome == "success"))
        return found

    def _rejection(self, name: str, roles: set[str], tried: Collection[str]) -> str:
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
            raise KnowledgeError(f"the {attribute} of '{node}' is not a valid query: {error}") from error

    def _forget(self) -> None:
        ended = [use for use in self.graph.nodes("use") if self.graph.get(use, "outcome") is not None]
        for use in ended[: max(0, len(self.graph.nodes("use")) - KEPT)]:
            self.graph.remove(use)
