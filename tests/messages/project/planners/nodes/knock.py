"""A node."""

from rocs_bt.base.units import Seconds
from rocs_bt.trees.nodes import SUCCESS, Instant, Output


class Knock(Instant):
    """Knock."""

    times: int
    rest: Seconds = 1.0
    loud: bool = False
    heard: Output[str]

    def update(self):
        return SUCCESS
