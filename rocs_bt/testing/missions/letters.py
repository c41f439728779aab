"""Scripted leaves: what they come to, tick by tick, is written down beforehand."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Final

from ...errors import Fault, InputError
from ...trees.nodes import FAILURE, RUNNING, SKIPPED, SUCCESS, Leaf, Node, Outcome, Runtime

if TYPE_CHECKING:
    from ...trees import Behaviour
    from ...trees.board import Board

OUTCOMES: Final[Mapping[str, Outcome]] = {"R": RUNNING, "S": SUCCESS, "F": FAILURE, "K": SKIPPED}
"""The letters, and what they mean."""


class Letters:
    """What a scripted leaf comes to: a letter a tick, `R`, `S`, `F`, or `K` for SKIPPED; the last one goes on.

    Args:
        outcomes: The letters, such as `RRS`.
        writes: What the leaf writes to its output ports when it succeeds, by port.

    Raises:
        InputError: There is no letter, or one that means nothing.
    """

    def __init__(self, outcomes: str, **writes: Any) -> None:
        strange = [letter for letter in outcomes if letter not in OUTCOMES]
        if strange or not outcomes:
            hint = "Write R for RUNNING, S for SUCCESS, F for FAILURE, K for SKIPPED: one letter a tick."
            found = f"{outcomes!r}" + (f" with {strange[0]!r}" if strange else "")
            raise InputError(Fault(f"a leaf's letters are wrong, found {found}.", hint=hint))
        self.outcomes = outcomes
        self.writes = writes


class Scripted(Leaf):
    """Stands in for a leaf, and comes to what its letters say, a letter a tick, over all of its starts.

    Args:
        name: What displays call it.
        letters: What it comes to.
        original: The node that it stands in for, whose keys and conditions it has; None for nobody.

    Attributes:
        calls: How often it was ticked.
    """

    def __init__(self, name: str, letters: Letters | str, /, original: Behaviour | None = None) -> None:
        ours = original if isinstance(original, Node) else None
        super().__init__(name, **({} if ours is None else {n: s.text for n, s in ours.conditions.items()}))
        self.letters = Letters(letters) if isinstance(letters, str) else letters
        self.calls = 0
        self._original = ours
        self._check()

    def bind(self, board: Board, runtime: Runtime) -> Iterable[tuple[Behaviour, Board]]:
        if self._original is not None:
            for _ in self._original.bind(board, runtime):
                pass  # its keys are declared, and its children are nobody's
        return super().bind(board, runtime)

    def update(self) -> Outcome:
        outcomes = self.letters.outcomes
        outcome = OUTCOMES[outcomes[min(self.calls, len(outcomes) - 1)]]
        self.calls += 1
        self.feedback_message = "as scripted" if outcome is FAILURE else ""
        if outcome is SUCCESS and self._original is not None:
            for port, value in self.letters.writes.items():
                self._original.write(port, value)
        return outcome

    def _check(self) -> None:
        known = {} if self._original is None else self._original.ports
        for port in self.letters.writes:
            if port not in known:
                raise InputError(
                    Fault(f"'{self.name}' cannot write '{port}'.", hint=f"Its ports are: {', '.join(known) or 'none'}.")
                )
