"""A mission in Nav2's words drives a robot to its goal in MuJoCo, around a box and after failures."""

import json

import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.compare import ScenarioScene
from rocs_bt.compare.episode import Episode
from rocs_bt.compare.runner import EpisodeRunner
from rocs_bt.event import NodeTicked
from rocs_bt.record import Recording

from .nav2_mission import mission

SCENARIO = """format = "scenario/2"
base = "exp1"
duration = "{duration}"
nodes = "{nodes}"

[[place]]
name = "box"
kind = "object"
x = "{x}"
y = "{y}"
yaw = "0 deg"
length = "0.5 m"
width = "0.5 m"
agents = ["R2"]

[[agent]]
name = "R2"
mission = "navigation"
[agent.parameters]
{parameters}
"""


@pytest.fixture
def project(tmp_path):
    """Writes a project with the mission, and a scenario that plays it."""

    def write(nodes="nav2", parameters='goal = "goal"', y="1 m", x="-0.5 m", retries=6, duration="60 s"):
        for folder in ("planners/missions", "scenarios"):
            (tmp_path / folder).mkdir(parents=True, exist_ok=True)
        (tmp_path / "planners/missions/navigation.xml").write_text(mission(retries))
        text = SCENARIO.format(nodes=nodes, parameters=parameters, x=x, y=y, duration=duration)
        (tmp_path / "scenarios/drive.toml").write_text(text)
        return tmp_path

    return write


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_robot_reaches_the_goal_around_the_box(rocs_bt, project, seed):
    folder = project()
    ran = rocs_bt("run", "drive", "--seed", seed, "--out", folder / "out")
    assert ran.code == 0, ran.text
    (agent,) = json.loads((folder / "out/summary.json").read_text())["agents"].values()
    assert (agent["outcome"], agent["collisions"]) == ("success", 0)
    assert rocs_bt("replay", folder / "out").code == 0


@pytest.mark.parametrize(("nodes", "later"), [("nav2", []), ("nav2:jazzy", ["Spin"])], ids=["lyrical", "jazzy"])
def test_recoveries_are_tried_in_turn_and_then_it_fails(rocs_bt, project, nodes, later):
    folder = project(nodes=nodes, y="0.5 m", x="0 m", retries=6)  # the robot believes that the box is near the goal
    ran = rocs_bt("run", "drive", "--seed", 1, "--out", folder / "out")
    (agent,) = json.loads((folder / "out/summary.json").read_text())["agents"].values()
    assert agent["outcome"] == "failed", ran.text
    assert agent["path_length"] > 0.05  # it backed up
    events = [e for e in Recording.open(folder / "out").events() if isinstance(e, NodeTicked)]
    turns = [e.node.split("in turn/")[1] for e in events if "in turn/" in e.node and e.status == "SUCCESS"]
    assert [turn for turn in turns if "/" not in turn] == [
        "clear",
        "Spin",
        "Wait",
        "BackUp",
        *later,  # in Lyrical the node fails after its last child
    ]  # "clear" is at once
    assert not [e for e in events if e.node.endswith("FollowPath")]  # it never drove: its error code has no value
    why = "ComputePathToPose: BLOCKED: the goal is too near to 'box'"
    assert (why if later else "in turn: the last of 4 children has ended, and wrap_around is false") in ran.text


def test_a_goal_in_an_obstacle_has_no_recovery_and_the_reason_says_so(rocs_bt, project):
    folder = project(y="0 m", x="0 m")
    ran = rocs_bt("run", "drive", "--seed", 1, "--out", folder / "out", "--no-report")
    assert ran.code == 1
    why = "WouldAPlannerRecoveryHelp: no recovery helps after the error 206 BLOCKED: the goal is occupied: "
    assert why + "the goal is too near to 'box'" in ran.text


def test_a_place_may_have_any_name(rocs_bt, project):
    folder = project(parameters='goal = "0;map;0.3;0;0;0;0;0;1"')
    file = folder / "scenarios/drive.toml"
    file.write_text(file.read_text().replace('name = "box"', 'name = "path_end"'))
    ran = rocs_bt("run", "drive", "--seed", 1, "--out", folder / "out")
    assert "the mission returned SUCCESS, but it is 0.40 m from 'goal'" in ran.text


@pytest.mark.parametrize("command", ["check", "run"])
@pytest.mark.parametrize(
    ("goal", "says"),
    [
        ("gaol", "no place is named 'gaol'. Did you mean 'goal'?"),
        ("0;map;nan;0;0;0;0;0;1", "contains a field that is not finite"),
        ("0;map;1;x;0;0;0;0;1", "'x' is not a number"),
    ],
)
def test_a_goal_that_is_no_place_is_refused_at_its_line(rocs_bt, project, command, goal, says):
    folder = project(parameters=f'goal = "{goal}"')
    ran = rocs_bt("check", folder) if command == "check" else rocs_bt("run", "drive", "--out", folder / "out")
    assert ran.code == 2
    line = 2 + SCENARIO.split("[agent.parameters]")[0].count("\n")
    assert f"drive.toml:{line}:1: " in ran.text
    assert says in ran.text
    assert ran.text.count(says) == 1


def test_a_parameter_of_a_subtree_is_looked_at_too(rocs_bt, project):
    folder = project(nodes="rocs", parameters='goal = "gaol"')
    (folder / "planners/missions/navigation.xml").write_text(
        '<root BTCPP_format="4" main_tree_to_execute="Main"><BehaviorTree ID="Main"><SubTree ID="go" to="{goal}"/>'
        '</BehaviorTree><BehaviorTree ID="go"><GoTo goal="{to}"/></BehaviorTree>'
        '<TreeNodesModel><SubTree ID="Main"><input_port name="goal"/></SubTree></TreeNodesModel></root>'
    )
    checked = rocs_bt("check", folder)
    assert checked.code == 2
    assert "drive.toml:20:1: 'GoTo': no place is named 'gaol'. Did you mean 'goal'?" in checked.text


def test_several_goals_are_looked_at_one_by_one(rocs_bt, project):
    folder = project(parameters='goals = "R1;goal"')
    (folder / "planners/missions/navigation.xml").write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="Main"><ComputePathThroughPoses goals="{goals}"/>'
        "</BehaviorTree></root>"
    )
    checked = rocs_bt("check", folder)
    assert checked.code == 0
    assert (
        "drive.toml:20:1: warning: 'ComputePathThroughPoses': the position of 'R1' is not known at the" in checked.text
    )
    ran = rocs_bt("run", "drive", "--out", folder / "out")
    assert "ComputePathThroughPoses: NO_GOAL: the position of 'R1' is unknown" in ran.text


def test_a_key_that_a_node_writes_is_not_looked_at(rocs_bt, project):
    folder = project(parameters='goal = "elsewhere"')
    file = folder / "planners/missions/navigation.xml"
    text = file.read_text().replace("<PipelineSequence", "<Sequence><Script code=\"goal := 'goal'\"/><PipelineSequence")
    file.write_text(text.replace("</PipelineSequence>", "</PipelineSequence></Sequence>"))
    assert rocs_bt("check", folder).code == 0


def test_a_literal_goal_that_is_no_place_is_refused_at_its_element(rocs_bt, project):
    folder = project(parameters="")
    file = folder / "planners/missions/navigation.xml"
    file.write_text(file.read_text().replace('ComputePathToPose goal="{goal}"', 'ComputePathToPose goal="gaol"'))
    line = 1 + mission().split("<ComputePathToPose")[0].count("\n")
    for ran in (rocs_bt("check", folder), rocs_bt("run", "drive", "--out", folder / "out")):
        assert ran.code == 2
        assert f"navigation.xml:{line}:" in ran.text
        assert "no place is named 'gaol'. Did you mean 'goal'?" in ran.text


def test_the_project_and_the_mission_alone_are_fine(rocs_bt, project):
    folder = project()
    assert rocs_bt("check", folder).out.splitlines()[-1].endswith("checked: no faults.")
    assert rocs_bt("check", folder / "planners/missions/navigation.xml").code == 0
    (folder / "elsewhere.xml").write_text(mission(1))
    assert rocs_bt("check", "--nodes", "nav2", folder / "elsewhere.xml").code == 0
    assert "RateController" in rocs_bt("show", folder / "elsewhere.xml", "--nodes", "nav2").out


NAMED = '<TreeNodesModel><SubTree ID="MainTree"><MetadataFields><Metadata nav2_distribution="{}"/></MetadataFields>'
NAMED += "</SubTree></TreeNodesModel></root>"
MODEL_OF_GROOT = '<TreeNodesModel><Action ID="FollowPath"><input_port name="path"/></Action></TreeNodesModel></root>'


@pytest.mark.parametrize(
    ("end", "distribution"), [("</root>", "Lyrical"), (NAMED.format("humble"), "Humble"), (MODEL_OF_GROOT, "Lyrical")]
)
def test_every_command_recognises_a_mission_of_nav2_and_says_so_once(rocs_bt, project, end, distribution):
    folder = project()
    mission, scenario = folder / "planners/missions/navigation.xml", folder / "scenarios/drive.toml"
    mission.write_text(mission.read_text().replace("</root>", end))
    scenario.write_text(scenario.read_text().replace('nodes = "nav2"\n', ""))
    (folder / "elsewhere.xml").write_text(mission.read_text())
    commands = (
        ("check", folder / "elsewhere.xml"),
        ("check", mission),
        ("check", folder),
        ("show", folder / "elsewhere.xml"),
        ("show", mission),
        ("run", "drive", "--for", "0.5", "--no-report", "--out", folder / "out"),
    )
    for command in commands:
        done = rocs_bt(*command)
        assert done.code == (1 if command[0] == "run" else 0), done.text
        assert done.text.count(f".xml: note: this is a mission of Nav2, read as one of {distribution};") == 1, command
        assert "warning" not in done.text.replace("0 warnings", ""), command
    scenario.write_text(scenario.read_text().replace("duration", 'nodes = "nav2"\nduration'))
    for command in (("check", folder), ("run", "drive", "--for", "0.5", "--no-report", "--out", folder / "out")):
        assert "mission of Nav2" not in rocs_bt(*command).text, "the scenario names it"


def test_an_unknown_distribution_is_refused_at_its_element(rocs_bt, tmp_path):
    file = tmp_path / "elsewhere.xml"
    file.write_text(mission(1).replace("</root>", NAMED.format("humbel")))
    for command in ("check", "show"):
        done = rocs_bt(command, file)
        assert done.code == 2
        line = 1 + file.read_text().split("<Metadata ")[0].count("\n")
        assert f"elsewhere.xml:{line}:" in done.text
        assert "no distribution is named 'humbel'. Did you mean 'humble'?" in done.text


def test_own_nodes_and_actions_with_names_of_nav2_stay_what_they_are(rocs_bt, project):
    folder = project(nodes="rocs", parameters="")
    (folder / "planners/nodes").mkdir()
    (folder / "planners/nodes/spin.py").write_text(
        "from rocs_bt.trees.nodes import SUCCESS, Instant\n\n\nclass Spin(Instant):\n"
        '    """Own node."""\n\n    turns: int = 1\n\n    def update(self):\n        return SUCCESS\n'
    )
    mission = folder / "planners/missions/navigation.xml"
    mission.write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="Main"><Sequence><Spin turns="2"/></Sequence></BehaviorTree></root>'
    )
    scenario = folder / "scenarios/drive.toml"
    scenario.write_text(scenario.read_text().replace('nodes = "rocs"\n', ""))
    for command in (("check", folder), ("show", mission)):
        done = rocs_bt(*command)
        assert (done.code, "of Nav2" in done.text) == (0, False), done.text
    assert "of Nav2" not in rocs_bt("run", "drive", "--for", "0.5", "--no-report", "--out", folder / "out").text


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        (
            {"nodes": "rocs", "parameters": ""},
            "'RateController' is a node of Nav2. Write nodes = \"nav2\" in the scenario",
        ),
        ({"nodes": "nav3"}, "invalid value 'nav3' for 'nodes'. Did you mean 'nav2'?"),
        ({"parameters": ""}, "goal"),
    ],
)
def test_a_scenario_that_does_not_fit_is_refused(rocs_bt, project, changes, says):
    folder = project(**changes)
    checked = rocs_bt("check", folder)
    assert checked.code == 2
    assert says in checked.text


def test_nodes_on_the_command_line_count_more_than_the_scenario(rocs_bt, project):
    file = project() / "planners/missions/navigation.xml"
    for command in ("check", "show"):
        assert rocs_bt(command, file).code == 0
        told = rocs_bt(command, file, "--nodes", "rocs")
        assert told.code == 2
        assert "'RateController' is a node of Nav2" in told.text


def test_a_mission_of_nav2_is_a_planner_to_compare(rocs_bt, project):
    folder = project(nodes="rocs", parameters="")
    (folder / "scenarios/drive.toml").unlink()
    planner = folder / "planners/nav.toml"
    text = (
        'format = "planner/1"\ndoc = "One."\nmission = "navigation"\nrules = ["avoid_collision"]\nnodes = "nav2"\n'
        '[parameters]\ngoal = "goal"\n'
    )
    planner.write_text(text)
    checked = rocs_bt("check", folder)
    assert checked.out.splitlines()[-1] == "2 files checked: no faults.", checked.text
    (record,) = [
        EpisodeRunner(folder).play(
            Episode("key", Catalog(folder).load_planner("nav"), ScenarioScene("exp1"), 1, folder)
        )
    ]
    assert record.outcome == "success", record
    planner.write_text(text.replace('"nav2"\n', '"rocs"\n'))
    checked = rocs_bt("check", folder)
    assert checked.code == 2
    assert "'RateController' is a node of Nav2" in checked.text


def test_the_palette_has_the_nodes_of_nav2(rocs_bt):
    text = rocs_bt("show", "--palette", "--nodes", "nav2").out
    for name in ("RateController", "FollowPath", "ComputePathToPose", "Spin", "GoalUpdated"):
        assert text.count(f' ID="{name}"') == 1
    assert '<input_port name="path"' in text.split('ID="FollowPath"')[1].split("</Action>")[0]
    assert "RateController" not in rocs_bt("show", "--palette").out
