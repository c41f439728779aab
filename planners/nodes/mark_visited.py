"""MarkVisited: note in Knowledge that the robot was at a place."""

from typing import Annotated

from rocs_bt.plan import mission_of
from rocs_bt.trees.nodes import FAILURE, SUCCESS, Instant, Outcome


class MarkVisited(Instant):
    """Sets the attribute `visited` of a place or goal to the present time; FAILURE if there is no such node.

    <Ask query="goal where not known(visited) order by distance(goal) limit 1" found="{next}"/>
    <MarkVisited place="{next}"/>
    """

    place: Annotated[str, "place or goal that was visited"]

    def update(self) -> Outcome:
        mission, place = mission_of(self), self.place
        graph = mission.knowledge.graph
        if not graph.has(place) or "visited" not in graph.schema.kinds[graph.kind(place)].attributes:
            self.feedback_message = f"'{place}' is no known place or goal"
            return FAILURE
        graph.set(place, visited=mission.clock.now())
        self.feedback_message = ""
        return SUCCESS
