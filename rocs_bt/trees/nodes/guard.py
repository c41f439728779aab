"""Pre- and post-conditions of a node (BehaviorTree.CPP 4.10, tree_node.cpp)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final, Protocol

from ..board import Board
from ..script import Script, compile_condition, compile_script
from ..status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, Outcome


class Guarded(Protocol):
    """Interface of a node with conditions."""

    status: Outcome

    def halt(self) -> None: ...
    def tick_once(self) -> Outcome: ...


Tick = Callable[[], Outcome]
_Inner = Callable[["Guarded"], Outcome]
Holds = Callable[[], bool]
Run = Callable[[], Any]

PRE: Final = ("_failureIf", "_successIf", "_skipIf", "_while")
POST: Final = ("_onHalted", "_onFailure", "_onSuccess", "_post")
CONDITIONS: Final = (*PRE, *POST)

_INNER_FIRST: Final = PRE[::-1]
_OUTCOMES: dict[str, Outcome] = {"_failureIf": FAILURE, "_successIf": SUCCESS, "_skipIf": SKIPPED}


def guarded(node: Guarded, conditions: Mapping[str, Script], board: Board) -> tuple[Tick, Run | None]:
    """Create the tick function of a node with conditions, and the function to call when the node is halted.

    Before a node starts, `_failureIf`, `_successIf` and `_skipIf` are evaluated, then `_while`; if `_while` is false,
    the node is skipped. While the node is RUNNING, only `_while` is evaluated; if it is false, the node is halted.
    After SUCCESS or FAILURE, even if a condition decided it, `_onSuccess` or `_onFailure` runs, then `_post`. A halt
    runs `_onHalted` once, and not `_post`.
    """
    run: dict[str, Run] = {}
    tick: Any = type(node).tick_once
    for name, script in conditions.items():
        run[name] = compile_condition(script, board) if name in PRE else compile_script(script, board)
    for name in _INNER_FIRST:
        if name in run:
            decided = _OUTCOMES.get(name)
            tick = _while(node, tick, run[name]) if decided is None else _unless(node, tick, run[name], decided)
    if "_onSuccess" in run or "_onFailure" in run or "_post" in run:
        post = run.get("_post")
        tick = _after(node, tick, _both(run.get("_onSuccess"), post), _both(run.get("_onFailure"), post))
    elif tick is type(node).tick_once:
        tick = tick.__get__(node)
    return tick, run.get("_onHalted")


# Each wrapper below takes the node as a parameter, so that wrappers can be nested. The parameter has a default, so
# that the outermost wrapper can be called without arguments, like the method `tick_once` that it hides. Default
# arguments are read faster than closure variables.


def _while(node: Guarded, tick: _Inner, holds: Holds) -> Tick:
    def guarded(node: Guarded = node, tick: _Inner = tick, holds: Holds = holds) -> Outcome:
        if holds():
            return tick(node)
        if node.status is RUNNING:
            node.halt()
        else:
            node.status = IDLE
        return SKIPPED

    return guarded


def _unless(node: Guarded, tick: _Inner, holds: Holds, decided: Outcome) -> Tick:
    def guarded(node: Guarded = node, tick: _Inner = tick, holds: Holds = holds, decided: Outcome = decided) -> Outcome:
        if node.status is not RUNNING and holds():
            node.status = IDLE if decided is SKIPPED else decided
            return decided
        return tick(node)

    return guarded


def _after(node: Guarded, tick: _Inner, on_success: Run | None, on_failure: Run | None) -> Tick:
    def guarded(
        node: Guarded = node,
        tick: _Inner = tick,
        on_success: Run | None = on_success,
        on_failure: Run | None = on_failure,
    ) -> Outcome:
        outcome = tick(node)
        if outcome is SUCCESS:
            if on_success is not None:
                on_success()
        elif outcome is FAILURE and on_failure is not None:
            on_failure()
        return outcome

    return guarded


def _both(first: Run | None, second: Run | None) -> Run | None:
    if first is None or second is None:
        return first or second

    def run() -> None:
        first()
        second()

    return run
