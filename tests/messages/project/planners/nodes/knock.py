"""A node."""

from rocs_bt.trees.nodes import SUCCESS, Input, Instant


class Knock(Instant):
    """Knock."""

    times = Input(int)

    def update(self):
        return SUCCESS
