"""Go to the origin of the world frame with the paper's macro-action GoToOrigin (Table 2).

GoToOrigin is the sequence TurnToPosition; SetWheelSpeed, without path following: the robot turns toward the origin,
drives straight, and turns again when it has drifted off the line.
"""

from py_trees.behaviour import Behaviour

from rocs_bt import PositiveMetresPerSecond
from rocs_bt.plan import Mission


def build(mission: Mission, *, speed: PositiveMetresPerSecond = 0.3) -> Behaviour:
    """Build one leaf: GoToOrigin."""
    return mission.act("GoToOrigin", speed=speed)
