"""`.btlog`: what Groot2 replays, read back by a reader written anew, and held against BehaviorTree.CPP's own."""

import struct
from functools import partial
from pathlib import Path
from xml.etree import ElementTree

import py_trees
import pytest
from py_trees.common import Status

from rocs_bt.base.errors import InputError, RecordingError
from rocs_bt.trees.btlog import BtLog
from rocs_bt.trees.nodes import BUILTIN, Leaf
from rocs_bt.trees.xml import load_xml

from .. import needs
from ..waiting import until

STATUSES = {"R": Status.RUNNING, "S": Status.SUCCESS, "F": Status.FAILURE}


class Scripted(Leaf):
    """Comes to R, S or F, tick by tick."""

    does: str = "S"
    count = 0

    def update(self):
        self.count += 1
        return STATUSES[self.does[(self.count - 1) % len(self.does)]]


def read(path: Path):
    """A log: its document, its first time, and its changes as (µs, uid, status)."""
    data = path.read_bytes()
    assert data[:19] == b"BTCPP4-FileLogger2\x01"
    (size,) = struct.unpack("<i", data[19:23])
    document = ElementTree.fromstring(data[23 : 23 + size].decode())
    (first,) = struct.unpack("<q", data[23 + size : 31 + size])
    rest = data[31 + size :]
    assert len(rest) % 9 == 0
    records = [rest[i : i + 9] for i in range(0, len(rest), 9)]
    return document, first, [(int.from_bytes(r[:6], "little"), int.from_bytes(r[6:8], "little"), r[8]) for r in records]


@pytest.fixture
def logged(mind, tmp_path):
    """Run a mission with a log beside it."""

    def run(root, ticks=8):
        plan = mind.start(root)
        log = BtLog(tmp_path / "R1.btlog", plan.tree, plan.name)
        for _ in range(ticks):
            plan.run(mind.rig.clock.now())
            mind.rig.run()
        log.close()
        return read(tmp_path / "R1.btlog")

    return run


def test_py_trees_own_nodes_are_told_too(logged):
    stock = py_trees.composites.Selector(
        "either", memory=True, children=[py_trees.behaviours.Failure("no"), Scripted("ours")]
    )
    document, _, changes = logged(py_trees.decorators.Inverter("not", stock), 1)
    assert [(node.tag, node.get("name"), node.get("_uid")) for node in document.find("BehaviorTree").iter()][1:] == [
        ("Inverter", "not", "1"),
        ("Fallback", "either", "2"),
        ("AlwaysFailure", "no", "3"),
        ("Scripted", "ours", "4"),
    ]
    assert [(uid, status) for _, uid, status in changes] == [
        (1, 1), (2, 1), (4, 2), (3, 3), (3, 0), (4, 0), (2, 2), (2, 0), (1, 3), (1, 0)
    ]  # fmt: skip  # changes, several on a line


def test_a_swap_begins_another_file(mind, tmp_path):
    plan = mind.start(BUILTIN["Sequence"]("top", [Scripted("a", does="S"), Scripted("b", does="R")]))
    log = BtLog(tmp_path / "R1.btlog", plan.tree, plan.name)
    plan.run(0.0)
    plan.swap("b", BUILTIN["Sequence"]("group", [Scripted("c", does="R")]))
    plan.run(0.1)
    log.close()
    _, _, first = read(tmp_path / "R1.btlog")
    document, _, second = read(tmp_path / "R1-2.btlog")
    assert [(uid, s) for _, uid, s in first] == [(1, 1), (2, 2), (3, 1), (3, 0)]
    assert [node.get("name") for node in document.find("BehaviorTree").iter()][1:] == ["top", "a", "group", "c"]
    assert [(uid, s) for _, uid, s in second] == [(1, 1), (3, 1), (4, 1)]


def test_more_nodes_than_the_format_can_number_are_refused(mind, tmp_path, monkeypatch):
    monkeypatch.setattr("rocs_bt.trees.btlog.MAX_NODES", 2)
    plan = mind.start(BUILTIN["Sequence"]("top", [Scripted("a"), Scripted("b")]))
    with pytest.raises(InputError, match=r"has 3 nodes; a \.btlog file can hold at most 2.*live page"):
        BtLog(tmp_path / "R1.btlog", plan.tree, plan.name)


@needs.linux("has /dev/full, a disk that is always full")
def test_a_full_disk_stops_no_robot(mind, tmp_path):
    plan = mind.start(Scripted("a", does="RRR"))
    log = BtLog(tmp_path / "R1.btlog", plan.tree, plan.name)
    log._file.close()
    log._file = Path("/dev/full").open("wb")  # noqa: SIM115 - the log closes it
    plan.run(0.0)
    assert plan.status == "RUNNING"
    with pytest.raises(RecordingError, match=r"cannot write the log ./dev/full.: No space"):
        log.close()


def ended(path: Path) -> bool:
    """Whether the root's end is in the file.

    The logger's writer is a thread, which drops what is left at the end. It flushes by itself; a flush from this thread
    would be concurrent with its writes, and bytes would be lost.
    """
    try:
        changes = read(path)[2]
    except (AssertionError, ValueError, struct.error, ElementTree.ParseError):  # a part of the file
        return False
    return any(uid == changes[0][1] and status == 2 for _, uid, status in changes)


def theirs(bt, path: Path):
    """The same document run by BehaviorTree.CPP, with its own logger."""
    factory = bt.BehaviorTreeFactory()
    for tag, script in LEAVES.items():
        names = iter([{"R": "RUNNING", "S": "SUCCESS", "F": "FAILURE"}[c] for c in script * 20])

        def tick(*_, names=names):
            return bt.NodeStatus.__members__[next(names)]

        factory.register_simple_stateful_action(tag, tick, tick, lambda *_: None)
    factory.register_behavior_tree_from_text(WITH_LEAVES)
    board = bt.Blackboard.create()
    board.set_int("x", 4)
    tree = factory.create_tree("test", board)
    logger = bt.FileLogger(tree, str(path))
    while tree.tick_exactly_once() == bt.NodeStatus.RUNNING:
        pass
    until(partial(ended, path))
    del logger, tree
    return read(path)


LEAVES = {"First": "S", "Second": "RRS", "Third": "FRS", "Inner": "RF"}
WITH_LEAVES = """
<root BTCPP_format="4" main_tree_to_execute="test">
  <BehaviorTree ID="test">
    <Sequence name="top">
      <First name="first" _skipIf="x == 4"/>
      <SubTree ID="Sub" name="s" k="{x}"/>
      <Fallback>
        <Inverter><Second name="second"/></Inverter>
        <RetryUntilSuccessful num_attempts="3"><Third name="third"/></RetryUntilSuccessful>
      </Fallback>
      <SubTree ID="Sub" name="again" k="{x}" _onSuccess="x := 5"/>
    </Sequence>
  </BehaviorTree>
  <BehaviorTree ID="Sub"><ForceSuccess><Inner name="inner"/></ForceSuccess></BehaviorTree>
</root>
"""


def test_a_log_is_built_as_one_of_the_cpp_engine(logged, mind, tmp_path):
    bt = needs.package("behaviortreepy")
    made = {tag: type(tag, (Scripted,), {"does": script}) for tag, script in LEAVES.items()}
    mind.mission.board["x"] = 4
    ours, _, changes = logged(load_xml(WITH_LEAVES, {**BUILTIN, **made}), 9)
    assert mind.plan.status == "SUCCESS"
    document, first, expected = theirs(bt, tmp_path / "theirs.btlog")
    assert first > 0

    def told(document):
        return [[(node.tag, node.attrib) for node in t.iter()] for t in document.findall("BehaviorTree")]

    assert told(ours) == told(document)
    assert [change[1:] for change in changes] == [change[1:] for change in expected]
    ports = {m.get("ID"): {(p.tag, p.get("name")) for p in m} for m in ours.find("TreeNodesModel")}
    for model in document.find("TreeNodesModel"):
        if model.get("ID") in ("Sequence", "Inverter", "RetryUntilSuccessful", "Parallel", "Switch2", "SetBlackboard"):
            assert ports[model.get("ID")] == {(p.tag, p.get("name")) for p in model}
