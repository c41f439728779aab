"""What the tests with py_trees make nodes of."""

from rocs_bt.trees.nodes import BUILTIN, Leaf
from rocs_bt.trees.status import FAILURE, RUNNING, SUCCESS


def node(tag, *children, name="", **attributes):
    return BUILTIN.make(tag, name or tag, list(children), attributes)


class Letters(Leaf):
    def __init__(self, name, letters):
        super().__init__(name)
        self.letters, self.calls = letters, 0

    def update(self):
        self.calls += 1
        return {"S": SUCCESS, "F": FAILURE, "R": RUNNING}[self.letters[(self.calls - 1) % len(self.letters)]]
