"""Missions in XML: parameters, the robot's actions, mixing with Python, and what the command line does with them."""

import py_trees
import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.base.units import SPEED, PositiveMetresPerSecond
from rocs_bt.catalog import Catalog, PlannerSpec, content_hash
from rocs_bt.check import check_content
from rocs_bt.cli.main import call
from rocs_bt.declare import MISSING
from rocs_bt.plan import mission_arguments, mission_parameters, xml_mission

from ..pages import data_of


def text(body, model="", *trees):
    trees = "".join(trees)
    return f"""<!-- A mission. -->
<root BTCPP_format="4" main_tree_to_execute="Main"><BehaviorTree ID="Main">{body}</BehaviorTree>{trees}
<TreeNodesModel><SubTree ID="Main">{model}</SubTree></TreeNodesModel></root>"""


PORTS = """<input_port name="goal"/><input_port name="cruise" type="m/s" default="30 cm/s"/>
<input_port name="far" type="double" default="2 m"/><input_port name="rounds" type="int" default="3"/>
<input_port name="loud" type="bool" default="false"/>"""


@pytest.fixture
def write(tmp_path):
    def write(name, content):
        file = tmp_path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(content)
        return file

    return write


class TestParameters:
    def test_they_are_the_input_ports_of_the_main_tree(self, write):
        found = mission_parameters(xml_mission(write("a.xml", text("<AlwaysSuccess/>", PORTS))))
        assert {n: (p.hint, p.required, p.default) for n, p in found.items()} == {
            "goal": (str, True, MISSING),
            "cruise": (float, False, 0.3),
            "far": (float, False, 2.0),
            "rounds": (int, False, 3),
            "loud": (bool, False, False),
        }
        assert found["cruise"].dimension == SPEED

    def test_a_scenarios_values_are_checked_and_become_keys(self, write, mind):
        build = xml_mission(write("a.xml", text('<GoTo goal="{goal}" cruise="{cruise}"/>', PORTS)))
        with pytest.raises(InputError, match="the mission needs goal"):
            mission_arguments(build, {"cruise": "1 m/s"})
        with pytest.raises(InputError, match="cruise must be in m/s"):
            mission_arguments(build, {"goal": "dock", "cruise": "1 m"})
        mind.start(build(mind.mission, **mission_arguments(build, {"goal": "dock", "cruise": "0.5 m/s"})))
        mind.run()
        (ticket,) = [mind.plan.root.ticket]
        assert (ticket.action.goal, ticket.action.cruise) == ("dock", 0.5)


class TestMixing:
    def test_a_python_mission_holds_a_tree_in_xml(self, write, mind):
        file = write("a.xml", text('<Sequence><Script code="said := word"/><AlwaysSuccess/></Sequence>'))
        mind.start(mind.mission.tree(file, word="hello", said="{heard}"))
        mind.run()
        assert mind.plan.status == "SUCCESS"
        assert mind.plan.tree.board["heard"] == "hello"

    def test_a_tree_in_xml_holds_a_python_mission_by_its_name(self, write, mind):
        body = '<Sequence><SubTree ID="errand" goal="dock" cruise="0.2 m/s" rounds="2"/></Sequence>'
        build = xml_mission(write("a.xml", text(body)), missions={"errand": errand}.get)
        root = build(mind.mission)
        leaves = [n for n in root.iterate() if not n.children]
        assert [leaf.name for leaf in leaves] == ["GoTo dock"] * 2
        assert leaves[0].make().cruise == 0.2


def errand(mission, *, goal: str, cruise: PositiveMetresPerSecond = 0.5, rounds: int = 1):
    """Drives somewhere, several times."""
    legs = [mission.act("GoTo", goal=goal, cruise=cruise) for _ in range(rounds)]
    return py_trees.composites.Sequence("errand", memory=True, children=legs)


NODE = '''"""A node of one's own."""
from rocs_bt.trees.nodes import Instant, SUCCESS

class Greet(Instant):
    """Greets."""
    whom: str
    def update(self):
        return SUCCESS
'''


class TestProject:
    @pytest.fixture
    def project(self, write, tmp_path):
        write("planners/nodes/greet.py", NODE)
        write("planners/missions/meet.xml", text('<Sequence><Greet whom="R1"/><SubTree ID="corners"/></Sequence>'))
        return Catalog(tmp_path)

    def test_nodes_are_found_by_their_class_and_missions_by_their_name(self, project):
        entry = project.find("mission", "meet")
        assert [e.name for e in project.python_of(entry)] == ["greet", "corners"]
        assert not check_content([entry.path]).faults

    def test_a_file_whose_nodes_nobody_names_is_not_run(self, project, write):
        write("planners/nodes/broken.py", NODE.replace("Greet", "Other") + "\nraise RuntimeError\n")
        assert not check_content([project.find("mission", "meet").path]).has_errors

    @pytest.fixture
    def mixed(self, write, project):
        """A Python mission with a tree in XML that uses a node of the project, one of Nav2, and a mission in Python."""
        foreign = '<TruncatePath distance="1.0" input_path="{p}" output_path="{p}"/>'
        body = f'<Sequence><Greet whom="R1"/><SubTree ID="corners"/>{foreign}</Sequence>'
        write("planners/missions/parts/inner.xml", text(body))
        write("planners/missions/both.py", BOTH)
        return project.find("mission", "both")

    @pytest.mark.parametrize("dialect", ["nav2", ""])  # by default it is recognised
    def test_a_tree_in_a_python_mission_has_its_dialect_and_the_projects_content(self, mixed, mind, tmp_path, dialect):
        build = Catalog(tmp_path).load_mission("both", dialect)
        first, second = build(mind.mission).children
        for each in (first, second):  # also behind a Python mission below it
            assert [type(n).__name__ for n in each.iterate()].count("Greet") == 1
            assert any(n.name == "TruncatePath" for n in each.iterate())

    def test_in_another_dialect_its_nodes_are_unknown(self, mixed, mind, tmp_path):
        with pytest.raises(InputError, match=r"inner\.xml:2:\d+: .*TruncatePath"):
            Catalog(tmp_path).load_mission("both", "rocs")(mind.mission)

    def test_that_tree_and_its_nodes_count_for_the_hash(self, mixed, write, tmp_path):
        planner = PlannerSpec(name="it", mission="both", doc="", nodes="nav2")
        before = content_hash(Catalog(tmp_path).content_of_controller(planner))
        for file, words in (("nodes/greet.py", NODE + "# more"), ("missions/parts/inner.xml", text("<Greet/>"))):
            write(f"planners/{file}", words)
            after = content_hash(Catalog(tmp_path).content_of_controller(planner))
            assert after != before
            before = after

    def test_the_check_of_a_project_tells_faults_of_xml_missions(self, project, write, tmp_path):
        file = write(
            "planners/missions/wrong.xml",
            text('<Sequence><Greet whom="{x}"/><GoTo goal="a" cruise="9 m/s"/><Nope/></Sequence>'),
        )
        told = [str(f) for f in check_content([file]).faults]
        assert len(told) == 2  # no scenario uses the mission, so no robot's limit applies to its cruise
        assert "the key 'x' is read" in told[0]
        assert "no node is named 'Nope'" in told[1]


BOTH = '''"""A mission of both kinds."""
from pathlib import Path
from py_trees.composites import Sequence

INNER = Path(__file__).parent / "parts/inner.xml"

def build(mission):
    return Sequence("both", memory=True, children=[mission.tree(INNER), mission.tree(INNER)])
'''


class TestShow:
    @pytest.mark.parametrize("form", ["text", "svg", "html", "xml"])
    @pytest.mark.parametrize("mission", ["rounds", "corners"])
    def test_a_mission_is_drawn_in_each_form(self, capsys, mission, form):
        assert call(["show", mission, "--format", form]) == 0
        told = capsys.readouterr().out
        told = str(data_of(told)["header"]) if form == "html" else told
        assert "GoTo" in told
        assert "corner_1" in told

    def test_ports_tell_where_their_keys_come_from(self, capsys):
        call(["show", "rounds"])
        told = capsys.readouterr().out
        assert "goal = {place}   ('first' of rounds, given: corner_1)" in told
        assert "cruise = 0.4 m/s" in told

    def test_what_show_writes_as_xml_is_the_same_mission(self, tmp_path, capsys):
        assert call(["show", "rounds", "--format", "xml", "--out", str(tmp_path / "rounds.xml")]) == 0
        capsys.readouterr()
        shown = []
        for name in ("rounds", str(tmp_path / "rounds.xml")):
            assert call(["show", name]) == 0
            shown.append(capsys.readouterr().out)
        assert shown[0] == shown[1]

    def test_the_palette_has_actions_and_nodes(self, capsys, tmp_path):
        assert call(["show", "--palette", "--out", str(tmp_path / "nodes.xml")]) == 0
        written = (tmp_path / "nodes.xml").read_text()
        assert '<Action ID="GoTo">' in written
        assert '<Condition ID="When">' in written
