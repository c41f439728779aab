"""UseStrategy: act by the best strategy, fall back if it fails, and record the outcome."""

from typing import Annotated

from rocs_bt import Failure, KnowledgeError, Reason
from rocs_bt.plan import mission_of
from rocs_bt.trees.nodes import FAILURE, RUNNING, SKIPPED, SUCCESS, Decorator, Outcome, Output, halt


class UseStrategy(Decorator):
    """Selects the best strategy in the present situation and ticks its child, which acts according to `selected`.

        <UseStrategy selected="{way}">
          <Switch2 variable="{way}" case_1="through" case_2="around">
            ...

    SUCCESS if the child succeeds. If the child fails, the next strategy is the fallback of the active one, or the best
    of the other applicable ones, until one succeeds or none is left: FAILURE. Each use is recorded in the robot's
    Knowledge with the situation and the outcome, so that a strategy that has worked in a similar situation is
    preferred. `rocs-bt knowledge why` explains each choice.
    """

    role: Annotated[str, "role that the strategy must suit; the robot's own if empty"] = ""
    selected: Annotated[Output[str], "name of the active strategy"]

    def __init__(self, name, child, /, **attributes):
        super().__init__(name, child, **attributes)
        self._use, self._tried = None, []

    @property
    def _strategies(self):
        return mission_of(self).knowledge.strategy

    def halted(self) -> None:
        self._end("halted")
        self._tried = []
        super().halted()

    def tick_once(self) -> Outcome:
        self.status = RUNNING
        while True:
            if self._use is None and not self._begin():
                return self._finish(FAILURE)
            outcome = self.tick_child()
            if outcome is RUNNING:
                return RUNNING
            if outcome is SKIPPED:
                self._end("halted")
                halt(self.decorated)
                self._tried = []
                return SKIPPED
            self._end("success" if outcome is SUCCESS else "failure", self._reason(outcome))
            if outcome is SUCCESS:
                return self._finish(SUCCESS)

    def _begin(self) -> bool:
        """Activate the next strategy to try; False if there is none."""
        strategies = self._strategies
        try:
            after = strategies.after(self._tried[-1], self._tried) if self._tried else None
            choice = strategies.choose(self.role, self._tried)
            name = after or choice.best
            why = f"'{self._tried[-1]}' falls back to it\n{choice}" if after else str(choice)
            if name is None:
                self.feedback_message = str(Failure(Reason.CANNOT, f"no strategy is applicable. {choice}"))
                return False
            self._use = strategies.begin(name, why, choice.situation)
        except KnowledgeError as error:
            self.feedback_message = str(Failure(Reason.CANNOT, str(error)))
            return False
        self._tried.append(name)
        self.selected = name
        self.feedback_message = f"by {name}"
        return True

    def _reason(self, outcome: Outcome) -> str:
        tip = self.decorated.tip() if outcome is FAILURE else None
        return "" if tip is None else f"{tip.name}: {tip.feedback_message}".rstrip(": ")

    def _end(self, outcome: str, reason: str = "") -> None:
        if self._use is not None:
            self._strategies.end(self._use, outcome, reason)
            self._use = None

    def _finish(self, outcome: Outcome) -> Outcome:
        self._tried = []
        self.status = outcome
        return outcome
