"""Follow another robot at a safe distance, for as long as it can be found.

The leader is observed by the robot sensor only. The mission succeeds when the leader has been stationary for `rest`,
which never happens by default, and fails with LOST_LEADER when the leader cannot be found.

Distances are measured between the centres of the two bases. The robot keeps the distance to its leader within
`distance` +- (`distance` - `safety`). Below `room` the robot backs off; below `safety` it stops.
"""

from math import inf
from typing import Annotated

from py_trees.behaviour import Behaviour

from rocs_bt import PositiveMetres, PositiveMetresPerSecond, Seconds
from rocs_bt.base.units import Bounds
from rocs_bt.plan import Mission


def build(
    mission: Mission,
    *,
    leader: str,
    distance: PositiveMetres = 1.2,
    room: PositiveMetres = 1.0,
    safety: PositiveMetres = 0.8,
    cruise: PositiveMetresPerSecond = 0.6,
    rest: Annotated[Seconds, Bounds(0.0, above=True, infinite=True)] = inf,
) -> Behaviour:
    """Build one leaf: FollowRobot.

    A follower approaches no goal, so repeated reflexes do not mean that it is stuck; pre-emptions are not limited.
    """
    return mission.act(
        "FollowRobot",
        leader=leader,
        distance=distance,
        room=room,
        safety=safety,
        cruise=cruise,
        rest=rest,
        max_preemptions=1_000_000,
    )
