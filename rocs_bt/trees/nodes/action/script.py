"""Leaves that run scripts."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from py_trees.behaviour import Behaviour

from ...board import Board
from ...script import Script as Parsed
from ...script import compile_condition, compile_script, parse_script
from ...status import FAILURE, SUCCESS, Outcome
from ..family import Instant
from ..port import Code, pointer
from ..runtime import Runtime


class _Scripted(Instant):
    code = Code(doc="the script")

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
        """The script as a function."""
        return compile_script(script, self.board)

    def _read(self) -> Callable[[], Any]:
        """The script of a node that is in no tree, or whose script is on the board."""
        text = self.code
        if self._last is None or self._last[0] != text:
            self._last = text, self.compiled(parse_script(text))
        return self._last[1]


class Script(_Scripted):
    """Runs a script, such as `tries += 1; ready := tries > 2`; SUCCESS."""

    def tick_once(self) -> Outcome:
        (self._run or self._read())()
        self.status = SUCCESS
        return SUCCESS


class ScriptCondition(_Scripted):
    """SUCCESS if a script holds, FAILURE if it does not."""

    kind = "Condition"

    def compiled(self, script: Parsed) -> Callable[[], Any]:
        return compile_condition(script, self.board)

    def tick_once(self) -> Outcome:
        self.status = outcome = SUCCESS if (self._run or self._read())() else FAILURE
        return outcome
