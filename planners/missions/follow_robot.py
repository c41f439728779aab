"""Follow another robot at a safe distance, for as long as it can be found.

The leader is a robot that the robot sensor sees; it needs nothing else of it. The mission succeeds when the leader has
stood for `rest`, which it never does by default, and fails with LOST_LEADER when its leader is nowhere to be seen.

Its band is `distance` +- (`distance` - `safety`), between the centres of the two bases: it makes room below `room`, and
nearer than `safety` it stands, whatever it does.
"""

from math import inf
from typing import Annotated

from py_trees.behaviour import Behaviour

from rocs_bt.plan import Mission
from rocs_bt.units import Bounds, PositiveMetres, PositiveMetresPerSecond, Seconds


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
    """One leaf: FollowRobot. Who follows comes no nearer to a goal, so no number of reflexes means that it is stuck."""
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
