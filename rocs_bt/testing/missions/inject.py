"""Faults on purpose: decorators that break what they hold, to try what a tree does then."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from ...errors import Fault
from ...trees.error import TreeError
from ...trees.nodes import FAILURE, RUNNING, SKIPPED, Decorator, Input, Outcome
from ...trees.status import outcome_named
from .match import Filters, replace

if TYPE_CHECKING:
    from ...trees import Behaviour


class Faulty(Decorator):
    """Ticks its child; at the start of some rounds it breaks instead, and stays so for the round. The base of these."""

    def __init__(self, name: str, child: Any, /, **attributes: Any) -> None:
        super().__init__(name, child, **attributes)
        self._rounds = 0
        self._broken = False

    def breaks(self, rounds: int) -> bool:
        """Whether it breaks in this round, counted from 1."""
        raise NotImplementedError

    def broken(self) -> Outcome:
        """What it comes to then."""
        return FAILURE

    def tick_once(self) -> Outcome:
        if self.status is not RUNNING:
            self._rounds += 1
            self._broken = self.breaks(self._rounds)
            self.status = RUNNING
        outcome = self.broken() if self._broken else self.tick_child()
        if outcome is not SKIPPED:
            self.status = outcome
        return outcome


class Breaks(Faulty):
    """Ticks its child until the round `at`; from then on, for `rounds` rounds, it comes to `outcome` without it."""

    at = Input(int, 1, "the first round that breaks, counted from 1")
    rounds = Input(int, -1, "how many break; -1 for all")
    outcome = Input(str, "FAILURE", "what it comes to; RUNNING never ends")

    def breaks(self, rounds: int) -> bool:
        many = self.rounds
        return rounds >= self.at and (many < 0 or rounds < self.at + many)

    def broken(self) -> Outcome:
        return outcome_named(self.outcome)


class Flaky(Faulty):
    """Fails in some rounds instead of ticking its child, at random: the same ones for the same seed."""

    probability = Input(float, 0.5, "that a round fails")
    seed = Input(int, 1, "of the random numbers")

    def __init__(self, name: str, child: Any, /, **attributes: Any) -> None:
        super().__init__(name, child, **attributes)
        self._random: random.Random | None = None

    def breaks(self, rounds: int) -> bool:
        if self._random is None:
            self._random = random.Random(self.seed)
        return self._random.random() < self.probability


class Raises(Faulty):
    """Raises an error instead of ticking its child, from the round `at` on."""

    at = Input(int, 1, "the first round that raises, counted from 1")
    message = Input(str, "broken on purpose", "what the error says")

    def breaks(self, rounds: int) -> bool:
        return rounds >= self.at

    def broken(self) -> Outcome:
        raise TreeError(Fault(self.message))


def inject(root: Behaviour, faults: Mapping[str, Callable[[Behaviour], Decorator]]) -> Behaviour:
    """Put decorators around nodes of a tree that is not bound yet.

        inject(root, {"GoTo*": lambda node: Breaks("jam", node, at=2)})

    Args:
        root: The tree's root.
        faults: Makes the decorator for a node, by filter; see `substitute`.

    Returns:
        The root, which may be another one now.

    Raises:
        InputError: A filter means no node.
    """
    filters = Filters(root, faults)
    filters.refuse_unused()
    found: list[tuple[Behaviour, str]] = []
    todo = [root]
    while todo:
        node = todo.pop()
        if (text := filters.match(node)) is not None:
            found.append((node, text))
        todo += node.children
    for node, text in found:
        parent = node.parent
        decorator = faults[text](node)
        replace(parent, node, decorator)
        root = decorator if node is root else root
    return root
