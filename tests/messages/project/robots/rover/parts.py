"""Parts of the rover."""

from rocs_bt import Analyze, Monitor, Signal
from rocs_bt.base.units import LENGTH, Metres, PositiveMetres
from rocs_bt.devices.mujoco import MujocoSensor


class Thermometer(MujocoSensor):
    """Constant warmth."""

    reach: PositiveMetres
    steps: int = 2
    at: tuple[Metres, ...] = ()

    def set_up(self):
        self.warmth = 0.5

    def sample(self):
        return [self.warmth]


class Warmth(Monitor):
    """Warmth."""

    def signals(self):
        return [Signal("temperature", 1, (LENGTH,), (0.0, 9.0), self.max_age)]

    def interpret(self, readings):
        return {"temperature": readings["thermometer"].values}


class Heat(Analyze):
    """Compare with a limit."""

    limit: Metres = 1.0

    def process(self, t):
        pass
