"""A mission in XML is a subtree of other missions by its name, in XML and in Python, with its nodes and defaults."""

import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.plan import TreePlan
from rocs_bt.trees.status import SUCCESS

MODEL = (
    '<TreeNodesModel><SubTree ID="inner"><input_port name="k"/><input_port name="d" default="7"/>'
    '<output_port name="out"/></SubTree></TreeNodesModel>'
)


def root(trees, model=""):
    bodies = "".join(f'<BehaviorTree ID="{name}">{body}</BehaviorTree>' for name, body in trees.items())
    return f'<root BTCPP_format="4" main_tree_to_execute="{next(iter(trees))}">{bodies}{model}</root>'


INNER = root(
    {"inner": '<SubTree ID="helper" k="{k}" d="{d}" out="{out}"/>', "helper": '<Script code="out := k + d"/>'}, MODEL
)


@pytest.fixture
def play(mind, tmp_path):
    """Play a mission of a project; returns its blackboard."""
    folder = tmp_path / "planners" / "missions"
    folder.mkdir(parents=True)

    def play(name="outer", **files):
        for stem, text in {"inner": INNER, **files}.items():
            (folder / f"{stem}.{'xml' if text.startswith('<') else 'py'}").write_text(text)
        catalog = Catalog(tmp_path)
        tree = TreePlan(catalog.load_mission(name)(mind.mission), mind.mission).tree
        assert tree.tick() is SUCCESS
        return tree.board

    return play


@pytest.mark.parametrize(
    ("body", "out"),
    [
        ('<SubTree ID="inner" k="1" out="{r}"/>', 8),
        ('<SubTree ID="inner" k="1" d="2" out="{r}"/>', 3),
        ('<Sequence><Script code="a := 5"/><SubTree ID="inner" k="{a}" out="{r}"/></Sequence>', 12),
        (
            '<Sequence><SubTree ID="inner" k="1" out="{r}"/>'
            '<SubTree ID="inner" name="again" k="{r}" out="{r}"/></Sequence>',
            15,
        ),
    ],
)
def test_a_subtree_names_a_mission_with_its_own_trees_and_defaults(play, body, out):
    assert play(outer=root({"outer": body}))["r"] == out


def test_a_tree_of_the_document_has_priority(play):
    own = root({"outer": '<SubTree ID="inner" r="{r}"/>', "inner": '<Script code="r := 1"/>'})
    assert play(outer=own)["r"] == 1


def test_a_tree_of_the_document_replaces_a_tree_that_the_mission_uses_with_a_warning(mind, play):
    own = root({"outer": '<SubTree ID="inner" k="1" out="{r}"/>', "helper": "<Script code=\"out := 'own'\"/>"})
    mind.mission.report = lambda *faults: warned.extend(faults)
    warned = []
    assert play(outer=own)["r"] == "own"
    assert "this tree replaces the tree 'helper' of inner.xml, which 'inner' uses." in [f.message for f in warned]


def test_a_mission_finds_missions_that_name_others(play):
    middle = root({"middle": '<SubTree ID="inner" k="{k}" out="{out}"/>'})
    assert play(outer=root({"outer": '<SubTree ID="middle" k="2" out="{r}"/>'}), middle=middle)["r"] == 9


@pytest.mark.parametrize("given", ["k=1", "k=1, d=7", "k='{a}', d=0"])
def test_a_python_mission_names_it_too(mind, play, given):
    mind.mission.board["a"] = 8
    code = f'"""Outer."""\n\n\ndef build(mission):\n    return mission.tree("inner", out="{{r}}", {given})\n'
    assert play(outer=code)["r"] == 8


def test_the_project_replaces_what_is_shipped(play):
    navigate = root({"navigate": "<Script code=\"r := 'own ' + goal\"/>"})
    outer = root({"outer": '<SubTree ID="navigate" goal="dock" r="{r}"/>'})
    assert play(outer=outer, navigate=navigate)["r"] == "own dock"


@pytest.mark.parametrize("lines", ['<SubTree ID="navigate" goal="dock"/>', "mission.tree('navigate', goal='dock')"])
def test_the_shipped_ones_are_found_with_their_nodes_and_defaults(mind, tmp_path, lines):
    folder = tmp_path / "planners" / "missions"
    folder.mkdir(parents=True)
    python = f'"""Outer."""\n\n\ndef build(mission):\n    return {lines}\n'
    path = folder / ("outer.xml" if lines.startswith("<") else "outer.py")
    path.write_text(root({"outer": lines}) if path.suffix == ".xml" else python)
    tree = TreePlan(Catalog(tmp_path).load_mission("outer")(mind.mission), mind.mission).tree
    (plan,) = [node for node in tree.nodes if node.name == "ComputeRoute"]
    assert (plan.goal, plan.planner, plan.clearance) == ("dock", "grid_astar", 0.005)
