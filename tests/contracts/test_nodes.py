"""What holds for every node that we ship: built-in ones, those of planners/nodes, and the robot's actions."""

import inspect
import re

import pytest

from rocs_bt.actions import ACTIONS
from rocs_bt.catalog import Catalog
from rocs_bt.declare import summary_of
from rocs_bt.plan import action_nodes, mission_nodes
from rocs_bt.ros2.nodes import ROS_NODES
from rocs_bt.trees.nodes import BUILTIN, Control, Decorator, Direction, Leaf, Node
from rocs_bt.trees.nodes.node import NODE_ATTRIBUTES, RESERVED

CATALOG = Catalog()
OWN = {node.tag: node for node in CATALOG.load_nodes()}
EVERY = mission_nodes(ACTIONS, list(OWN.values()))
TABLE = {
    cells[1].strip(" `"): cells
    for line in (CATALOG.shipped / "planners" / "README.md").read_text("utf-8").split("## Nodes")[1].splitlines()
    if line.startswith("| `") and len(cells := line.strip("|").split("|")) == 4
}


def test_the_nodes_of_our_own_are_these():
    assert sorted(OWN) == [
        "Ask",
        "ComputeRoute",
        "FinishTask",
        "Known",
        "Log",
        "MarkVisited",
        "PlaceGoal",
        "SelectStrategy",
        "Speak",
        "UseStrategy",
        "WaitForChange",
        "WaitForOpenDoor",
        "When",
    ]
    assert set(EVERY) == {*BUILTIN, *OWN, *ACTIONS, *(node.tag for node in ROS_NODES)}, "no name is used twice"
    assert {"GoTo", "FollowPath", "FollowRobot", "TurnTo", "Dock", "Stop", "AvoidCollision", "GoToOrigin"} <= set(EVERY)


@pytest.mark.parametrize("tag", sorted(EVERY))
def test_a_node_says_what_it_is_and_its_ports_can_be_written_in_a_file(tag):
    node = EVERY[tag]
    assert issubclass(node, Node)
    assert len(summary_of(node)) > 3
    assert re.fullmatch(r"[A-Za-z][A-Za-z0-9]*", tag)
    assert node.kind in ("Control", "Decorator", "Action", "Condition", "SubTree")
    family = Control if node.kind == "Control" else Decorator if node.kind in ("Decorator", "SubTree") else Leaf
    assert issubclass(node, family)
    for name, port in node.ports.items():
        assert re.fullmatch(r"[A-Za-z]\w*", name)
        assert name not in RESERVED
        if port.direction is Direction.OUTPUT:
            assert not port.required, "what is written may be thrown away"
        elif isinstance(port.default, str) and port.default:
            port.value(port.default)


@pytest.mark.parametrize("tag", sorted(OWN))
def test_a_node_of_our_own_documents_its_ports_and_stands_in_the_table(tag):
    node = OWN[tag]
    file, name, what, told = TABLE[tag]
    assert inspect.getfile(node).endswith(f"/{file.strip(' `')}.py")
    assert name.strip(" `") == tag
    assert what.strip()
    ports = {p.name: p for p in node.ports.values()}
    reads, _, writes = told.partition("; writes ")
    assert re.findall(r"`(\w+)`", reads) == [n for n, p in ports.items() if p.direction is not Direction.OUTPUT]
    assert re.findall(r"`(\w+)`", writes) == [n for n, p in ports.items() if p.direction is Direction.OUTPUT]
    assert all(port.doc for port in ports.values())
    assert set(re.findall(r"`(\w+)` \(needed\)", reads)) == {n for n, p in ports.items() if p.required}


@pytest.mark.parametrize("tag", sorted(OWN))
def test_a_node_without_what_it_needs_is_refused_with_what_that_is(tag):
    needed = {p.name: p.doc for p in OWN[tag].ports.values() if p.required}
    found = OWN[tag].attribute_faults({})
    assert {name: fault.hint for name, fault in found} == needed
    assert [name for name, _ in OWN[tag].attribute_faults({**dict.fromkeys(needed, "{k}"), "zzz": "1"})] == ["zzz"]


@pytest.mark.parametrize("action", sorted(ACTIONS))
def test_an_action_is_a_node_whose_ports_are_its_parameters(action):
    (node,) = [n for n in action_nodes(ACTIONS) if n.tag == action]
    assert not set(node.ports) & NODE_ATTRIBUTES
    assert "max_preemptions" in node.ports
