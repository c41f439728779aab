"""Ask: condition that evaluates a query on the robot's Knowledge."""

from collections.abc import Iterator
from typing import Annotated, Any

from rocs_bt import Fault, InputError
from rocs_bt.knowledge import compile_query
from rocs_bt.knowledge.query import read_parameters
from rocs_bt.plan import mission_of
from rocs_bt.trees.nodes import FAILURE, SUCCESS, Instant, Outcome, Output


class Ask(Instant):
    """SUCCESS if a query has an answer, else FAILURE; never RUNNING.

        <Ask query="peer where distance(peer) < 2 m order by distance(peer)" found="{who}"/>
        <Ask query="object where distance(pose, path) < 0.4 m" path="{way}"/>
        <Ask query="goal, no peer pursues goal where goal == it" it="{goal}"/>

    The query language is documented in docs/knowledge.md. Without outputs the search stops at the first answer.
    """

    kind = "Condition"
    query: Annotated[str, "query"]
    path: Annotated[list | None, "value of `path` in the query: corners, (x, y) in the world frame [m]"] = None
    it: Annotated[str, "value of `it` in the query: name of a node"] = ""
    found: Annotated[Output[str], "name of the first node that matches"]
    names: Annotated[Output[list], "names of all nodes that match"]
    count: Annotated[Output[int], "number of answers"]

    def bound_faults(self) -> Iterator[tuple[str, Fault]]:
        if self.key("query") is not None:
            return
        knowledge = mission_of(self).knowledge
        example: dict[str, Any] = {"path": [(0.0, 0.0)], "it": ""}
        parameters = {name: value for name, value in example.items() if name in self.given}
        signals = knowledge.signals if knowledge.signals.frozen else None
        try:
            compile_query(self.query, knowledge.graph.schema, signals, read_parameters(parameters)[0])
        except InputError as error:
            yield from (("query", fault) for fault in error.faults)

    def update(self) -> Outcome:
        knowledge, text = mission_of(self).knowledge, self.query
        parameters = {name: getattr(self, name) for name in ("path", "it") if name in self.given}
        if not {"found", "names", "count"} & self.given.keys():
            return self._outcome(knowledge.holds(text, **parameters), text)
        answers = knowledge.ask(text, **parameters)
        self.names, self.count = answers.names, len(answers)
        if answers.first is not None:
            self.found = answers.first
        return self._outcome(bool(answers), text)

    def _outcome(self, holds: bool, text: str) -> Outcome:
        self.feedback_message = "" if holds else f"no answer to '{text}'"
        return SUCCESS if holds else FAILURE
