"""Go to the origin of the world frame, with the paper's own macro-actions (Table 2).

GoToOrigin = TurnToPosition; SetWheelSpeed. No follower: the robot turns toward the origin, drives straight, and turns
again when it has drifted off the line.
"""

from py_trees.behaviour import Behaviour

from rocs_bt.plan import Mission
from rocs_bt.units import PositiveMetresPerSecond


def build(mission: Mission, *, speed: PositiveMetresPerSecond = 0.3) -> Behaviour:
    """One leaf: GoToOrigin."""
    return mission.act("GoToOrigin", speed=speed)
