"""TestNode: stands in for a node that cannot be run here (BehaviorTree.CPP, actions/test_node)."""

from __future__ import annotations

from typing import Any

from ....errors import Fault
from ...error import TreeError
from ...script import compile_script, parse_script
from ...status import FAILURE, IDLE, RUNNING, SUCCESS, Outcome, outcome_named
from ..decorator.timing import FORGIVEN
from ..family import Leaf
from ..port import Code, Input


class TestNode(Leaf):
    """Comes to `return_status`, after `async_delay` milliseconds, and runs a script for what it came to.

    `return_status_script`, where it is given, is a script whose value is the status: a number (1 RUNNING, 2 SUCCESS,
    3 FAILURE, 4 SKIPPED) or its name.
    """

    __test__ = False  # not pytest's

    return_status = Input(str, "SUCCESS", "what it comes to")
    return_status_script = Code("", "a script that tells what it comes to")
    success_script = Code("", "run on SUCCESS")
    failure_script = Code("", "run on FAILURE")
    post_script = Code("", "run in any case")
    async_delay = Input(int, 0, "how long it is RUNNING before [ms]")

    def __init__(self, name: str = "", /, **attributes: Any) -> None:
        super().__init__(name, **attributes)
        self._until: float | None = None

    def initialise(self) -> None:
        delay = self.async_delay
        self._until = self.runtime.now() + delay / 1000.0 if delay > 0 else None

    def update(self) -> Outcome:
        if self._until is not None and self.runtime.now() < self._until - FORGIVEN:
            return RUNNING
        outcome = self._outcome()
        if outcome is SUCCESS:
            self._run(self.success_script)
        elif outcome is FAILURE:
            self._run(self.failure_script)
        self._run(self.post_script)
        return outcome

    def _outcome(self) -> Outcome:
        script = self.return_status_script
        value = self._run(script) if script else self.return_status
        names = ("IDLE", "RUNNING", "SUCCESS", "FAILURE", "SKIPPED")
        if isinstance(value, (int, float)) and value in range(len(names)):
            value = names[int(value)]
        outcome = outcome_named(str(value))
        if outcome is IDLE:
            raise TreeError(Fault(f"'{self.name}' cannot come to IDLE."))
        return outcome

    def _run(self, script: str) -> Any:
        return compile_script(parse_script(script), self.board)() if script else None
