"""ReflexTime: for how long reflexes held a robot, and the rule that held it longest."""

from __future__ import annotations

from collections.abc import Callable


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
        """The rule with the longest time, such as `collision/Flinch for 8.0 s (around = 0.2 m)`; empty without one.

        Args:
            reading: Guard values of a rule's last firing, by the rule's name.
        """
        if not (rule := self.rule):
            return ""
        values = reading(rule)
        return f"{rule} for {self._times[rule]:.1f} s" + (f" ({values})" if values else "")
