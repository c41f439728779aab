"""Fault injection in trees: decorators that make their child fail."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Annotated, Any

from ...base.errors import Fault
from ...trees.error import TreeError
from ...trees.nodes import FAILURE, RUNNING, SKIPPED, Decorator, Outcome
from ...trees.status import outcome_named
from .match import Filters, replace

if TYPE_CHECKING:
    from ...trees import Behaviour


class Faulty(Decorator):
    """Base class of fault decorators: in faulty rounds the decorator fails instead of ticking its child.

    A round begins with a tick of the idle decorator, and ends with its SUCCESS or FAILURE.
    """

    def __init__(self, name: str, child: Any, /, **attributes: Any) -> None:
        super().__init__(name, child, **attributes)
        self._rounds = 0
        self._broken = False

    def breaks(self, rounds: int) -> bool:
        """Whether the fault occurs in the round with this number, counted from 1."""
        raise NotImplementedError

    def broken(self) -> Outcome:
        """Outcome that the decorator returns in a faulty round."""
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
    """Returns `outcome` without ticking its child, in `rounds` rounds, the first of which is the round `at`."""

    at: Annotated[int, "first faulty round, counted from 1"] = 1
    rounds: Annotated[int, "number of faulty rounds; -1 for all"] = -1
    outcome: Annotated[str, "outcome during the fault; RUNNING never ends"] = "FAILURE"

    def breaks(self, rounds: int) -> bool:
        many = self.rounds
        return rounds >= self.at and (many < 0 or rounds < self.at + many)

    def broken(self) -> Outcome:
        return outcome_named(self.outcome)


class Flaky(Faulty):
    """Fails in random rounds instead of ticking its child; reproducible for a given seed."""

    probability: Annotated[float, "probability that a round fails"] = 0.5
    seed: Annotated[int, "seed of the random numbers"] = 1

    def __init__(self, name: str, child: Any, /, **attributes: Any) -> None:
        super().__init__(name, child, **attributes)
        self._random: random.Random | None = None

    def breaks(self, rounds: int) -> bool:
        if self._random is None:
            self._random = random.Random(self.seed)
        return self._random.random() < self.probability


class Raises(Faulty):
    """Raises an error instead of ticking its child, from the round `at` on."""

    at: Annotated[int, "first round that raises, counted from 1"] = 1
    message: Annotated[str, "message of the error"] = "broken on purpose"

    def breaks(self, rounds: int) -> bool:
        return rounds >= self.at

    def broken(self) -> Outcome:
        raise TreeError(Fault(self.message))


def inject(root: Behaviour, faults: Mapping[str, Callable[[Behaviour], Decorator]]) -> Behaviour:
    """Put decorators around nodes of an unbound tree.

        inject(root, {"GoTo*": lambda node: Breaks("jam", node, at=2)})

    Args:
        root: Root of the tree.
        faults: Functions that create the decorator of a node, keyed by filter of nodes (see `substitute`).

    Returns:
        The root, which may have been replaced.

    Raises:
        InputError: A filter matches no node.
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
