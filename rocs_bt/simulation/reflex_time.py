"""ReflexTime: for how long reflexes held a robot, and the rules that held it longest."""

from __future__ import annotations

from collections.abc import Callable

MINOR = 0.1
"""Share of the time from which on the rule with the second longest time is named."""


class ReflexTime:
    """Time in which reflexes held the plan of a robot, by rule; updated once per control period."""

    def __init__(self) -> None:
        self._times: dict[str, float] = {}  # [s]

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

    def add(self, rule: str, seconds: float) -> None:
        """Add one period.

        Args:
            rule: Rule of the reflex that holds the robot; empty if none does.
            seconds: Length of the period [s].
        """
        if rule:
            self._times[rule] = self._times.get(rule, 0.0) + seconds

    def text(self, reading: Callable[[str], str]) -> str:
        """Rules with their times, such as `collision/Flinch for 8.0 s (around = 0.2 m)`; empty if no rule held it.

        The rule with the longest time is named, and the next one if it took at least a tenth of the time.

        Args:
            reading: Guard values of a rule's last firing, by the rule's name.
        """
        longest = sorted(self._times, key=self._times.__getitem__, reverse=True)[:2]
        named = [rule for rule in longest if rule == longest[0] or self._times[rule] >= MINOR * self.total]
        return " and ".join(f"{rule} for {self._times[rule]:.1f} s{_in_brackets(reading(rule))}" for rule in named)


def _in_brackets(text: str) -> str:
    return f" ({text})" if text else ""
