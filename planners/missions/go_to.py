"""Go to one goal; with `hold`, stay there and return whenever reflexes have moved the robot away.

The goal is a node of the world model, which the scenario places. The action GoTo drives straight to the goal; obstacles
are handled only by reflexes. After each reflex the mission replans from the current position. A mission with `hold`
never ends: run it with `--for`, in a scenario with the success `at = "end"`. The goal is marked as pursued only while
the robot drives to it. Reflexes may therefore move a robot that has arrived away from the goal.
"""

from math import isnan, nan

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Sequence
from py_trees.decorators import Repeat

from rocs_bt import Metres, PositiveMetresPerSecond, Radians
from rocs_bt.plan import Mission


class Stay(Behaviour):
    """RUNNING while the robot is at its goal or its pose is unknown; SUCCESS once the robot has been displaced."""

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
    hold: bool = False,
    tolerance: Metres = 0.1,
) -> Behaviour:
    """Build the tree: GoTo, then TurnTo if `facing` is given; with `hold`, repeated when the robot was displaced.

    Args:
        mission: Context of the mission.
        goal: Node of the world model.
        cruise: Speed on straight parts [m/s].
        facing: Final yaw, world frame [rad]; NaN for any.
        hold: Whether the robot remains at the goal and returns to it after a displacement.
        tolerance: Displacement after which the robot returns [m].
    """
    steps: list[Behaviour] = [mission.act("GoTo", goal=goal, cruise=cruise)]
    if not isnan(facing):
        steps.append(mission.act("TurnTo", yaw=facing))
    if hold:
        steps.append(Stay(mission, goal, tolerance))
    way = steps[0] if len(steps) == 1 else Sequence("go to", memory=True, children=steps)
    return Repeat("for ever", child=way, num_success=-1) if hold else way
