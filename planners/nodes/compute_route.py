"""ComputeRoute: compute a path around known obstacles with a planner of planners/routes."""

from collections.abc import Iterator
from itertools import pairwise
from math import dist, isnan
from typing import Annotated

from rocs_bt import Failure, Fault, InputError, Reason
from rocs_bt.base.units import Metres
from rocs_bt.plan import MapRoutePlanner, NoRoute, mission_of
from rocs_bt.trees.nodes import FAILURE, SUCCESS, Instant, Outcome, Output


class ComputeRoute(Instant):
    """Computes a path from the robot to a goal with a route planner; FAILURE with the reason if there is none.

    <ComputeRoute goal="dock" planner="visibility" path="{way}"/>
    <FollowPath points="{way}"/>

    The planner object is kept between ticks and may reuse its last path. As long as it returns the same path, the
    output `path` is the same list.
    """

    goal: Annotated[str, "node of the world model with a pose"]
    planner: Annotated[str, "name of a file in planners/routes"]
    clearance: Annotated[Metres, "minimum gap between the hull and known obstacles [m]"] = 0.1
    moving: Annotated[bool, "whether the path leads around what moves at present; FollowRoute avoids it itself"] = True
    path: Annotated[Output[list], "corners of the path, (x, y) in the world frame [m], from the robot on"]
    length: Annotated[Output[float], "length of the path [m]"]

    def __init__(self, name="", /, **attributes):
        super().__init__(name, **attributes)
        self._named = self._router = self._found = None

    def bound_faults(self) -> Iterator[tuple[str, Fault]]:
        if self.key("planner") is None:
            try:
                mission_of(self).content.load_route(self.planner)
            except InputError as error:
                yield from (("planner", fault) for fault in error.faults)

    def update(self) -> Outcome:
        mission = mission_of(self)
        knowledge, name = mission.knowledge, self.goal
        start, goal = knowledge.robot.pose(mission.clock.now()), knowledge.world.pose_of(name)
        if goal is None:
            return self._fail(Reason.NO_GOAL, f"the position of '{name}' is unknown")
        if isnan(start.x):
            return self._fail(Reason.LOST_POSE)
        if self._named != (named := self.planner):
            self._named, self._router = named, mission.content.load_route(named)(knowledge)
        if isinstance(self._router, MapRoutePlanner):
            self._router.moving = self.moving
        try:
            found = self._router.route(start, goal, self.clearance)
        except NoRoute as error:
            self._found = None
            return self._fail(Reason.BLOCKED, str(error))
        if found is not self._found:
            self._found, path = found, [(x, y) for x, y in found]
            self.path, self.length = path, sum(dist(a, b) for a, b in pairwise(path))
            self.feedback_message = f"{len(path) - 1} legs to '{name}'"
        return SUCCESS

    def _fail(self, reason: Reason, evidence: str = "") -> Outcome:
        self.feedback_message = str(Failure(reason, evidence))
        return FAILURE
