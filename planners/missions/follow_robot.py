"""Follow another robot at a safe distance, for as long as it can be found.

The leader is a robot that the robot sensor sees; it needs nothing else of it. The mission never succeeds: it ends with
the episode, or fails with LOST_LEADER when its leader is nowhere to be seen.
"""

from py_trees.behaviour import Behaviour

from rocs_bt.plan import Mission
from rocs_bt.units import PositiveMetres, PositiveMetresPerSecond


def build(
    mission: Mission,
    *,
    leader: str,
    distance: PositiveMetres = 1.2,
    room: PositiveMetres = 1.0,
    safety: PositiveMetres = 0.8,
    cruise: PositiveMetresPerSecond = 0.6,
) -> Behaviour:
    """One leaf: FollowRobot. Who follows comes no nearer to a goal, so no number of reflexes means that it is stuck."""
    return mission.act(
        "FollowRobot",
        leader=leader,
        distance=distance,
        room=room,
        safety=safety,
        cruise=cruise,
        max_preemptions=1_000_000,
    )
