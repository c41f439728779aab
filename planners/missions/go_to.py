"""Go to one goal and stand there.

The goal is a node of the world model, which the scenario places. The robot drives straight at it with the follower;
what stands in the way is the reflexes' matter, and after each of them the mission plans anew from where the robot is.
"""

from py_trees.behaviour import Behaviour

from rocs_bt.plan import Mission
from rocs_bt.units import PositiveMetresPerSecond


def build(mission: Mission, *, goal: str = "goal", cruise: PositiveMetresPerSecond = 0.5) -> Behaviour:
    """One leaf: GoTo."""
    return mission.act("GoTo", goal=goal, cruise=cruise)
