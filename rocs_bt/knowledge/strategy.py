"""The StrategyModel: the ways to act that the robot knows, and what it falls back to (paper, 4.2 and 5.1)."""

from __future__ import annotations

from typing import Any

from .model import Model


class StrategyModel(Model):
    """Named strategies as nodes, the one in force, and their fallbacks."""

    def add(self, name: str, falls_back_to: str | None = None, **attributes: Any) -> None:
        """Add a strategy.

        Args:
            name: Its node.
            falls_back_to: The strategy to take when this one does not serve; it must exist.
            attributes: What a strategy holds, such as `mission`.
        """
        with self.graph.held():
            if falls_back_to is not None:
                self.graph.kind(falls_back_to)
            self.graph.add(name, "strategy", **attributes)
            if falls_back_to is not None:
                self.graph.relate(name, "falls_back_to", falls_back_to)

    def names(self) -> list[str]:
        """All strategies."""
        return self.graph.nodes("strategy")

    def use(self, name: str) -> None:
        """Put a strategy in force."""
        self.graph.relate(self.name, "uses", name)

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
