"""A planner in Python."""

from dataclasses import dataclass

from rocs_bt.base.units import PositiveMetresPerSecond


@dataclass(kw_only=True)
class Pilot:
    """Drive straight on."""

    speed: PositiveMetresPerSecond = 0.5

    def reset(self, task, rng):
        """Nothing to keep."""

    def act(self, observation):
        """Both wheels alike."""
        return self.speed, self.speed
