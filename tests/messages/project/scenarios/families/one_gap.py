"""A wall with one gap, somewhere."""

from rocs_bt import Pose2
from rocs_bt.base.units import PositiveMetres
from rocs_bt.compare import Block, Family, Floor, Scene, goal_scenario


class OneGap(Family):
    """A wall with one gap, somewhere."""

    gap: PositiveMetres = 1.0

    def scene(self, index: int) -> Scene:
        """A scene."""
        at = float(self.rng(index).uniform(-2.0, 2.0))
        ground = Floor((-4.0, -4.0), (4.0, 4.0))
        for name, low, high in (("left", -4.0, at - self.gap / 2.0), ("right", at + self.gap / 2.0, 4.0)):
            ground.obstacles.append(Block(name, (low + high) / 2.0, 0.0, high - low, 0.1))
        name, doc = self.scene_name(index), "Through a gap in a wall."
        scenario = goal_scenario(self, name, doc, Pose2(0.0, -3.0, 1.57), (0.0, 3.0), tolerance=0.3, duration=60.0)
        return Scene(scenario, ground)
