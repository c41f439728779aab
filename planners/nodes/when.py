"""When: condition on the robot's signals, in the expression language of the rule files."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated

from rocs_bt import Fault, InputError
from rocs_bt.plan import SignalCondition, mission_of
from rocs_bt.trees.nodes import FAILURE, SUCCESS, Instant, Outcome


class When(Instant):
    """SUCCESS while an expression is true, FAILURE while it is false or invalid; never RUNNING.

        <When expression="min(front) > 0.5 m and speed < 0.1 m/s"/>

    In XML, `<` need not be escaped here. If the expression is not true, the feedback contains its current values.
    """

    kind = "Condition"
    expression: Annotated[str, "expression over the signals, true or false"]

    def bind(self, board, runtime):
        self._text, self._condition = None, None
        return super().bind(board, runtime)

    def bound_faults(self) -> Iterator[tuple[str, Fault]]:
        key = self.key("expression")
        if key is None:
            text = self.expression
        else:  # its value at the beginning, such as a parameter of the mission
            entry = self.board.entry(key)
            text = entry.value if entry is not None and mission_of(self).fit else None
        if isinstance(text, str):
            try:
                self._compiled(text)
            except InputError as error:
                faults = error.faults if key is None else [replace(fault, column=0) for fault in error.faults]
                yield from (("expression", fault) for fault in faults)

    def update(self) -> Outcome:
        condition = self._compiled(self.expression)
        if condition.holds():
            return SUCCESS
        self.feedback_message = f"'{self._text}' does not hold: {condition.reading()}"
        return FAILURE

    def wait_text(self) -> str:
        return "" if self._condition is None else f"{self._text}, {self._condition.reading()}"

    def _compiled(self, text: str) -> SignalCondition:
        if self._condition is None or text != self._text:
            self._text, self._condition = text, mission_of(self).signal_condition(text)
        return self._condition
