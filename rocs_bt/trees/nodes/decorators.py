"""Decorators of BehaviorTree.CPP: nodes with one child."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import GenericAlias
from typing import Annotated, Any, ClassVar

from py_trees.common import Status

from ...base.errors import Fault, InputError
from ..script import compile_condition, parse_script, script_reading
from ..status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, Outcome
from ..value import converted
from .base_classes import Decorator, counted_text, halt, no_outcome
from .port import ConditionText, Direction, InOut, Syntax, key_name, port_of


class _Counted(Decorator):
    """Ticks the child until it has returned the outcome `counted` a number of times; the other outcome ends the node.

    If the child ends within one tick, the node returns RUNNING before the next round, so that it can be interrupted.
    """

    counted: ClassVar[Status] = SUCCESS
    limit: ClassVar[str] = ""
    round: ClassVar[str] = ""

    def __init__(self, name: str, child: Any, /, **attributes: Any) -> None:
        super().__init__(name, child, **attributes)
        self._count, self._most = 0, -1

    def wait_text(self) -> str:
        return counted_text(self.round, self._count + 1, self._most)

    def halted(self) -> None:
        self._count = 0
        super().halted()

    def tick_once(self) -> Outcome:
        limit = self._most = self.read(self.limit)
        self.status = RUNNING
        child: Any = self.decorated
        while limit == -1 or self._count < limit:
            at_once = child.status is not RUNNING
            outcome = child.tick_once() or child.status
            if outcome is RUNNING:
                return outcome
            if outcome is IDLE:
                raise no_outcome(child, outcome)
            if outcome is SKIPPED:
                halt(child)
                return outcome
            if outcome is not self.counted:
                return self._finish(outcome)
            self._count += 1
            if outcome is FAILURE:
                limit = self._most = self.read(
                    self.limit
                )  # the child may have changed it; only RetryUntilSuccessful rereads it
            if at_once and (limit == -1 or self._count < limit):
                self.runtime.tick_again = True
                return RUNNING
        return self._finish(self.counted)

    def _finish(self, outcome: Status) -> Outcome:
        text = counted_text(self.round, self._count + (self.counted is SUCCESS), self._most)
        self.feedback_message = f"{text} failed" if text and outcome is FAILURE else ""
        self._count = 0
        self.status = outcome
        return outcome


class Repeat(_Counted):
    """Ticks the child until it has succeeded `num_cycles` times; FAILURE as soon as it fails, SKIPPED if it is skipped.

    A skipped child does not reset the count. `num_cycles` 0 gives SUCCESS at once.
    """

    counted = SUCCESS
    limit = "num_cycles"
    round = "cycle"
    num_cycles: Annotated[int, "number of successes; -1 for no limit"]


class RetryUntilSuccessful(_Counted):
    """Ticks the child until it succeeds, at most `num_attempts` times; SKIPPED if it is skipped.

    `num_attempts` 0 gives FAILURE at once. The port is read again after each failure.
    """

    counted = FAILURE
    limit = "num_attempts"
    round = "attempt"
    num_attempts: Annotated[int, "maximum number of attempts; -1 for no limit"]


class _Loop(Decorator):
    """Per tick: takes one item off the queue, writes it to `value` and ticks the child; `if_empty` if no item is left.

    RUNNING while there are items, FAILURE as soon as the child fails. A list on the blackboard is emptied in place; any
    other queue, such as a text, is read when a run begins, so that each run has all items.
    """

    item: ClassVar[Any] = str
    queue: Annotated[InOut[Any], "items"] = None
    if_empty: Annotated[Status, "outcome if the queue is empty"] = SUCCESS

    def __init__(self, name: str, child: Any, /, **attributes: Any) -> None:
        super().__init__(name, child, **attributes)
        self._items: list[Any] | None = None
        self._under_way = False

    def halted(self) -> None:
        self._under_way = False
        super().halted()

    def tick_once(self) -> Outcome:
        if self.status is not RUNNING:
            self._under_way = False
            self._items = None
        if not self._under_way:
            items = self._queue()
            if not items:
                return self._store(self.if_empty)
            self.write("value", converted(items.pop(0), self.item, self.board.enums))
        self.status = RUNNING
        outcome = self.tick_child()
        self._under_way = outcome is RUNNING
        return self._store(FAILURE if outcome is FAILURE else RUNNING)

    def _store(self, outcome: Outcome) -> Outcome:
        if outcome is not SKIPPED:
            self.status = outcome
        elif self.status is not RUNNING:
            self.status = IDLE
        return outcome

    def _queue(self) -> list[Any]:
        key = self.key("queue")
        entry = None if key is None else self.board.entry(key)
        source = self.given.get("queue") if key is None else None if entry is None else entry.value
        if key is not None and isinstance(source, list):
            return source
        if self._items is None:
            # Items are converted one by one when their turn comes, so that the list is copied here and not converted.
            kind = GenericAlias(list, (self.item if isinstance(source, str) else object,))
            found = [] if source is None else converted(source, kind, self.board.enums)
            self._items = list(found)
        return self._items

    def bound_faults(self) -> Iterable[tuple[str, Fault]]:
        text = self.given.get("queue")
        if isinstance(text, str) and self.key("queue") is None:
            try:
                self._queue()
            except InputError as error:
                yield from (("queue", fault) for fault in error.faults)


def _loop(name: str, item: type[Any], what: str) -> type[_Loop]:
    """Create a loop class."""
    value = port_of(item, "current item", Direction.OUTPUT)
    doc = f"Loop over {what}. {_Loop.__doc__}"
    return type(name, (_Loop,), {"item": item, "value": value, "__doc__": doc, "__module__": __name__})


LoopString, LoopInt = _loop("LoopString", str, "strings"), _loop("LoopInt", int, "integers")
LoopDouble, LoopBool = _loop("LoopDouble", float, "numbers"), _loop("LoopBool", bool, "booleans")


class _Mapping(Decorator):
    """Replaces the child's outcome as given by a table; outcomes that are not in the table pass unchanged."""

    table: ClassVar[Mapping[Outcome, Outcome]] = {}

    def tick_once(self) -> Outcome:
        self.status = RUNNING
        child: Any = self.decorated
        outcome = child.tick_once() or child.status
        if outcome is IDLE:
            raise no_outcome(child, outcome)
        outcome = self.table.get(outcome, outcome)
        if outcome is not SKIPPED:
            self.status = outcome
        return outcome


class Inverter(_Mapping):
    """SUCCESS if the child fails, FAILURE if it succeeds."""

    table: ClassVar[Mapping[Outcome, Outcome]] = {SUCCESS: FAILURE, FAILURE: SUCCESS}


class ForceSuccess(_Mapping):
    """SUCCESS as soon as the child has ended, with either outcome."""

    table: ClassVar[Mapping[Outcome, Outcome]] = {FAILURE: SUCCESS}


class ForceFailure(_Mapping):
    """FAILURE as soon as the child has ended, with either outcome."""

    table: ClassVar[Mapping[Outcome, Outcome]] = {SUCCESS: FAILURE}


class KeepRunningUntilFailure(_Mapping):
    """Ticks the child repeatedly until it fails; RUNNING until then, also if the child is skipped."""

    table: ClassVar[Mapping[Outcome, Outcome]] = {SUCCESS: RUNNING, SKIPPED: RUNNING}


class RunOnce(Decorator):
    """Ticks the child until it has ended; afterwards returns SKIPPED or the child's outcome, and is never reset."""

    then_skip: Annotated[bool, "whether to return SKIPPED afterwards"] = True

    def __init__(self, name: str, child: Any, /, **attributes: Any) -> None:
        super().__init__(name, child, **attributes)
        self._outcome: Outcome | None = None

    def tick_once(self) -> Outcome:
        if self._outcome is not None:
            outcome = SKIPPED if self.then_skip else self._outcome
            self.status = IDLE if outcome is SKIPPED else outcome
            return outcome
        self.status = RUNNING
        outcome = self.tick_child()
        if outcome is not SKIPPED:
            self.status = outcome
            if outcome is not RUNNING:
                self._outcome = outcome
        return outcome


class Precondition(Decorator):
    """Ticks the child once the script `if` is true, until the child has ended; returns `else` while it is false.

    The script is not evaluated while the child is RUNNING.
    """

    if_: Annotated[ConditionText, "script"]
    else_: Annotated[Status, "outcome while the script is false"] = FAILURE

    def __init__(self, name: str, child: Any, /, **attributes: Any) -> None:
        super().__init__(name, child, **attributes)
        self._under_way = False
        self._compiled: tuple[str, Callable[[], bool]] | None = None

    def bind(self, board: Any, runtime: Any) -> Any:
        self._compiled = None
        below = super().bind(board, runtime)
        if self.key("if") is None:
            self._compile(self.given["if"])
        return below

    def halted(self) -> None:
        self._under_way = False
        super().halted()

    def tick_once(self) -> Outcome:
        outcome: Outcome
        if self._under_way or self._holds():
            self._under_way = True
            outcome = self.tick_child()
            if outcome is not RUNNING and outcome is not SKIPPED:
                self._under_way = False
        else:
            outcome = self.else_
        if outcome is not SKIPPED:
            self.status = outcome
        elif self.status is not RUNNING:
            self.status = IDLE
        return outcome

    def wait_text(self) -> str:
        return "" if self._under_way else script_reading(self.if_, self.board)

    def _holds(self) -> bool:
        text = self.if_
        if self._compiled is None or self._compiled[0] != text:
            self._compile(text)
        return self._compiled[1]()  # type: ignore[index]  # it is compiled above

    def _compile(self, text: str) -> None:
        self._compiled = text, compile_condition(parse_script(text), self.board)


TIME_TOLERANCE = 1e-9
"""Tolerance of deadlines [s]; it covers the rounding error of a time that is computed as k * step."""


class _Timed(Decorator):
    def __init__(self, name: str, child: Any, /, **attributes: Any) -> None:
        super().__init__(name, child, **attributes)
        self._deadline: float | None = None

    def halted(self) -> None:
        self._deadline = None
        super().halted()

    def wait_text(self) -> str:
        return "" if self._deadline is None else f"until {self._deadline:.2f} s"

    def _due(self, milliseconds: int) -> bool:
        """Whether a duration [ms] has passed since the first call in this run."""
        now = self.runtime.now()
        if self._deadline is None:
            self._deadline = now + milliseconds / 1000.0
            self.status = RUNNING
        return now >= self._deadline - TIME_TOLERANCE

    def _ended(self, outcome: Outcome) -> Outcome:
        """End the node with the outcome of its child, unless the child was skipped; raises TreeError."""
        if outcome is IDLE:
            raise no_outcome(self.decorated, outcome)
        if outcome is not SKIPPED:
            self._deadline = None
            self.status = outcome
        return outcome


class Timeout(_Timed):
    """FAILURE once the child has been RUNNING for `msec` milliseconds; the child is then halted. 0 means no limit."""

    msec: Annotated[int, "maximum run time of the child [ms]"]

    def tick_once(self) -> Outcome:
        child: Any = self.decorated
        limit = self.read("msec")
        if limit <= 0:
            self.status = RUNNING
        elif self._due(limit) and child.status is RUNNING:
            halt(child)
            self.feedback_message = f"after {limit} ms"
            return self._ended(FAILURE)
        outcome = child.tick_once() or child.status
        return outcome if outcome is RUNNING else self._ended(outcome)


class Delay(_Timed):
    """RUNNING for `delay_msec` milliseconds; then ticks the child."""

    delay_msec: Annotated[int, "delay [ms]"]

    def begins_running(self) -> bool:
        return self.key("delay_msec") is None and self.read("delay_msec") > 0

    def tick_once(self) -> Outcome:
        if not self._due(self.delay_msec):
            self.status = RUNNING
            return RUNNING
        child: Any = self.decorated
        outcome = child.tick_once() or child.status
        return outcome if outcome is RUNNING else self._ended(outcome)


class _Updated(Decorator):
    """Ticks the child if the key was written since the node's last tick, and while the child is RUNNING."""

    otherwise: ClassVar[Outcome] = SKIPPED
    entry: Annotated[Any, Syntax(key_name), "key"]

    def __init__(self, name: str, child: Any, /, **attributes: Any) -> None:
        super().__init__(name, child, **attributes)
        self._seen = 0

    def tick_once(self) -> Outcome:
        outcome = self.tick_child() if self.decorated.status is RUNNING or self._written() else self.otherwise
        if outcome is not SKIPPED:
            self.status = outcome
        elif self.status is not RUNNING:
            self.status = IDLE
        return outcome

    def _written(self) -> bool:
        entry = self.board.entry(self.key("entry") or str(self.given["entry"]))
        before, self._seen = self._seen, 0 if entry is None else entry.sequence
        return entry is not None and before != self._seen


class SkipUnlessUpdated(_Updated):
    """Ticks the child if the key `entry` was written since the node's last tick; SKIPPED otherwise."""

    otherwise = SKIPPED


class WaitValueUpdate(_Updated):
    """Ticks the child if the key `entry` was written since the node's last tick; RUNNING otherwise."""

    otherwise = RUNNING

    def wait_text(self) -> str:
        name = self.key("entry") or self.given["entry"]
        return "" if self.decorated.status is RUNNING else f"for a new value of '{name}'"
