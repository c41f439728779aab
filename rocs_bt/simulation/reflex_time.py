"""ReflexTime: for how long reflexes held a robot, and which rules alternated."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

ALTERNATING = 6
"""Number of changes between two rules from which they count as alternating."""


class ReflexTime:
    """Time in which reflexes held the plan of a robot, by rule; updated once per control period."""

    def __init__(self) -> None:
        self._times: dict[str, float] = {}  # [s]
        self._changes: Counter[frozenset[str]] = Counter()
        self._last = ""

    @property
    def total(self) -> float:
        """Time in which reflexes held the robot [s]."""
        return float(sum(self._times.values()))

    @property
    def rule(self) -> str:
        """Rule that held the robot for the longest time; empty if none did."""
        return max(self._times, key=self._times.__getitem__, default="")

    def clear(self) -> None:
        """Forget everything."""
        self._times.clear()
        self._changes.clear()
        self._last = ""

    def add(self, rule: str, seconds: float) -> None:
        """Add one period.

        Args:
            rule: Rule of the reflex that holds the robot; empty if none does.
            seconds: Length of the period [s].
        """
        if not rule:
            return
        if self._last not in ("", rule):
            self._changes[frozenset((self._last, rule))] += 1
        self._last = rule
        self._times[rule] = self._times.get(rule, 0.0) + seconds

    @property
    def alternating(self) -> bool:
        """Whether two rules alternate."""
        return self._pair()[1] >= ALTERNATING

    def text(self, reading: Callable[[str], str]) -> str:
        """Rules with their times, such as `collision/Flinch for 8.0 s (around = 0.2 m)`; empty if no rule held it.

        The rule with the longest time is named, or two rules that alternated.

        Args:
            reading: Guard values of a rule's last firing, by the rule's name.
        """
        pair, changes = self._pair()
        rules = sorted(pair, key=lambda each: -self._times[each]) if self.alternating else [self.rule]
        held = [f"{each} for {self._times[each]:.1f} s{_in_brackets(reading(each))}" for each in rules if each]
        return " and ".join(held) + (f", which alternated {changes} times" if len(rules) > 1 else "")

    def _pair(self) -> tuple[frozenset[str], int]:
        """Two rules that followed each other most often, and how often."""
        return max(self._changes.items(), key=lambda item: item[1], default=(frozenset(), 0))


def _in_brackets(text: str) -> str:
    return f" ({text})" if text else ""
