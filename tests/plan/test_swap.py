"""Swapping a subtree of a running tree between two ticks: the old one is halted once, the board stays."""

import threading

import py_trees
import pytest
from py_trees.common import Status

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import NodeTicked, SubtreeSwapped, TicketChanged
from rocs_bt.trees.board import Board
from rocs_bt.trees.error import TreeError
from rocs_bt.trees.nodes import BUILTIN, Changes, Leaf, Output, SubTree, Tree

Sequence, Parallel = BUILTIN["Sequence"], BUILTIN["Parallel"]


class Told(Leaf):
    """Does as it is told, and keeps what happened to it."""

    def __init__(self, name, outcomes="R", /, **attributes):
        super().__init__(name, **attributes)
        self.outcomes, self.log = outcomes, []

    def initialise(self):
        self.log.append("start")

    def update(self):
        self.log.append("tick")
        ticks = self.log.count("tick") - 1
        return {"R": Status.RUNNING, "S": Status.SUCCESS, "F": Status.FAILURE}[
            self.outcomes[ticks % len(self.outcomes)]
        ]

    def terminate(self, new_status):
        if new_status is Status.INVALID:
            self.log.append("halt")


class Whole(Told):
    """Reads a whole number, and writes it on."""

    number: int | None = None
    said: Output[int]

    def update(self):
        self.said = self.number
        return super().update()


class Word(Told):
    """Reads a list."""

    number: list[float] | None = None


def test_the_old_one_is_halted_once_and_the_others_notice_nothing():
    before, old, after = Told("before", "S"), Told("old"), Told("after", "S")
    tree = Tree(Sequence("top", [before, Sequence("group", [old]), after]))
    tree.tick()
    new = Told("new", "RS")
    tree.swap(tree.find("group"), new)
    assert old.log == ["start", "tick", "halt"]
    assert tree.tick() is Status.RUNNING
    assert tree.tick() is Status.SUCCESS
    assert (before.log, new.log) == (["start", "tick"], ["start", "tick", "tick"])
    assert old.log == ["start", "tick", "halt"]
    assert [node.name for node in tree.nodes] == ["top", "before", "new", "after"]
    assert [tree.uid(node) for node in tree.nodes] == [1, 2, 3, 4]
    assert old.parent.parent is None


def test_the_board_is_kept():
    board = Board()
    board["x"] = 7
    tree = Tree(Sequence("top", [Whole("old", number="{x}", said="{y}")]), board=board)
    tree.tick()
    assert board["y"] == 7
    tree.swap(tree.find("old"), Whole("new", number="{y}", said="{z}"))
    tree.tick()
    assert (board["y"], board["z"]) == (7, 7)


def test_of_a_subtree_the_tree_in_it_is_exchanged_and_its_own_board_stays():
    board = Board()
    board["outer"] = 3
    inner = SubTree("care", Whole("old", number="{in}", said="{own}"), ID="Care", **{"in": "{outer}"})
    tree = Tree(Sequence("top", [inner]), board=board)
    tree.tick()
    own = tree.boards[inner.decorated]
    tree.swap(tree.find("care"), Sequence("better", [Whole("new", number="{own}", said="{in}", _onSuccess="")]))
    tree.tick()
    assert tree.boards[tree.find("care/new")] is own
    assert tree.find("care") is inner
    assert (own["own"], board["outer"]) == (3, 3)


def test_a_type_clash_is_refused_and_the_old_one_stays_in_force():
    board = Board()
    board["x"] = 7
    old = Whole("old", number="{x}", said="{y}")
    tree = Tree(Sequence("top", [old]), board=board)
    tree.tick()
    nodes, keys = tree.nodes, [key for key, _ in board.entries()]
    wrong = Sequence("wrong", [Whole("a", number="{x}", said="{fresh}"), Word("b", number="{y}")])
    with pytest.raises(TreeError, match="the key 'y' is of type int, not list"):
        tree.swap(old, wrong)
    assert (tree.nodes, [key for key, _ in board.entries()]) == (nodes, keys)
    assert tree.tick() is Status.RUNNING
    assert old.log == ["start", "tick", "tick"]
    board["fresh"] = "text"  # the key that was declared on the way has no type left over


def test_py_trees_own_nodes_can_go_and_come():
    old = Told("old")
    top = py_trees.composites.Sequence("top", memory=True, children=[Told("first", "S"), old])
    tree = Tree(top)
    tree.tick()
    assert top.current_child is old
    tree.swap(old, py_trees.decorators.Inverter("not", py_trees.behaviours.Failure("no")))
    assert tree.tick() is Status.SUCCESS
    assert old.log == ["start", "tick", "halt"]
    tree.swap(tree.find("no"), Told("yes", "S"))
    assert tree.tick() is Status.FAILURE


def test_who_watches_goes_on_hearing_with_the_new_numbers():
    tree = Tree(Sequence("top", [Told("a", "S"), Told("b"), Told("c", "S")]), clock=SimulatedClock(0.1))
    told = []
    Changes(tree, lambda uid, before, now: told.append((tree.nodes[uid - 1].name, now.name)))
    tree.tick()
    told.clear()
    tree.swap(tree.find("b"), Sequence("group", [Told("d", "S"), Told("e", "S")]))
    assert told == [("b", "INVALID")]
    told.clear()
    tree.tick()
    assert told == [
        ("d", "SUCCESS"),
        ("e", "SUCCESS"),
        ("group", "SUCCESS"),
        ("c", "SUCCESS"),
        ("top", "SUCCESS"),
        ("a", "INVALID"),
    ]


# --- of a mission


def swaps(mind):
    return [e for e in mind.rig.sink.events if isinstance(e, SubtreeSwapped)]


def test_a_mission_swaps_a_leaf_whose_action_runs(mind):
    mind.rig.knowledge.world.place("far", Pose2(3.0, 0.0))
    mind.rig.knowledge.world.place("near", Pose2(0.3, 0.0))
    plan = mind.start(Sequence("mission", [mind.mission.act("GoTo", goal="far", name="go")]))
    mind.run(10)
    old = plan.root.children[0]
    assert old.ticket.state.name == "RUNNING"
    plan.tree.board["kept"] = 5
    plan.swap("go", mind.mission.act("GoTo", goal="near", name="go"))
    assert (old.ticket.state.name, old.ticket.cancelled_by) == ("CANCELLED", "mission/go")
    mind.until_done()
    assert plan.status == "SUCCESS"
    assert plan.tree.board["kept"] == 5
    tickets = [(e.parameters["goal"], e.state) for e in mind.rig.sink.events if isinstance(e, TicketChanged)]
    assert tickets == [
        ("far", "QUEUED"),
        ("far", "RUNNING"),
        ("far", "CANCELLED"),
        ("near", "QUEUED"),
        ("near", "RUNNING"),
        ("near", "SUCCEEDED"),
    ]


def test_a_recording_hears_of_it(mind):
    group = Sequence("group", [mind.mission.wait(5.0, name="long")])
    plan = mind.start(Sequence("mission", [group, mind.mission.wait(0.1, name="last")]))
    mind.run(3)
    plan.swap("mission/group", mind.mission.wait(0.1, name="short"))
    (event,) = swaps(mind)
    assert (event.node, event.by) == ("mission/group", "mission/short")
    assert [(node.path, node.type, node.children) for node in event.nodes] == [
        ("mission", "Sequence", ("mission/short", "mission/last")),
        ("mission/short", "Wait", ()),
        ("mission/last", "Wait", ()),
    ]
    assert [o.path for o in plan.outline] == [node.path for node in event.nodes]
    ticked = [(e.node, e.status) for e in mind.rig.sink.events if isinstance(e, NodeTicked)]
    assert ticked[-2:] == [("mission/group/long", "INVALID"), ("mission/group", "INVALID")]
    assert plan.called
    mind.until_done()
    assert ("mission/short", "SUCCESS") in [
        (e.node, e.status) for e in mind.rig.sink.events if isinstance(e, NodeTicked)
    ]


def test_what_cannot_take_the_place_is_refused_and_the_mission_goes_on(mind):
    plan = mind.start(Sequence("mission", [mind.mission.wait(0.4, name="old")]))
    mind.run(2)
    empty = py_trees.composites.Sequence("empty", memory=True)
    for wrong, words in (
        (empty, "has no children"),
        ("text", "not a py_trees behaviour"),
        (plan.root, "belongs to a tree"),
    ):
        with pytest.raises(InputError, match=words):
            plan.swap("old", wrong)
    with pytest.raises(InputError, match="no node is named 'odl'"):
        plan.swap("odl", mind.mission.wait(1.0))
    assert swaps(mind) == []
    mind.until_done()
    assert plan.status == "SUCCESS"
    with pytest.raises(InputError, match="the mission has ended"):
        plan.swap("old", mind.mission.wait(1.0))


def test_a_tick_cannot_swap_its_own_tree(mind):
    class Rash(Told):
        def update(self):
            plan.swap("rash", Told("new"))
            return Status.SUCCESS

    plan = mind.start(Sequence("mission", [Rash("rash")]))
    with pytest.raises(TreeError, match="during a tick"):
        plan.run(0.0)


def test_another_thread_waits_for_the_end_of_the_tick(mind):
    inside, go_on = threading.Event(), threading.Event()

    class Slow(Told):
        def update(self):
            inside.set()
            assert go_on.wait(10.0)
            return super().update()

    plan = mind.start(Sequence("mission", [Slow("slow")]))
    ticking = threading.Thread(target=plan.run, args=(0.0,))
    ticking.start()
    assert inside.wait(10.0)
    swapping = threading.Thread(target=plan.swap, args=("slow", Told("new", "S")))
    swapping.start()
    swapping.join(0.1)
    assert swapping.is_alive()
    go_on.set()
    ticking.join(10.0)
    swapping.join(10.0)
    assert [node.name for node in plan.tree.nodes] == ["mission", "new"]
