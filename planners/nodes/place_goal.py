"""Put a goal somewhere, for whoever drives there next."""

from math import nan

from rocs_bt.action import Failure, Reason
from rocs_bt.errors import KnowledgeError
from rocs_bt.geometry import Pose2
from rocs_bt.plan import mission_of
from rocs_bt.trees.nodes import FAILURE, SUCCESS, Input, Instant, Outcome
from rocs_bt.units import ANGLE, LENGTH


class PlaceGoal(Instant):
    """Puts a goal into the world model, or moves it: at x, y and yaw, or so far from something that is known.

        <PlaceGoal goal="here" at="R1"/>
        <PlaceGoal goal="beside" at="shelf" y="0.8 m" yaw="90 deg"/>
        <PlaceGoal goal="corner" x="3 m" y="-1 m"/>

    FAILURE if nobody knows where `at` is, or the name is that of something that is no goal.
    """

    goal = Input(str, doc="the goal's name")
    at = Input(str, "", "what x, y and yaw are counted from; the world frame where empty")
    x = Input(float, 0.0, "to the east, or ahead of `at` [m]", dimension=LENGTH)
    y = Input(float, 0.0, "to the north, or to the left of `at` [m]", dimension=LENGTH)
    yaw = Input(float, 0.0, "how the robot stands there [rad]", dimension=ANGLE)
    tolerance = Input(float, nan, "how near counts as reached [m]", dimension=LENGTH)

    def update(self) -> Outcome:
        world, at = mission_of(self).knowledge.world, self.at
        origin = world.pose_of(at) if at else Pose2(0.0, 0.0, 0.0)
        if origin is None:
            self.feedback_message = str(Failure(Reason.NO_GOAL, f"nobody knows where '{at}' is"))
            return FAILURE
        tolerance = self.tolerance
        more = {"tolerance": tolerance} if tolerance == tolerance else {}
        try:
            world.place(self.goal, origin.compose(Pose2(self.x, self.y, self.yaw)), kind="goal", **more)
        except KnowledgeError as error:
            self.feedback_message = str(Failure(Reason.CANNOT, str(error)))
            return FAILURE
        self.feedback_message = ""
        return SUCCESS
