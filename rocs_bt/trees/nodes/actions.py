"""Action nodes of BehaviorTree.CPP: constants, blackboard access, scripts, Sleep and TestNode."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Annotated, Any

from py_trees.behaviour import Behaviour

from ...base.errors import Fault
from ..board import Board, BoardEntry
from ..error import TreeError
from ..script import Script as Parsed
from ..script import compile_condition, compile_script, parse_script, script_reading
from ..status import FAILURE, IDLE, RUNNING, SUCCESS, Outcome, outcome_named
from .base_classes import Instant, Leaf
from .decorators import TIME_TOLERANCE
from .port import ConditionText, InOut, ScriptText, Syntax, key_name, pointer
from .runtime import Runtime


class AlwaysSuccess(Instant):
    """Returns SUCCESS."""

    def tick_once(self) -> Outcome:
        self.status = SUCCESS
        return SUCCESS

    def update(self) -> Outcome:
        return SUCCESS


class AlwaysFailure(Instant):
    """Returns FAILURE."""

    def tick_once(self) -> Outcome:
        self.status = FAILURE
        return FAILURE

    def update(self) -> Outcome:
        return FAILURE


class SetBlackboard(Instant):
    """Writes a text, or a copy of another key's value and type, to a key; FAILURE if the other key has no value."""

    value: Annotated[Any, "text, or a key such as {source}"]
    output_key: Annotated[InOut[str], Syntax(key_name), "name of the key to write, with or without braces"]

    def __init__(self, name: str = "", /, **attributes: Any) -> None:
        super().__init__(name, **attributes)
        self._source = self.key("value")
        self._key = self.key("output_key")
        self._number: tuple[Any, Any, Any] = None, None, None

    def update(self) -> Outcome:
        board, key = self.board, self._key
        if key is None:
            key = self.given["output_key"]
        else:
            named = board.entry(key)
            # With braces, BehaviorTree.CPP uses the named key's value as the name of the key to write. Most users mean
            # the named key itself, as in older versions, so this applies only if the value is text.
            if named is not None and named.value.__class__ is str:
                key = named.value
        target = board.entry(key)
        if self._source is None:
            value: Any = self.given["value"]
        else:
            entry = board.entry(self._source)
            if entry is None:
                raise TreeError(Fault(f"'{self.name}' cannot copy the key '{self._source}': it does not exist."))
            target = target or board.declare(key, entry.kind)
            value = entry.value
            if value is None:
                return FAILURE
        if target is None:
            board[key] = value
        elif target.kind is None or target.kind is value.__class__:
            target.store(value)  # a copy fixes no type
        elif self._source is None and target.kind in (bool, int, float):
            target.store(self._as_number(key, target, value))
        else:
            target.store(board.fitted(key, target, value))
        return SUCCESS

    def _as_number(self, key: str, entry: BoardEntry, value: Any) -> Any:
        """Convert the literal to the key's type; the result is cached."""
        enums = self.board.enums
        if self._number[0] is not entry or self._number[1] is not enums:
            self._number = entry, enums, self.board.fitted(key, entry, value)
        return self._number[2]


class UnsetBlackboard(Instant):
    """Removes a key from the blackboard of this tree; returns SUCCESS."""

    key_: Annotated[str, Syntax(key_name), "key, without braces"]

    def update(self) -> Outcome:
        self.board.unset(self.read("key"))
        return SUCCESS


class WasEntryUpdated(Instant):
    """SUCCESS if the key was written since the node's last tick, else FAILURE."""

    kind = "Action"
    entry: Annotated[Any, Syntax(key_name), "key"]

    def __init__(self, name: str = "", /, **attributes: Any) -> None:
        super().__init__(name, **attributes)
        self._seen = 0

    def update(self) -> Outcome:
        entry = self.board.entry(self.key("entry") or str(self.given["entry"]))
        before, self._seen = self._seen, 0 if entry is None else entry.sequence
        return SUCCESS if entry is not None and before != self._seen else FAILURE


class _Scripted(Instant):
    code: Annotated[ScriptText, "script"]

    def __init__(self, name: str = "", /, **attributes: Any) -> None:
        super().__init__(name, **attributes)
        self._run: Callable[[], Any] | None = None
        self._last: tuple[str, Callable[[], Any]] | None = None

    def bind(self, board: Board, runtime: Runtime) -> Iterable[tuple[Behaviour, Board]]:
        self._run = self._last = None
        below = super().bind(board, runtime)
        code = self.given["code"]
        if pointer(code) is None:
            self._run = self.compiled(parse_script(code))
        return below

    def compiled(self, script: Parsed) -> Callable[[], Any]:
        """Compile the script to a function."""
        return compile_script(script, self.board)

    def _read(self) -> Callable[[], Any]:
        """Compiled script of a node that reads its script from the blackboard, or that is not bound to a tree."""
        text = self.code
        if self._last is None or self._last[0] != text:
            self._last = text, self.compiled(parse_script(text))
        return self._last[1]


class Script(_Scripted):
    """Runs a script, such as `tries += 1; ready := tries > 2`; returns SUCCESS."""

    def tick_once(self) -> Outcome:
        (self._run or self._read())()
        self.status = SUCCESS
        return SUCCESS


class ScriptCondition(_Scripted):
    """SUCCESS if a script is true, else FAILURE."""

    kind = "Condition"
    code: Annotated[ConditionText, "script"]

    def compiled(self, script: Parsed) -> Callable[[], Any]:
        return compile_condition(script, self.board)

    def tick_once(self) -> Outcome:
        self.status = outcome = SUCCESS if (self._run or self._read())() else FAILURE
        return outcome

    def wait_text(self) -> str:
        return script_reading(self.code, self.board)


class Sleep(Leaf):
    """RUNNING for `msec` milliseconds of the tree's clock, then SUCCESS."""

    msec: Annotated[int, "duration [ms]"]

    def begins_running(self) -> bool:
        return self.key("msec") is None and self.read("msec") > 0

    def __init__(self, name: str = "", /, **attributes: Any) -> None:
        super().__init__(name, **attributes)
        self._until = 0.0

    def initialise(self) -> None:
        milliseconds = self.msec
        self._until = self.runtime.now() + milliseconds / 1000.0 if milliseconds > 0 else 0.0

    def update(self) -> Outcome:
        return SUCCESS if not self._until or self.runtime.now() >= self._until - TIME_TOLERANCE else RUNNING

    def wait_text(self) -> str:
        return f"until {self._until:.2f} s" if self.status is RUNNING else ""


class TestNode(Leaf):
    """Returns `return_status` after `async_delay` milliseconds and runs a script that depends on the outcome.

    `return_status_script`, if given, is a script that returns the status: a number (1 RUNNING, 2 SUCCESS, 3 FAILURE,
    4 SKIPPED) or a name.
    """

    __test__ = False  # not pytest's

    return_status: Annotated[str, "outcome"] = "SUCCESS"
    return_status_script: Annotated[ScriptText, "script that returns the outcome"] = ""
    success_script: Annotated[ScriptText, "script run on SUCCESS"] = ""
    failure_script: Annotated[ScriptText, "script run on FAILURE"] = ""
    post_script: Annotated[ScriptText, "script run after any outcome"] = ""
    async_delay: Annotated[int, "time as RUNNING before the outcome [ms]"] = 0

    def __init__(self, name: str = "", /, **attributes: Any) -> None:
        super().__init__(name, **attributes)
        self._until: float | None = None
        self._compiled: dict[str, Callable[[], Any]] = {}

    def bind(self, board: Board, runtime: Runtime) -> Iterable[tuple[Behaviour, Board]]:
        self._compiled = {}
        below = super().bind(board, runtime)
        for port, text in self.given.items():
            if self.ports[port].is_code and pointer(text) is None and text:
                self._compiled[text] = compile_script(parse_script(text), board)
        return below

    def initialise(self) -> None:
        delay = self.async_delay
        self._until = self.runtime.now() + delay / 1000.0 if delay > 0 else None

    def update(self) -> Outcome:
        if self._until is not None and self.runtime.now() < self._until - TIME_TOLERANCE:
            return RUNNING
        outcome = self._outcome()
        if outcome is SUCCESS:
            self._run(self.success_script)
        elif outcome is FAILURE:
            self._run(self.failure_script)
        self._run(self.post_script)
        return outcome

    def wait_text(self) -> str:
        return f"until {self._until:.2f} s" if self.status is RUNNING and self._until is not None else ""

    def _outcome(self) -> Outcome:
        script = self.return_status_script
        value = self._run(script) if script else self.return_status
        names = ("IDLE", "RUNNING", "SUCCESS", "FAILURE", "SKIPPED")
        if isinstance(value, (int, float)) and value in range(len(names)):
            value = names[int(value)]
        outcome = outcome_named(str(value))
        if outcome is IDLE:
            raise TreeError(Fault(f"'{self.name}' cannot return IDLE."))
        return outcome

    def _run(self, script: str) -> Any:
        if not script:
            return None
        run = self._compiled.get(script) or compile_script(parse_script(script), self.board)
        return run()
