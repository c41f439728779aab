"""Ask an expression over the robot's signals, in the language of the rule files."""

from collections.abc import Iterator

from rocs_bt.errors import Fault, InputError
from rocs_bt.plan import Question, mission_of
from rocs_bt.trees.nodes import FAILURE, SUCCESS, Input, Instant, Outcome


class When(Instant):
    """SUCCESS while an expression holds, FAILURE while it does not or cannot be told; never RUNNING.

        <When expression="min(front) > 0.5 m and speed < 0.1 m/s"/>

    In the file, `<` may stand as it is. What it reads is in the feedback where it does not hold.
    """

    kind = "Condition"
    expression = Input(str, doc="over the signals, true or false")

    def bind(self, board, runtime):
        self._text, self._question = None, None
        return super().bind(board, runtime)

    def bound_faults(self) -> Iterator[tuple[str, Fault]]:
        if self.key("expression") is None:
            try:
                self._ask(self.expression)
            except InputError as error:
                yield from (("expression", fault) for fault in error.faults)

    def update(self) -> Outcome:
        question = self._ask(self.expression)
        if question.holds():
            self.feedback_message = ""
            return SUCCESS
        self.feedback_message = f"'{self._text}' does not hold: {question.reading()}"
        return FAILURE

    def _ask(self, text: str) -> Question:
        if self._question is None or text != self._text:
            self._text, self._question = text, mission_of(self).ask(text)
        return self._question
