"""Our nodes are py_trees' own to all its tools: composites, idioms, visitors, displays, editing; and the way round.

After the ideas of py_trees' own tests (tests/test_tree.py, test_visitors.py, test_display.py, test_either_or.py).
"""

from __future__ import annotations

import random

import py_trees
import pytest
from py_trees.behaviours import Failure, Periodic, Running, StatusQueue, Success
from py_trees.common import Status

from rocs_bt.trees.nodes import Changes, Control, Instant, Leaf, Tree
from rocs_bt.trees.status import FAILURE, RUNNING, SUCCESS, outcome_name

from .with_py_trees import Letters, node

S, F, R = Status.SUCCESS, Status.FAILURE, Status.RUNNING


def queue(*statuses, name="q"):
    return StatusQueue(name, queue=list(statuses), eventually=statuses[-1])


class TestDisplays:
    def test_symbols_statuses_and_names_are_shown(self):
        root = node("Sequence", node("Fallback", Failure("no"), Success("yes")), node("Inverter", Running("wait")))
        root.tick_once()
        text = py_trees.display.unicode_tree(root, show_status=True)
        assert "[-] Sequence" in text or "{-} Sequence" in text
        assert "{o} Fallback" in text or "[o] Fallback" in text
        assert "-^- Inverter" in text
        assert "yes [✓]" in text
        assert py_trees.display.ascii_tree(root)
        assert py_trees.display.xhtml_tree(root, show_status=True)
        assert "Parallel" in str(py_trees.display.dot_tree(node("Parallel", root)))

    def test_the_tip_is_the_last_leaf_that_counts(self):
        wait = Running("wait")
        root = node("ReactiveSequence", Success("a"), node("Fallback", Failure("b"), wait))
        root.tick_once()
        assert root.tip() is wait
        bad = Failure("bad")
        root = node("Sequence", Success("a"), node("ForceFailure", bad))
        root.tick_once()
        assert root.tip() is bad


class TestTrees:
    def test_visitors_see_what_was_ticked_children_first(self):
        a, b, c = Success("a"), Running("b"), Success("c")
        inner = node("Sequence", b, c, name="inner")
        root = node("ReactiveSequence", a, inner)
        seen = []

        class Seen(py_trees.visitors.VisitorBase):
            def run(self, behaviour):
                seen.append((behaviour.name, behaviour.status))

        tree = py_trees.trees.BehaviourTree(root)
        snapshot = py_trees.visitors.SnapshotVisitor()
        tree.add_visitor(Seen())
        tree.add_visitor(snapshot)
        for _ in range(2):
            seen.clear()
            tree.tick()
            assert seen == [("a", S), ("b", R), ("inner", R), ("ReactiveSequence", R)]
        assert set(snapshot.visited) == {a.id, b.id, inner.id, root.id}
        assert tree.tip() is b

    def test_a_tree_may_be_edited_between_ticks(self):
        first, second = Success("first"), Running("second")
        root = node("Sequence", first, second)
        tree = py_trees.trees.BehaviourTree(root)
        tree.tick()
        tree.insert_subtree(Success("zeroth"), root.id, 0)
        tree.tick()
        assert (root.status, second.status, root.children[0].status) == (R, R, Status.INVALID)
        tree.replace_subtree(second.id, Success("better"))
        assert second.status is Status.INVALID
        tree.tick()
        assert root.status is S
        tree.prune_subtree(first.id)
        tree.tick()
        assert [c.name for c in root.children] == ["zeroth", "better"]

    def test_the_child_of_a_decorator_may_be_replaced(self):
        wait = Running("wait")
        root = node("Inverter", wait)
        tree = py_trees.trees.BehaviourTree(root)
        tree.tick()
        assert tree.replace_subtree(wait.id, Failure("no"))
        tree.tick()
        assert (root.status, wait.status, wait.parent) == (S, Status.INVALID, None)


class TestIdioms:
    def test_our_subtree_in_a_stock_composite_is_halted_once(self):
        log = []

        class Work(Leaf):
            def update(self):
                return RUNNING

            def terminate(self, new_status):
                log.append(new_status)

        ours = node("Fallback", Failure("no"), Work("work"))
        root = py_trees.composites.Selector("root", memory=False, children=[queue(F, F, S), ours])
        for _ in range(3):
            root.tick_once()
        assert (root.status, ours.status, log) == (S, Status.INVALID, [Status.INVALID])


@pytest.mark.parametrize("seed", range(150))
def test_a_tick_by_generator_is_a_tick(seed):
    """Visitors change nothing: direct ticks and generator ticks of equal trees are equal in all statuses."""

    def tree(draw, depth):
        if depth == 0:
            letters = "".join(draw.choices("SFR", k=draw.randint(1, 4)))
            return Letters(letters, letters) if draw.random() < 0.7 else Periodic("p", draw.randint(1, 3))
        if draw.random() < 0.2:
            return py_trees.composites.Sequence(
                "stock", memory=draw.random() < 0.5, children=[tree(draw, depth - 1) for _ in range(2)]
            )
        tag = draw.choice(["Sequence", "Fallback", "ReactiveSequence", "ReactiveFallback", "Parallel", "Inverter"])
        count = 1 if tag == "Inverter" else draw.randint(1, 3)
        return node(tag, *(tree(draw, depth - 1) for _ in range(count)))

    direct, visited = (tree(random.Random(seed), 3) for _ in range(2))
    if not isinstance(direct, Control):
        return
    for _ in range(6):
        direct.tick_once()
        visits = list(visited.tick())
        assert visits[-1] is visited
        assert [n.status for n in direct.iterate()] == [n.status for n in visited.iterate()]


@pytest.mark.parametrize("seed", range(150))
def test_where_nothing_is_skipped_our_composites_and_py_trees_are_the_same(seed):
    pairs = {
        "Sequence": lambda c: py_trees.composites.Sequence("s", memory=True, children=c),
        "Fallback": lambda c: py_trees.composites.Selector("f", memory=True, children=c),
        "ReactiveSequence": lambda c: py_trees.composites.Sequence("r", memory=False, children=c),
        "ReactiveFallback": lambda c: py_trees.composites.Selector("g", memory=False, children=c),
        "Inverter": lambda c: py_trees.decorators.Inverter("i", c[0]),
    }

    def tree(draw, depth, ours, leaves):
        if depth == 0:
            leaves.append(Letters("l", "".join(draw.choices("SFR", k=draw.randint(1, 4)))))
            return leaves[-1]
        tag = draw.choice(sorted(pairs))
        children = [tree(draw, depth - 1, ours, leaves) for _ in range(1 if tag == "Inverter" else draw.randint(1, 3))]
        return node(tag, *children) if ours else pairs[tag](children)

    leaves = ([], [])
    roots = [tree(random.Random(seed), 3, ours, leaves[ours]) for ours in (False, True)]
    for _ in range(8):
        for root in roots:
            root.tick_once()
        assert roots[0].status is roots[1].status
        assert [leaf.calls for leaf in leaves[0]] == [leaf.calls for leaf in leaves[1]]


class Done(Instant):
    def update(self):
        return SUCCESS


def test_ten_thousand_nodes_deep_and_wide():
    deep = Done("leaf")
    for level in range(10_000):
        deep = node(("Sequence", "Inverter", "ReactiveFallback", "Repeat")[level % 4], deep, **repeat(level))
    tree = Tree(deep)
    assert tree.settle() in (SUCCESS, FAILURE)
    assert len(tree.nodes) == 10_001
    wide = Tree(node("Sequence", *(Done("leaf") for _ in range(10_000))))
    assert wide.tick() is SUCCESS


def repeat(level):
    return {"num_cycles": "1"} if level % 4 == 3 else {}


def test_a_deep_tree_that_runs_is_halted_to_its_end():
    leaf = Letters("leaf", "R")
    deep = leaf
    for _ in range(5_000):
        deep = node("Sequence", deep)
    tree = Tree(deep)
    assert tree.tick() is RUNNING
    tree.halt()
    assert {n.status for n in tree.nodes} == {Status.INVALID}


class TestHook:
    def test_py_trees_own_nodes_are_told_of_too(self):
        tree = Tree(node("Sequence", Success("a"), Running("b")))
        told = []
        Changes(tree, lambda uid, before, now: told.append((uid, outcome_name(now))))
        tree.tick()
        assert sorted(told) == [(1, "RUNNING"), (2, "SUCCESS"), (3, "RUNNING")]


def test_ticks_are_written_down_only_while_a_generator_is_at_work():
    inner = node("Sequence", Success("stock"), node("AlwaysSuccess"))
    root = node("Fallback", inner)
    assert len(list(root.tick())) == 4
    root.tick_once()
    assert [n.name for n in inner.tick()] == ["stock", "AlwaysSuccess", "Sequence"]
    assert len(list(root.tick())) == 4
