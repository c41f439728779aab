"""WaitForChange: wait until the robot's Knowledge changes."""

from collections import deque
from collections.abc import Iterator
from typing import Annotated

from rocs_bt import Fault
from rocs_bt.base.errors import unknown
from rocs_bt.plan import mission_of
from rocs_bt.trees.nodes import RUNNING, SUCCESS, Leaf, Outcome, Output


class WaitForChange(Leaf):
    """RUNNING until a change of the knowledge graph matches all given ports, then SUCCESS.

        <WaitForChange kind="goal" subject="{found}"/>
        <WaitForChange node="R2" attribute="pose"/>

    Changes before the node began are ignored.
    """

    kind_: Annotated[str, "kind of the changed node; any if empty"] = ""
    node: Annotated[str, "changed node; any if empty"] = ""
    attribute: Annotated[str, "changed attribute; any change if empty"] = ""
    relation: Annotated[str, "added, changed or removed relation; any change if empty"] = ""
    subject: Annotated[Output[str], "name of the changed node; of a relation, its source"]

    def __init__(self, name: str = "", /, **attributes):
        super().__init__(name, **attributes)
        self._changes = deque()
        self._subscription = None

    def bound_faults(self) -> Iterator[tuple[str, Fault]]:
        schema = mission_of(self).knowledge.graph.schema
        for port, what, known in (("kind", "kind", schema.kinds), ("relation", "relation", schema.relations)):
            if self.key(port) is None and (name := self.read(port)) and name not in known:
                yield port, unknown(what, name, known, "Knowledge")

    def initialise(self) -> None:
        self._changes.clear()
        graph = mission_of(self).knowledge.graph
        self._subscription = graph.subscribe(
            self._changes.append, kind=self.kind_ or None, node=self.node or None, relation=self.relation or None
        )

    def update(self) -> Outcome:
        wanted = self.attribute
        while self._changes:
            change = self._changes.popleft()
            if not wanted or (change.what == "attribute" and change.name == wanted):
                self.subject = change.subject
                self.feedback_message = f"{change.what}: {change.subject} {change.name}"
                return SUCCESS
        return RUNNING

    def wait_text(self) -> str:
        wanted = [f"{port} {value}" for port in ("kind", "node", "attribute", "relation") if (value := self.read(port))]
        return f"for a change of {', '.join(wanted) or 'Knowledge'}"

    def terminate(self, new_status) -> None:
        if self._subscription is not None:
            self._subscription.close()
            self._subscription = None
