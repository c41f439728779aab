"""Writing trees: what is written is loaded as the same tree, and the palette tells what the classes declare."""

import xml.etree.ElementTree as Et
from enum import Enum
from typing import Annotated, Any

import py_trees
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.actions import action_table
from rocs_bt.base.units import MetresPerSecond
from rocs_bt.plan import mission_nodes
from rocs_bt.trees.nodes import BUILTIN, CONDITIONS, InOut, Leaf, Node, Output, SubTree
from rocs_bt.trees.status import SUCCESS
from rocs_bt.trees.xml import load_xml, palette, read_document, write_tree

NODES = mission_nodes(action_table())
TEXTS = st.text(
    st.characters(codec="utf-8", exclude_categories=("Cs",), exclude_characters="\ufffe\uffff"), max_size=9
).filter(lambda text: not any(ord(c) < 32 and c not in "\n\t\r" for c in text))


def shape(node):
    """All that a document says of a node."""
    given = {n: str(v) for n, v in node.given.items() if v is not None}
    conditions = {n: s.text for n, s in node.conditions.items()}
    own = (node.tree, node.autoremap) if isinstance(node, SubTree) else ()
    other = {n: v for n, v in node.other.items() if n != "_autoremap"}
    return node.tag, node.name, given, conditions, other, own, [shape(c) for c in node.children]


def again(root, nodes=NODES):
    return load_xml(write_tree(root), nodes)


@st.composite
def trees(draw, depth=3):
    conditions = dict.fromkeys(draw(st.sets(st.sampled_from(CONDITIONS), max_size=2)), "x == 'a&b' && y < 2")
    extra = conditions | ({"_note": draw(TEXTS)} if draw(st.booleans()) else {})
    name = draw(st.one_of(st.just(""), TEXTS))
    if depth == 0 or draw(st.integers(0, 4)) == 0:
        tag, ports = draw(
            st.sampled_from(
                [
                    ("AlwaysSuccess", {}),
                    ("Script", {"code": "a := 'b' .. 3"}),
                    ("SetBlackboard", {"value": "{x}", "output_key": "y"}),
                    ("Sleep", {"msec": "{t}"}),
                    ("GoTo", {"goal": "dock", "cruise": "0.3 m/s"}),
                ]
            )
        )
        return NODES.make(tag, name or tag, [], ports | extra)
    tag, count, ports = draw(
        st.sampled_from(
            [
                ("Sequence", 3, {}),
                ("Fallback", 2, {}),
                ("Parallel", 2, {"success_count": "1", "failure_count": "{f}"}),
                ("Inverter", 1, {}),
                ("Repeat", 1, {"num_cycles": 3}),
                ("SubTree", 1, {}),
            ]
        )
    )
    children = [draw(trees(depth - 1)) for _ in range(count)]
    if tag == "SubTree":
        remaps = {
            k: draw(st.one_of(TEXTS, st.sampled_from(["{=}", "{x}", "7"])))
            for k in draw(st.sets(st.sampled_from("pqr")))
        }
        auto = {"_autoremap": "true"} if draw(st.booleans()) else {}
        tree = f"T{id(children[0])}"
        return SubTree(name or tree, children[0], ID=tree, **auto, **remaps, **extra)
    return NODES.make(tag, name or tag, children, ports | extra)


@given(trees())
def test_what_is_written_is_loaded_as_the_same_tree_and_written_the_same(root):
    text = write_tree(root)
    Et.fromstring(text)  # well-formed for everybody
    loaded = load_xml(text, NODES)
    assert shape(loaded) == shape(root)
    assert write_tree(loaded) == text


def test_a_small_change_is_a_small_difference():
    text = write_tree(load_xml(FILE, NODES), document=read_document(FILE))
    changed = write_tree(load_xml(FILE.replace("0.4 m/s", "0.5 m/s"), NODES), document=read_document(FILE))
    different = [(a, b) for a, b in zip(text.splitlines(), changed.splitlines(), strict=True) if a != b]
    assert len(different) == 1


FILE = """<root BTCPP_format="4" main_tree_to_execute="Main">
  <!-- the whole mission -->
  <BehaviorTree ID="Main" _description="x">
    <Sequence>
      <!-- there -->
      <GoTo cruise="0.4 m/s" goal="{goal}" name="there" _skipIf="known &amp;&amp; 1 &lt; 2"/>
      <SubTree goal="{=}" ID="Sub"/>
      <SubTree ID="Sub" goal="home"/>
    </Sequence>
  </BehaviorTree>
  <BehaviorTree ID="Sub"><TurnTo yaw="90 deg"/></BehaviorTree>
  <TreeNodesModel><SubTree ID="Sub"><input_port name="goal">where</input_port></SubTree></TreeNodesModel>
</root>"""


def test_comments_models_and_trees_are_kept_and_attributes_are_ordered():
    text = write_tree(load_xml(FILE, NODES), document=read_document(FILE))
    for part in (
        "<!-- the whole mission -->",
        '<BehaviorTree ID="Main" _description="x">',
        "<!-- there -->",
        '<GoTo name="there" goal="{goal}" cruise="0.4 m/s" _skipIf="known &amp;&amp; 1 &lt; 2"/>',
        '<SubTree ID="Sub" goal="{=}"/>',
        '<input_port name="goal">where</input_port>',
        '<Action ID="TurnTo">',
    ):
        assert part in text
    assert text.count('<BehaviorTree ID="Sub">') == 1


def test_a_tree_made_in_python_of_py_trees_own_nodes_is_written_as_what_it_means():
    root = py_trees.composites.Selector(
        "ways",
        memory=False,
        children=[
            py_trees.composites.Sequence(
                "first",
                memory=True,
                children=[py_trees.decorators.Inverter("not", py_trees.behaviours.Failure("no"))],
            ),
            py_trees.decorators.Repeat("twice", child=py_trees.behaviours.Success("yes"), num_success=2),
        ],
    )
    loaded = again(root)
    assert [type(n).__name__ for n in loaded.iterate()][-1] == "ReactiveFallback"
    assert {n.tag: n.name for n in loaded.iterate()} == {
        "ReactiveFallback": "ways",
        "Sequence": "first",
        "Inverter": "not",
        "AlwaysFailure": "no",
        "Repeat": "twice",
        "AlwaysSuccess": "yes",
    }


def test_a_mission_in_python_is_written_with_its_actions(mind):
    leaf = mind.mission.act("GoTo", goal="dock", cruise=0.3)
    root = py_trees.composites.Sequence("s", memory=True, children=[leaf, mind.mission.wait("2 s")])
    loaded = again(root)
    assert loaded.children[0].given == {"goal": "dock", "cruise": "0.3 m/s"}
    assert (loaded.children[1].tag, loaded.children[1].given) == ("Sleep", {"msec": "2000"})


class Colour(Enum):
    """An enum of the node below."""

    RED = 1


class Own(Leaf):
    """A node with all kinds of ports."""

    speed: Annotated[MetresPerSecond, "how fast"] = 0.5
    many: Annotated[list[float], "<numbers> & more"]
    colour: Colour = Colour.RED
    anything: InOut[Any] = None
    said: Annotated[Output[str], "what it said"]

    def update(self):
        return SUCCESS


def test_the_palette_tells_what_the_classes_declare():
    read = read_document(palette([Own, *BUILTIN.values()]))
    assert not read.faults
    ports = {p.name: (p.direction.value, p.type, p.default, p.doc) for p in read.models["Own"].ports.values()}
    assert ports == {
        "speed": ("input_port", "m/s", "0.5 m/s", "how fast"),
        "many": ("input_port", "std::vector<double>", None, "<numbers> & more"),
        "colour": ("input_port", "Colour", "RED", ""),
        "anything": ("inout_port", "BT::AnyTypeAllowed", None, ""),
        "said": ("output_port", "std::string", None, "what it said"),
    }
    assert {"Sequence", "RetryUntilSuccessful", "RecoveryNode"} <= read.models.keys()
    assert {n for n, c in BUILTIN.items() if c.kind != "SubTree"} < read.models.keys()


def test_each_default_of_the_palette_is_a_value_of_its_port():
    for model in read_document(palette(NODES.values())).models.values():
        cls: type[Node] = NODES[model.name]
        for port in model.ports.values():
            if port.default is not None and not port.default.startswith("{"):
                cls.ports[port.name].value(port.default)
