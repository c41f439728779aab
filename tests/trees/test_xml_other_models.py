"""Files that declare nodes of their own, and files of version 3: tables over all shipped nodes."""

from xml.sax.saxutils import quoteattr

import pytest

from rocs_bt.actions import action_table
from rocs_bt.plan import mission_nodes
from rocs_bt.trees.nodes import BUILTIN, Direction, SubTree, Tree
from rocs_bt.trees.status import FAILURE, RUNNING, SUCCESS
from rocs_bt.trees.xml import load_xml, make_nodes, read_document, stub_nodes, verify
from rocs_bt.trees.xml.model import differs

pytestmark = pytest.mark.filterwarnings("ignore::rocs_bt.trees.TreeWarning")

NODES = {
    dialect + node.tag: (dialect, node)
    for dialect in ("", "nav2", "nav2_servers")
    for node in mission_nodes(action_table(), dialect=dialect).values()
    if node is not SubTree and (not dialect or node.tag not in BUILTIN)
}
LEAF = "<AlwaysSuccess/>"
SECTION = {Direction.INPUT: "input_port", Direction.OUTPUT: "output_port", Direction.INOUT: "inout_port"}


def document(node, attributes, version="4", model=""):
    given = "".join(f" {name}={quoteattr(value)}" for name, value in attributes.items())
    element = f"<{node.tag}{given}>{LEAF * node.min_children}</{node.tag}>"
    models = f"<TreeNodesModel>{model}</TreeNodesModel>" if model else ""
    trees = f'<BehaviorTree ID="Main">{element}</BehaviorTree>'
    return f'<root BTCPP_format="{version}" main_tree_to_execute="Main">{trees}{models}</root>'


def errors(found, nodes):
    return [fault for fault in [*found.faults, *verify(found, nodes)] if not fault.warning]


@pytest.mark.parametrize("name", NODES)
def test_outputs_of_version_3_need_no_braces(name):
    dialect, node = NODES[name]
    nodes = mission_nodes(action_table(), dialect=dialect)
    inputs = {
        n: "k" if n == "output_key" else "{k}"
        for n, p in node.ports.items()
        if p.direction is not Direction.OUTPUT and p.required
    }
    outputs = [n for n, p in node.ports.items() if p.direction is Direction.OUTPUT]
    bare = read_document(document(node, {**inputs, **{n: f"key_{n}" for n in outputs}}, "3"))
    braced = read_document(document(node, {**inputs, **{n: f"{{key_{n}}}" for n in outputs}}))
    assert errors(bare, nodes) == errors(braced, nodes)
    assert bare.main().body.attributes == braced.main().body.attributes


@pytest.mark.parametrize("name", NODES)
def test_a_node_that_the_file_declares_otherwise_is_checked_as_declared(name):
    dialect, node = NODES[name]
    nodes = mission_nodes(action_table(), dialect=dialect)
    kind = "Control" if node.min_children else "Action"
    model = f'<{kind} ID="{node.tag}"><input_port name="of_another_robot" type="int"/></{kind}>'
    found = read_document(document(node, {"of_another_robot": "3"}, model=model))
    (error,) = errors(found, nodes)
    assert "has other ports than the node" in error.message
    stubs, (warning,) = stub_nodes(found, nodes, found.models, undeclared=False)
    assert errors(found, nodes.replaced(stubs)) == []
    assert warning.warning
    wrong = read_document(document(node, {"of_another_robot": "1.5"}, model=model))
    assert "'1.5' is not a whole number" in errors(wrong, nodes.replaced(stubs))[0].message


@pytest.mark.parametrize("name", NODES)
def test_a_model_of_the_class_itself_changes_nothing(name):
    _, node = NODES[name]
    kind = node.kind if (node.kind in ("Action", "Condition")) == (node.max_children == 0) else "Control"
    ports = "".join(f"<{SECTION[p.direction]} name={quoteattr(n)}/>" for n, p in node.ports.items() if p.required)
    found = read_document(document(node, {}, model=f'<{kind} ID="{node.tag}">{ports}</{kind}>'))
    assert not differs(found.models[node.tag], node)


@pytest.mark.parametrize(
    ("attributes", "expected"),
    [
        ('success_threshold="2" failure_threshold="1"', {"SS": SUCCESS, "SF": FAILURE, "SR": RUNNING}),
        ('success_threshold="1" failure_threshold="2"', {"SR": SUCCESS, "FR": RUNNING, "FF": FAILURE}),
        ('success_threshold="1"', {"FR": FAILURE, "SR": SUCCESS}),
        ('threshold="1"', {"SR": SUCCESS, "FR": RUNNING, "FF": FAILURE}),
        ('threshold="2"', {"SS": SUCCESS, "FR": FAILURE, "RR": RUNNING}),
    ],
)
def test_thresholds_of_version_3(attributes, expected):
    leaves = {"S": "<AlwaysSuccess/>", "F": "<AlwaysFailure/>", "R": '<Sleep msec="1000"/>'}
    for children, outcome in expected.items():
        body = f"<Parallel {attributes}>{''.join(leaves[c] for c in children)}</Parallel>"
        for version in ('BTCPP_format="3"', ""):  # a file of Groot 1 has no version
            found = read_document(f'<root {version}><BehaviorTree ID="M">{body}</BehaviorTree></root>')
            assert not errors(found, BUILTIN)
            assert Tree(make_nodes(found, BUILTIN), clock=Clock()).tick() is outcome, (children, version)


class Clock:
    def now(self):
        return 0.0


def test_braces_around_the_key_of_set_blackboard_have_no_meaning_in_version_3():
    body = '<Sequence><SetBlackboard value="a" output_key="{k}"/><SetBlackboard value="b" output_key="k"/></Sequence>'
    tree = Tree(load_xml(f'<root BTCPP_format="3"><BehaviorTree ID="M">{body}</BehaviorTree></root>'))
    assert tree.tick() is SUCCESS
    assert tree.board.texts() == {"k": "b"}
