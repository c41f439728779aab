"""Visit four corners in order, replanning at each.

The corners are goals of the world model, which the scenario places. Each leg is planned when the previous one has
ended, from the robot's current position; reflexes on the way do not reset the progress.
"""

from py_trees.behaviour import Behaviour
from py_trees.composites import Sequence

from rocs_bt import PositiveMetresPerSecond
from rocs_bt.plan import Mission


def build(
    mission: Mission,
    *,
    first: str = "corner_1",
    second: str = "corner_2",
    third: str = "corner_3",
    fourth: str = "corner_4",
    cruise: PositiveMetresPerSecond = 0.4,
) -> Behaviour:
    """Build a sequence of four GoTo leaves, one for each corner."""
    legs = [mission.act("GoTo", goal=goal, cruise=cruise) for goal in (first, second, third, fourth)]
    return Sequence("corners", memory=True, children=legs)
