"""Leaves that run scripts."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...script import Script as Parsed
from ...script import compile_condition, compile_script, parse_script
from ...status import FAILURE, SUCCESS, Outcome
from ..family import Instant
from ..port import Code


class _Scripted(Instant):
    code = Code(doc="the script")

    def __init__(self, name: str = "", /, **attributes: Any) -> None:
        super().__init__(name, **attributes)
        self._text: str | None = None
        self._run: Callable[[], Any] = lambda: None

    def bind(self, board: Any, runtime: Any) -> Any:
        self._text = None
        return super().bind(board, runtime)

    def compiled(self, script: Parsed) -> Callable[[], Any]:
        """The script as a function."""
        return compile_script(script, self.board)

    def evaluate(self) -> Any:
        """The script's value now; its text may come from the board."""
        if self._text is None or self.key("code") is not None:
            text = self.code
            if text != self._text:
                self._text, self._run = text, self.compiled(parse_script(text))
        return self._run()


class Script(_Scripted):
    """Runs a script, such as `tries += 1; ready := tries > 2`; SUCCESS."""

    def update(self) -> Outcome:
        self.evaluate()
        return SUCCESS


class ScriptCondition(_Scripted):
    """SUCCESS if a script holds, FAILURE if it does not."""

    kind = "Condition"

    def compiled(self, script: Parsed) -> Callable[[], Any]:
        return compile_condition(script, self.board)

    def update(self) -> Outcome:
        return SUCCESS if self.evaluate() else FAILURE
