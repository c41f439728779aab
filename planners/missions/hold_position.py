"""Go to a place and stay there: give way to what comes near, and come back. It never ends.

The reflexes decide what is near, and where to. The goal is pursued on the way only: a robot that has arrived wants to
be nowhere nearer, so that nothing keeps the reflexes from pushing it off. A robot that sees to one side only should
face where others come from. Run it with `--for`, in a scenario whose success is `at = "end"`.
"""

from math import isnan, nan

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Sequence
from py_trees.decorators import Repeat

from rocs_bt.plan import Mission
from rocs_bt.units import Metres, PositiveMetresPerSecond, Radians


class Stay(Behaviour):
    """RUNNING while the robot is where it should be, or nobody knows; SUCCESS once it was pushed off."""

    def __init__(self, mission: Mission, goal: str, tolerance: float) -> None:
        super().__init__(f"Stay {goal}")
        self._knowledge = mission.knowledge
        self._goal = goal
        self._tolerance = tolerance

    def update(self) -> Status:
        goal, pose = self._knowledge.world.pose_of(self._goal), self._knowledge.robot.pose()
        if goal is None or isnan(pose.x) or pose.distance(goal) <= self._tolerance:
            return Status.RUNNING
        self.feedback_message = f"pushed off by {pose.distance(goal):.2f} m"
        return Status.SUCCESS


def build(
    mission: Mission,
    *,
    goal: str = "goal",
    cruise: PositiveMetresPerSecond = 0.5,
    facing: Radians = nan,
    tolerance: Metres = 0.1,
) -> Behaviour:
    """Over and over: GoTo, TurnTo where `facing` is given, then Stay until pushed off by more than the tolerance."""
    steps: list[Behaviour] = [mission.act("GoTo", goal=goal, cruise=cruise)]
    if not isnan(facing):
        steps.append(mission.act("TurnTo", yaw=facing))
    steps.append(Stay(mission, goal, tolerance))
    return Repeat("for ever", child=Sequence("hold", memory=True, children=steps), num_success=-1)
