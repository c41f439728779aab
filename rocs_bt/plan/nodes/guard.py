"""Guard: the pre- and post-conditions around a node's tick (BehaviorTree.CPP 4.10, tree_node.cpp)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final

from ..board import Board
from ..script import Script, compile_condition, compile_script
from ..status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, Outcome

if TYPE_CHECKING:
    from .node import Node

PRE: Final = ("_failureIf", "_successIf", "_skipIf", "_while")
POST: Final = ("_onHalted", "_onFailure", "_onSuccess", "_post")
CONDITIONS: Final = (*PRE, *POST)

_OUTCOMES: dict[str, Outcome] = {"_failureIf": FAILURE, "_successIf": SUCCESS, "_skipIf": SKIPPED}


class Guard:
    """Asks a node's conditions before and after its tick.

    Before a node starts: `_failureIf`, `_successIf`, `_skipIf`, then `_while`, whose falsehood skips. While it runs
    only `_while` is asked, whose falsehood halts it. After SUCCESS or FAILURE, also one that a condition decided:
    `_onSuccess` or `_onFailure`, then `_post`. When it is halted: `_onHalted`, once, and not `_post`.

    Args:
        node: Whose conditions they are.
        conditions: The scripts by name.
    """

    def __init__(self, node: Node, conditions: Mapping[str, Script]) -> None:
        self._node = node
        self._scripts = conditions
        self._before: tuple[tuple[Callable[[], bool], Outcome], ...] = ()
        self._while: Callable[[], bool] | None = None
        self._after: dict[Outcome, tuple[Callable[[], Any], ...]] = {}
        self._on_halted: Callable[[], Any] | None = None
        self._bound = False

    def bind(self, board: Board) -> None:
        """Compile the scripts for a board."""
        scripts, self._bound = self._scripts, True
        self._before = tuple(
            (compile_condition(scripts[name], board), outcome) for name, outcome in _OUTCOMES.items() if name in scripts
        )
        self._while = compile_condition(scripts["_while"], board) if "_while" in scripts else None
        run = {name: compile_script(scripts[name], board) for name in POST if name in scripts}
        self._on_halted = run.get("_onHalted")
        post = (run["_post"],) if "_post" in run else ()
        self._after = {
            SUCCESS: ((run["_onSuccess"],) if "_onSuccess" in run else ()) + post,
            FAILURE: ((run["_onFailure"],) if "_onFailure" in run else ()) + post,
        }

    def halted(self) -> None:
        """The node was halted."""
        if self._on_halted is not None:
            self._on_halted()

    def around(self, tick: Callable[[], Outcome]) -> Callable[[], Outcome]:
        """A tick with the conditions around it."""
        node = self._node
        if not self._bound:
            self.bind(node.board)  # a node that is in no tree has a board of its own
        before, goes_on, after = self._before, self._while, self._after
        nothing_after = not any(after.values())
        if len(before) == 1 and goes_on is None and nothing_after:
            return _asked_once(node, tick, *before[0])

        def guarded() -> Outcome:
            outcome: Outcome | None = None
            if node.status is not RUNNING:
                for holds, decided in before:
                    if holds():
                        outcome = decided
                        break
                else:
                    if goes_on is not None and not goes_on():
                        outcome = SKIPPED
                if outcome is not None:
                    node.status = IDLE if outcome is SKIPPED else outcome
            elif goes_on is not None and not goes_on():
                node.halt()
                outcome = SKIPPED
            if outcome is None:
                outcome = tick()
            if not nothing_after:
                for run in after.get(outcome, ()):
                    run()
            return outcome

        return guarded


def _asked_once(
    node: Node, tick: Callable[[], Outcome], holds: Callable[[], bool], decided: Outcome
) -> Callable[[], Outcome]:
    """What `around` gives for one pre-condition and nothing else, which is what most guarded nodes have."""
    status = IDLE if decided is SKIPPED else decided

    def guarded() -> Outcome:
        if node.status is not RUNNING and holds():
            node.status = status
            return decided
        return tick()

    return guarded
