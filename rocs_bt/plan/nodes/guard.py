"""Guard: the pre- and post-conditions around a node's tick (BehaviorTree.CPP 4.10, tree_node.cpp)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
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
        self._on_success: Callable[[], Any] | None = None
        self._on_failure: Callable[[], Any] | None = None
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
        self._on_halted, post = run.get("_onHalted"), run.get("_post")
        self._on_success = _both(run.get("_onSuccess"), post)
        self._on_failure = _both(run.get("_onFailure"), post)

    def halted(self) -> None:
        """The node was halted."""
        if self._on_halted is not None:
            self._on_halted()

    def around(self, tick: Callable[[], Outcome]) -> Callable[[], Outcome]:
        """A tick with the conditions around it, and nothing for those that the node does not have."""
        if not self._bound:
            self.bind(self._node.board)  # a node that is in no tree has a board of its own
        if self._while is not None:
            tick = _while(self._node, tick, self._while)
        if len(self._before) == 1:
            tick = _unless(self._node, tick, *self._before[0])
        elif self._before:
            tick = _unless_any(self._node, tick, self._before)
        if self._on_success is None and self._on_failure is None:
            return tick
        return _after(tick, self._on_success, self._on_failure)


def _while(node: Node, tick: Callable[[], Outcome], holds: Callable[[], bool]) -> Callable[[], Outcome]:
    def guarded() -> Outcome:
        if holds():
            return tick()
        if node.status is RUNNING:
            node.halt()
        else:
            node.status = IDLE
        return SKIPPED

    return guarded


def _unless(
    node: Node, tick: Callable[[], Outcome], holds: Callable[[], bool], decided: Outcome
) -> Callable[[], Outcome]:
    """The same as `_unless_any` for the one condition that most guarded nodes have."""
    status = IDLE if decided is SKIPPED else decided

    def guarded() -> Outcome:
        if node.status is not RUNNING and holds():
            node.status = status
            return decided
        return tick()

    return guarded


def _unless_any(
    node: Node, tick: Callable[[], Outcome], conditions: Iterable[tuple[Callable[[], bool], Outcome]]
) -> Callable[[], Outcome]:
    def guarded() -> Outcome:
        if node.status is not RUNNING:
            for holds, decided in conditions:
                if holds():
                    node.status = IDLE if decided is SKIPPED else decided
                    return decided
        return tick()

    return guarded


def _after(
    tick: Callable[[], Outcome], on_success: Callable[[], Any] | None, on_failure: Callable[[], Any] | None
) -> Callable[[], Outcome]:
    def guarded() -> Outcome:
        outcome = tick()
        if outcome is SUCCESS:
            if on_success is not None:
                on_success()
        elif outcome is FAILURE and on_failure is not None:
            on_failure()
        return outcome

    return guarded


def _both(first: Callable[[], Any] | None, second: Callable[[], Any] | None) -> Callable[[], Any] | None:
    if first is None or second is None:
        return first or second

    def run() -> None:
        first()
        second()

    return run
