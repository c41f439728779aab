"""Wait until the robot's Knowledge changes."""

from collections import deque
from collections.abc import Iterator

from rocs_bt.errors import Fault, unknown
from rocs_bt.plan import mission_of
from rocs_bt.trees.nodes import RUNNING, SUCCESS, Input, Leaf, Outcome, Output


class WaitForChange(Leaf):
    """RUNNING until the knowledge graph changes in a way that fits all that is given, then SUCCESS.

        <WaitForChange kind="goal" subject="{found}"/>
        <WaitForChange node="R2" attribute="pose"/>

    What changed before it began does not count.
    """

    kind_ = Input(str, "", "the kind of the node that changes; any where empty", name="kind")
    node = Input(str, "", "the node that changes; any where empty")
    attribute = Input(str, "", "the attribute that changes; anything where empty")
    relation = Input(str, "", "the relation that is drawn, changed or taken away; anything where empty")
    subject = Output(str, "the node that changed; of a relation, its source")

    def __init__(self, name: str = "", /, **attributes):
        super().__init__(name, **attributes)
        self._heard = deque()
        self._subscription = None

    def bound_faults(self) -> Iterator[tuple[str, Fault]]:
        schema = mission_of(self).knowledge.graph.schema
        for port, what, known in (("kind", "kind", schema.kinds), ("relation", "relation", schema.relations)):
            if self.key(port) is None and (name := self.read(port)) and name not in known:
                yield port, unknown(what, name, known, "Knowledge")

    def initialise(self) -> None:
        self._heard.clear()
        graph = mission_of(self).knowledge.graph
        self._subscription = graph.subscribe(
            self._heard.append, kind=self.kind_ or None, node=self.node or None, relation=self.relation or None
        )

    def update(self) -> Outcome:
        wanted = self.attribute
        while self._heard:
            change = self._heard.popleft()
            if not wanted or (change.what == "attribute" and change.name == wanted):
                self.subject = change.subject
                self.feedback_message = f"{change.what}: {change.subject} {change.name}"
                return SUCCESS
        return RUNNING

    def terminate(self, new_status) -> None:
        if self._subscription is not None:
            self._subscription.close()
            self._subscription = None
