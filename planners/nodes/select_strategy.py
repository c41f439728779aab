"""SelectStrategy: activate a strategy by name, the best one, or the fallback of the active one."""

from typing import Annotated

from rocs_bt import Failure, KnowledgeError, Reason
from rocs_bt.base.errors import did_you_mean
from rocs_bt.plan import mission_of
from rocs_bt.trees.nodes import FAILURE, SUCCESS, Instant, Outcome, Output


class SelectStrategy(Instant):
    """Activates a strategy of the robot's StrategyModel.

        <SelectStrategy strategy="careful"/>
        <SelectStrategy selected="{way}"/>

    Without a name: the best strategy in the present situation if none is active, else the fallback of the active one.
    FAILURE if there is no such strategy, no applicable one, or no fallback. Only `UseStrategy` records the outcomes of
    strategies.
    """

    strategy: Annotated[str, "name of the strategy; if empty, the best one or the fallback of the active one"] = ""
    role: Annotated[str, "role that the best strategy must suit; the robot's own if empty"] = ""
    selected: Annotated[Output[str], "name of the active strategy"]

    def update(self) -> Outcome:
        strategies, name = mission_of(self).knowledge.strategy, self.strategy
        try:
            if not name:
                name = self._next(strategies)
            elif name not in strategies.names():
                hint = did_you_mean(name, strategies.names(), "The robot")
                return self._fail(f"no strategy is named '{name}'. {hint}")
        except KnowledgeError as error:
            return self._fail(str(error))
        if not name:
            return FAILURE
        strategies.use(name)
        self.selected = name
        self.feedback_message = f"by {name}"
        return SUCCESS

    def _next(self, strategies) -> str:
        """Name of the strategy to activate; empty if there is none, with the reason in the feedback."""
        used = strategies.used()
        if used is None:
            choice = strategies.choose(self.role)
            if choice.best is None:
                self._fail(f"no strategy is applicable. {choice}")
            return choice.best or ""
        fallbacks = strategies.fallbacks(used)
        if not fallbacks:
            self._fail(f"'{used}' has no fallback")
        return fallbacks[0] if fallbacks else ""

    def _fail(self, evidence: str) -> Outcome:
        self.feedback_message = str(Failure(Reason.CANNOT, evidence))
        return FAILURE
