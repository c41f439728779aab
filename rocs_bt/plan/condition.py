"""Condition: a leaf that asks an expression of the one expression language."""

from __future__ import annotations

from collections.abc import Callable

from py_trees.common import Status

from ..trees.nodes import Instant


class Condition(Instant):
    """SUCCESS while an expression holds, FAILURE while it does not or cannot be told; never RUNNING.

    Args:
        name: What displays call it.
        text: The expression, as it was written.
        holds: Whether it holds now.
        reading: What it reads now, such as `min(front) = 0.21 m`; asked where it does not hold.
    """

    def __init__(self, name: str, text: str, holds: Callable[[], bool], reading: Callable[[], str]) -> None:
        super().__init__(name)
        self.text = text
        self._holds = holds
        self._reading = reading

    def written(self) -> tuple[str, dict[str, str]]:
        return "When", {"expression": self.text}

    def update(self) -> Status:
        if self._holds():
            self.feedback_message = ""
            return Status.SUCCESS
        self.feedback_message = f"'{self.text}' does not hold: {self._reading()}"
        return Status.FAILURE
