"""Known: condition on the existence and age of a node in the robot's Knowledge."""

from collections.abc import Iterator
from math import inf
from typing import Annotated

from rocs_bt import Fault
from rocs_bt.base.errors import unknown
from rocs_bt.base.units import TimeLimit
from rocs_bt.plan import mission_of
from rocs_bt.trees.nodes import FAILURE, SUCCESS, Instant, Outcome


class Known(Instant):
    """SUCCESS if a node of the knowledge graph exists, has the attribute, and is recent enough; else FAILURE.

    <Known node="dock" attribute="pose"/>
    <Known node="R2" attribute="pose" max_age="2 s"/>
    """

    kind = "Condition"
    node: Annotated[str, "name of the node"]
    attribute: Annotated[str, "attribute that must have a value; none if empty"] = ""
    max_age: Annotated[TimeLimit, "maximum age of the value [s]"] = inf

    def bound_faults(self) -> Iterator[tuple[str, Fault]]:
        if self.key("attribute") is not None or not self.attribute:
            return
        kinds = mission_of(self).knowledge.graph.schema.kinds.values()
        names = sorted({name for kind in kinds for name in kind.attributes})
        if self.attribute not in names:
            yield "attribute", unknown("attribute", self.attribute, names, "Knowledge")

    def update(self) -> Outcome:
        self.feedback_message = self._missing()
        return FAILURE if self.feedback_message else SUCCESS

    def _missing(self) -> str:
        """Reason why the node is not known; empty if it is."""
        mission, node, attribute = mission_of(self), self.node, self.attribute
        graph = mission.knowledge.graph
        if not graph.has(node):
            return f"no node named '{node}' is known"
        if attribute and graph.attributes(node).get(attribute) is None:
            return f"the {attribute} of '{node}' is not known"
        age = mission.clock.now() - graph.stamp(node, attribute or None).t
        return f"'{node}' is {age:.1f} s old" if age > self.max_age else ""
