"""Leaves with scripted outcomes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Final

from ...base.errors import Fault, InputError
from ...trees.nodes import FAILURE, RUNNING, SKIPPED, SUCCESS, Leaf, Node, Outcome, Runtime

if TYPE_CHECKING:
    from ...trees import Behaviour
    from ...trees.board import Board

OUTCOMES: Final[Mapping[str, Outcome]] = {"R": RUNNING, "S": SUCCESS, "F": FAILURE, "K": SKIPPED}
"""Outcome of each letter."""


class ScriptedOutcomes:
    """Outcomes of a scripted leaf, one letter per tick; the last letter repeats.

    The letters are `R` for RUNNING, `S` for SUCCESS, `F` for FAILURE and `K` for SKIPPED.

    Args:
        outcomes: The letters, such as `RRS`.
        writes: Value that the leaf writes to each of its output ports on success, by port name.

    Raises:
        InputError: There is no letter, or an unknown one.
    """

    def __init__(self, outcomes: str, **writes: Any) -> None:
        strange = [letter for letter in outcomes if letter not in OUTCOMES]
        if strange or not outcomes:
            hint = "Write R for RUNNING, S for SUCCESS, F for FAILURE, K for SKIPPED: one letter per tick."
            found = f"{outcomes!r}" + (f" with {strange[0]!r}" if strange else "")
            raise InputError(Fault(f"invalid scripted outcomes, found {found}.", hint=hint))
        self.outcomes = outcomes
        self.writes = writes


class Scripted(Leaf):
    """Leaf that returns scripted outcomes, one letter per tick; a restart of the leaf does not restart the script.

    Args:
        name: Display name.
        outcomes: The outcomes.
        original: Node that the leaf replaces; the leaf takes over its ports and conditions. None if it replaces none.

    Attributes:
        calls: Number of ticks.
    """

    def __init__(self, name: str, outcomes: ScriptedOutcomes | str, /, original: Behaviour | None = None) -> None:
        ours = original if isinstance(original, Node) else None
        super().__init__(name, **({} if ours is None else {n: s.text for n, s in ours.conditions.items()}))
        self.script = ScriptedOutcomes(outcomes) if isinstance(outcomes, str) else outcomes
        self.calls = 0
        self._original = ours
        self._check()

    def bind(self, board: Board, runtime: Runtime) -> Iterable[tuple[Behaviour, Board]]:
        if self._original is not None:
            for _ in self._original.bind(board, runtime):
                pass  # declares the original's blackboard keys; its children are dropped
        return super().bind(board, runtime)

    def update(self) -> Outcome:
        outcomes = self.script.outcomes
        outcome = OUTCOMES[outcomes[min(self.calls, len(outcomes) - 1)]]
        self.calls += 1
        self.feedback_message = "as scripted" if outcome is FAILURE else ""
        if outcome is SUCCESS and self._original is not None:
            for port, value in self.script.writes.items():
                self._original.write(port, value)
        return outcome

    def _check(self) -> None:
        known = {} if self._original is None else self._original.ports
        for port in self.script.writes:
            if port not in known:
                raise InputError(
                    Fault(f"'{self.name}' cannot write '{port}'.", hint=f"Its ports are: {', '.join(known) or 'none'}.")
                )
