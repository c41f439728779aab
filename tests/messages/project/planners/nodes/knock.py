"""A node."""

from rocs_bt.base.units import TIME
from rocs_bt.trees.nodes import SUCCESS, Input, Instant, Output


class Knock(Instant):
    """Knock."""

    times = Input(int)
    rest = Input(float, 1.0, "pause after each [s]", dimension=TIME)
    loud = Input(bool, False)
    heard = Output(str)

    def update(self):
        return SUCCESS
