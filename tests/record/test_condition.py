"""What keeps a condition from being true: with just that changed it is true, whatever the language can say."""

import math
import random
from dataclasses import replace

import numpy as np
import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.expression import TRUTH, Expression, Kind, Node, parse
from rocs_bt.record.explanation.condition import Condition, parts_of

from ..reactive.random_rules import ENVIRONMENT, SIZE, Writer

STEPS = [0.05, 0.05, 0.05, 0.02, 0.2, 1.0]
VALUES = [0.0, 0.1, 0.3, 0.5, 0.7, 1.0, 2.0, -0.5]
NUMBER = Node("number", Kind(), value=0.5)


def condition(draw, depth):
    while True:
        try:
            return parse(Writer(draw).truth(depth), ENVIRONMENT)
        except InputError as error:
            assert any(limit in str(error) for limit in ("deep", "operations", "characters"))


def trace(draw, count=10):
    """Times and samples, each often much like the one before, some with values that are not known."""
    row, t, times, rows = [draw.choice(VALUES) for _ in range(SIZE)], 1.0, [], []
    for _ in range(count):
        if draw.random() < 0.5:
            row = [draw.choice(VALUES) for _ in range(SIZE)]
        row = row.copy()
        row[draw.randrange(SIZE)] = draw.choice([*VALUES, math.nan, math.inf, draw.uniform(-2, 3)])
        t += draw.choice(STEPS)
        times.append(t)
        rows.append(row)
    return times, np.array(rows)


class Twin:
    """A condition whose parts are read from a snapshot of truths; what is true after a time can be forced.

    Attributes:
        slots: Index in the snapshot and number of values of each part.
    """

    def __init__(self, node):
        self.slots, self.size = [], 0
        self.call = Expression(self.of(node))

    def read(self, kind, wide=0):
        start, self.size = self.size, self.size + max(1, wide)
        self.slots.append((start, max(1, wide), kind))
        read = Node("read", Kind(size=wide), start=start, stop=self.size)
        return Node("compare", replace(TRUTH, size=wide), (read, NUMBER), signs=(">",))

    def of(self, node):
        if node.op == "compare":
            return Node("and", TRUTH, tuple(self.read("is") for _ in node.pairs))
        if node.op in ("any", "all") and node.args[0].op == "compare" and node.args[0].kind.size:
            return self.group(node)
        if node.op == "truth" or (next(parts_of(node), None) is node and node.op not in ("held", "once")):
            return node if node.op == "truth" else self.read("is")
        inner = replace(node, args=tuple(map(self.of, node.args)))
        if node.op == "held":
            return Node("or", TRUTH, (inner, self.read("force")))
        if node.op == "once":
            return Node("and", TRUTH, (inner, Node("not", TRUTH, (self.read("force"),))))
        return inner

    def group(self, node):
        """A chain over a group: all pairs of a value, of any or of all values."""
        wide, pairs = node.args[0].kind.size, [self.read("is", node.args[0].kind.size) for _ in node.args[0].pairs]
        each = [[self.item(pair, k) for pair in pairs] for k in range(wide)]
        values = tuple(Node("and", TRUTH, tuple(one)) for one in each)
        return Node("or" if node.op == "any" else "and", TRUTH, values)

    @staticmethod
    def item(pair, k):
        read = pair.args[0]
        return Node(
            "compare",
            TRUTH,
            (Node("read", Kind(), start=read.start + k, stop=read.start + k + 1), NUMBER),
            signs=(">",),
        )


def truths(parts, slots, t, rows):
    """Snapshots of a twin: what each part really is; nothing is forced."""
    calls = [None if kind == "force" else elements(part) for part, (_, _, kind) in zip(parts, slots, strict=True)]
    found = []
    for when, row in zip(t, rows.tolist(), strict=True):
        snapshot = []
        for call in calls:
            snapshot += (
                [0.0] if call is None else [math.nan if (v := one(row, when)) is None else float(v) for one in call]
            )
        found.append(snapshot)
    return found


def elements(part):
    """Compiled truth of each value of a part."""
    if not part.kind.size:
        return [Expression(part)]
    return [
        Expression(Node("any", TRUTH, (replace(part, kind=TRUTH, args=tuple(one(arg, k) for arg in part.args)),)))
        for k in range(part.kind.size)
    ]


def one(node, k):
    """One value of a side of a comparison."""
    if not node.kind.size:
        return node
    if node.op == "read":
        return replace(node, kind=Kind(node.kind.dimension), start=node.start + k, stop=node.start + k + 1)
    if node.op == "vector":
        return node.args[k]
    return replace(node, kind=replace(node.kind, size=0), args=tuple(one(arg, k) for arg in node.args))


def explained(seed):
    """Samples of a random condition that were not true, all of whose needed parts are changed then."""
    draw = random.Random(seed)
    node = condition(draw, draw.choice([1, 2, 2, 3]))
    t, x = trace(draw)
    made, real = Condition(node), Expression(node)
    if not made.parts:
        return 0
    found = made(t, x)
    truth = [real(row, when) for row, when in zip(x.tolist(), t, strict=True)]
    assert [None if math.isnan(v) else bool(v) for v in found.truth] == truth
    assert ((found.near == 1.0) == (found.truth == 1.0)).all()
    twin, seen = Twin(node), 0
    snapshots = truths(made.parts, twin.slots, t, x)
    for i, is_true in enumerate(truth):
        needs = found.needs[i]
        if is_true:
            assert not needs.any(), node.text
            continue
        if not needs.any():
            assert {part.op for part in node.walk()} & {"truth"}, (node.text, "nothing is named")
            continue
        changed = [made_true(snapshots[i], twin.slots, needs, without) for without in (None, *np.flatnonzero(needs))]
        outcomes = [after(Twin(node).call, snapshots[:i], t, snapshot) for snapshot in changed]
        assert outcomes[0] is True, (node.text, x[i], [part.text for part in made.parts], needs)
        # Of a chain over a group each value may need another part, and what is true after a time is forced alone.
        chained = any(part.kind.size and len(part.signs) > 1 for part in node.walk())
        assert node.temporal or chained or True not in outcomes[1:], (node.text, x[i], needs)
        for row, need in zip((row[i] for row in found.rows), needs, strict=True):
            assert not need or row[2] != (need > 0), node.text  # what is shown has to change
        seen += 1
    return seen


def made_true(snapshot, slots, needs, without):
    changed = snapshot.copy()
    for k, ((start, size, kind), need) in enumerate(zip(slots, needs, strict=True)):
        if need and k != without:
            changed[start : start + size] = [1.0 if kind == "force" else float(need > 0)] * size
    return changed


def after(call, before, t, snapshot):
    for row, when in zip(before, t, strict=False):
        call(row, when)
    return call(snapshot, t[len(before)])


@pytest.mark.parametrize("block", range(4))
def test_what_is_named_is_what_makes_it_true_and_nothing_less_does(block):
    assert sum(explained(seed) for seed in range(25 * block, 25 * block + 25)) > 20


@pytest.mark.soak
@pytest.mark.parametrize("block", range(20))
def test_what_is_named_is_what_makes_it_true_for_many(block):
    assert sum(explained(seed) for seed in range(1000 + 100 * block, 1100 + 100 * block)) > 50


def test_piece_by_piece_a_condition_is_the_same_as_at_once():
    for seed in range(30):
        draw = random.Random(seed)
        node = condition(draw, 2)
        t, x = trace(draw, 12)
        whole, piece = Condition(node)(t, x), Condition(node)
        parts = [piece(t[i : i + 5], x[i : i + 5]) for i in range(0, 12, 5)]
        for name in ("truth", "near", "needs"):
            got = np.concatenate([getattr(part, name) for part in parts])
            assert np.array_equal(getattr(whole, name), got, equal_nan=True), node.text
        for k, rows in enumerate(whole.rows):
            assert np.array_equal(rows, np.concatenate([part.rows[k] for part in parts]), equal_nan=True), node.text
