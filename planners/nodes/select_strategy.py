"""Put another strategy in force, or what the present one falls back to."""

from rocs_bt.action import Failure, Reason
from rocs_bt.errors import did_you_mean
from rocs_bt.plan.nodes import FAILURE, SUCCESS, Input, Instant, Outcome, Output


class SelectStrategy(Instant):
    """Puts a strategy of the robot's StrategyModel in force; without a name, what the present one falls back to.

        <SelectStrategy strategy="careful"/>
        <SelectStrategy selected="{way}"/>

    FAILURE if there is no such strategy, or nothing to fall back to.
    """

    strategy = Input(str, "", "its name; what the present one falls back to where empty")
    selected = Output(str, "the strategy that is in force now")

    def update(self) -> Outcome:
        strategies, name = self.runtime.mission.knowledge.strategy, self.strategy
        if not name:
            used = strategies.used()
            fallbacks = strategies.fallbacks(used) if used else []
            if not fallbacks:
                told = f"'{used}' falls back to nothing" if used else "no strategy is in force"
                self.feedback_message = str(Failure(Reason.CANNOT, told))
                return FAILURE
            name = fallbacks[0]
        if name not in strategies.names():
            hint = did_you_mean(name, strategies.names(), "The robot")
            self.feedback_message = str(Failure(Reason.CANNOT, f"no strategy is named '{name}'. {hint}"))
            return FAILURE
        strategies.use(name)
        self.selected = name
        self.feedback_message = f"by {name}"
        return SUCCESS
