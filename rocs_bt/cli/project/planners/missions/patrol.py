"""Visit two places in order and wait at each.

The scenario defines the places. The shipped mission `navigate` drives to each of them: it plans a path in the map that
the robot builds from its scans, and plans again as the map grows.
"""

import py_trees
from py_trees.behaviour import Behaviour

from rocs_bt import PositiveMetresPerSecond, Seconds
from rocs_bt.plan import Mission


def build(
    mission: Mission,
    *,
    first: str = "gate",
    second: str = "dock",
    cruise: PositiveMetresPerSecond = 0.4,
    rest: Seconds = 1.0,
) -> Behaviour:
    """Sequence: drive to each place and wait there."""
    tree = py_trees.composites.Sequence("patrol", memory=True)
    for place in (first, second):
        tree.add_child(mission.tree("navigate", goal=place, cruise=cruise))
        tree.add_child(mission.wait(rest))
    return tree
