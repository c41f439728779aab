"""FinishTask: mark tasks in Knowledge as done."""

from typing import Annotated

from rocs_bt.plan import mission_of
from rocs_bt.trees.nodes import FAILURE, SUCCESS, Instant, Outcome


class FinishTask(Instant):
    """Sets all open tasks that serve a goal to done; FAILURE if there is none.

    <FinishTask goal="{next}"/>
    """

    goal: Annotated[str, "goal that the tasks serve"]

    def update(self) -> Outcome:
        graph, goal = mission_of(self).knowledge.graph, self.goal
        open_ = [task for task in graph.nodes("task") if graph.get(task, "state") == "open"]
        done = [task for task in open_ if goal in graph.related(task, "serves")]
        for task in done:
            graph.set(task, state="done")
        self.feedback_message = f"done: {', '.join(done)}" if done else f"no open task serves '{goal}'"
        return SUCCESS if done else FAILURE
