"""A bench on which nodes are ticked, with leaves that do as they are told."""

from __future__ import annotations

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.trees.nodes import BUILTIN, Leaf, Tree
from rocs_bt.trees.status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, outcome_name

OUTCOMES = {"S": SUCCESS, "F": FAILURE, "R": RUNNING, "K": SKIPPED}


class Scripted(Leaf):
    """Comes to one letter after the other, the last one for ever, and writes down what was asked of it."""

    def __init__(self, name, letters, log, **attributes):
        super().__init__(name, **attributes)
        self.letters, self.log, self.calls, self.word = letters, log, 0, ""

    def initialise(self):
        self.word = "start"

    def update(self):
        letter = self.letters[min(self.calls, len(self.letters) - 1)]
        self.calls += 1
        self.log.append(f"{self.name}.{self.word}={letter}")
        self.word = "run"
        return OUTCOMES[letter]

    def terminate(self, new_status):
        if new_status is IDLE:
            self.log.append(f"{self.name}.halt")


class Bench:
    """A tree, its leaves' log, and its clock."""

    def __init__(self):
        self.log = []
        self.clock = SimulatedClock(0.1)

    def leaf(self, name, letters, **attributes):
        return Scripted(name, letters, self.log, **attributes)

    def node(self, tag, *children, **attributes):
        made = [c if not isinstance(c, str) else self.leaf(chr(65 + i), c) for i, c in enumerate(children)]
        return BUILTIN.make(tag, tag, made, {k.rstrip("_"): v for k, v in attributes.items()})

    def tree(self, root, **board):
        self.built = Tree(root, clock=self.clock)
        self.built.board.update(board)
        return self

    def ticks(self, count=1):
        """What happens tick after tick, such as `RUNNING A.start=S B.start=R`."""
        return [self.tick() for _ in range(count)]

    def tick(self):
        self.log.clear()
        outcome = self.built.tick()
        self.clock.advance()
        return " ".join([outcome_name(outcome), *self.log])

    def of(self, tag, *children, **attributes):
        return self.tree(self.node(tag, *children, **attributes))
