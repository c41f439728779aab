"""PlaceGoal: set the pose of a goal in the world model."""

from typing import Annotated

from rocs_bt import Failure, KnowledgeError, Pose2, Reason
from rocs_bt.base.units import Metres, Radians
from rocs_bt.plan import mission_of
from rocs_bt.trees.nodes import FAILURE, SUCCESS, Instant, Outcome


class PlaceGoal(Instant):
    """Creates or moves a goal in the world model, at x, y and yaw in the world frame or relative to a known node.

        <PlaceGoal goal="here" at="R1"/>
        <PlaceGoal goal="beside" at="shelf" y="0.8 m" yaw="90 deg"/>
        <PlaceGoal goal="corner" x="3 m" y="-1 m"/>

    FAILURE if the pose of `at` is unknown, or the name belongs to a node that is not a goal.
    """

    goal: Annotated[str, "name of the goal"]
    at: Annotated[str, "node that x, y and yaw are relative to; the world frame if empty"] = ""
    x: Annotated[Metres, "distance east, or ahead of `at` [m]"] = 0.0
    y: Annotated[Metres, "distance north, or left of `at` [m]"] = 0.0
    yaw: Annotated[Radians, "yaw of the goal [rad]"] = 0.0
    tolerance: Annotated[Metres, "distance at which it is reached, 0 for that of `at` [m]"] = 0.0

    def update(self) -> Outcome:
        world, at = mission_of(self).knowledge.world, self.at
        origin = world.pose_of(at) if at else Pose2(0.0, 0.0, 0.0)
        if origin is None:
            self.feedback_message = str(Failure(Reason.NO_GOAL, f"the position of '{at}' is unknown"))
            return FAILURE
        tolerance = self.tolerance
        if not tolerance and at:
            tolerance = world.graph.attributes(at).get("tolerance") or 0.0
        more = {"tolerance": tolerance} if tolerance else {}
        try:
            world.place(self.goal, origin.compose(Pose2(self.x, self.y, self.yaw)), kind="goal", **more)
        except KnowledgeError as error:
            self.feedback_message = str(Failure(Reason.CANNOT, str(error)))
            return FAILURE
        return SUCCESS
