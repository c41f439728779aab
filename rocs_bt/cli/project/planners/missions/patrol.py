"""Visit two places in order and wait at each.

The scenario defines the places. The reflex rules avoid obstacles.
"""

import py_trees
from py_trees.behaviour import Behaviour

from rocs_bt.plan import Mission
from rocs_bt.units import PositiveMetresPerSecond, Seconds


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
        tree.add_child(mission.act("GoTo", goal=place, cruise=cruise))
        tree.add_child(mission.wait(rest))
    return tree
