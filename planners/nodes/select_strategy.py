"""Put another strategy in force: one by name, the best one now, or what the present one falls back to."""

from rocs_bt.action import Failure, Reason
from rocs_bt.errors import KnowledgeError, did_you_mean
from rocs_bt.plan import mission_of
from rocs_bt.trees.nodes import FAILURE, SUCCESS, Input, Instant, Outcome, Output


class SelectStrategy(Instant):
    """Puts a strategy of the robot's StrategyModel in force.

        <SelectStrategy strategy="careful"/>
        <SelectStrategy selected="{way}"/>

    Without a name it is the best one in the present situation where none is in force, else what the present one falls
    back to. FAILURE if there is no such strategy, none that serves, or nothing to fall back to. What comes of it only
    `UseStrategy` keeps.
    """

    strategy = Input(str, "", "its name; the best one, or what the present one falls back to, where empty")
    role = Input(str, "", "the role that the best one must suit; the robot's own where empty")
    selected = Output(str, "the strategy that is in force now")

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
        """The strategy to take; empty where there is none, which is told."""
        used = strategies.used()
        if used is None:
            choice = strategies.choose(self.role)
            if choice.best is None:
                self._fail(f"no strategy serves now. {choice}")
            return choice.best or ""
        fallbacks = strategies.fallbacks(used)
        if not fallbacks:
            self._fail(f"'{used}' falls back to nothing")
        return fallbacks[0] if fallbacks else ""

    def _fail(self, told: str) -> Outcome:
        self.feedback_message = str(Failure(Reason.CANNOT, told))
        return FAILURE
