"""Nodes without names are told apart by their ports: in the header of a recording, its report, and `--why`."""

import re

import pytest

from rocs_bt import Catalog, Recording, run
from rocs_bt.record import explain

from ..pages import data_of

TREE = """<!-- Two places. -->
<root BTCPP_format="4" main_tree_to_execute="Main"><BehaviorTree ID="Main"><Sequence>
  <GoTo goal="kitchen"/><GoTo goal="{second}" cruise="0.2 m/s"/><GoTo name="to the dock" goal="dock"/>
  <Sleep msec="100"/><AlwaysSuccess/>
</Sequence></BehaviorTree>
<TreeNodesModel><SubTree ID="Main"><input_port name="second" default="bath"/></SubTree></TreeNodesModel></root>"""
SCENARIO = """format = "{format}"
world = "plane"
duration = "2 s"
[[place]]
name = "kitchen"
x = "0.2 m"
y = "0 m"
[[place]]
name = "bath"
x = "0.4 m"
y = "0 m"
[[place]]
name = "dock"
x = "0.6 m"
y = "0 m"
[[agent]]
name = "R1"
robot = "pioneer_p3dx"
mission = "places"
x = "0 m"
y = "0 m"
yaw = "0 deg"
"""
LEAVES = {
    "Sequence/GoTo": '(goal="kitchen")',
    "Sequence/GoTo#2": '(goal="{second}", cruise="0.2 m/s")',
    "Sequence/to the dock": "",  # the name contains the goal
    "Sequence/Sleep": '(msec="100")',
    "Sequence/AlwaysSuccess": "",
}


def ports(plan):
    return {node.path: node.ports for node in plan.tree_nodes()}


def test_leaves_of_python_show_what_their_names_omit(mind):
    mission = mind.mission
    tree = mission.node(
        "Sequence",
        mission.act("GoTo", goal="dock", cruise="0.3 m/s"),
        mission.act("TurnAngle", angle="90 deg", name="turn 1"),
        mission.when("front > 0.5 m"),
        mission.node("Script", code="; ".join(["x := 1"] * 20)),
    )
    go, turn, when, script = list(ports(mind.start(tree)).values())[1:]
    assert go == '(cruise="0.3 m/s")'
    assert re.fullmatch(r'\(angle="1.57\d* rad"\)', turn)
    assert when == ""
    assert script == '(code="x := 1; x := 1; x := 1; x := 1; x := 1; x := 1; x := 1; x :…")'


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    project = tmp_path_factory.mktemp("project")
    (project / "planners/missions").mkdir(parents=True)
    (project / "scenarios").mkdir()
    (project / "planners/missions/places.xml").write_text(TREE)
    shipped = Catalog().find("scenario", "exp1").path.read_text("utf-8")
    text = SCENARIO.replace("{format}", re.search(r'format = "(.*?)"', shipped)[1])
    (project / "scenarios/here.toml").write_text(text)
    return Recording.open(run("here", catalog=Catalog(project), out=project / "out").recording)


def test_recording_report_and_explanation_show_the_same(recording):
    (agent,) = recording.header.agents
    named = {node.path.partition("/")[2]: node.ports for node in agent.nodes if "/" in node.path}
    assert named == {path.partition("/")[2]: text for path, text in LEAVES.items()}
    page = data_of(recording.path.parent / "report.html")
    assert [node["ports"] for node in page["header"]["agents"][0]["nodes"]] == [node.ports for node in agent.nodes]
    assert 'GoTo(goal="kitchen")' in str(explain(recording, 0.5))
