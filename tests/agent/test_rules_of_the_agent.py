"""Rules in an agent: its robot's own thresholds, its mode, and included files in what counts as its content."""

import pytest

from rocs_bt.agent import AgentRuntime, Controller
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError
from rocs_bt.catalog import Catalog, content_hash
from rocs_bt.check import check_content
from rocs_bt.event import NullSink
from rocs_bt.testing.mock_agent import mock_agent

RULES = """format = "reflex/1"
doc = "Stops."
[threshold]
near = "0.4 m"
[rule.Stop]
when = "min(front) < near"
modes = ["drive"]
priority = 1
action = { name = "Stop" }
"""
ROBOT = '[rules.own]\nnear = "{}"\n'


@pytest.fixture
def project(tmp_path):
    """A project with a rule file, and a robot that is the P3DX with its own threshold for it."""

    def project(near="0.5 m", rules=RULES, robot=ROBOT):
        (tmp_path / "rules").mkdir(exist_ok=True)
        (tmp_path / "rules" / "own.toml").write_text(rules)
        folder = tmp_path / "robots" / "rover"
        folder.mkdir(parents=True, exist_ok=True)
        text = f'format = "robot/3"\ndoc = "A rover."\nbase = "pioneer_p3dx"\n{robot.format(near)}'
        (folder / "robot.toml").write_text(text)
        return Catalog(tmp_path)

    return project


def agent_of(catalog, build=lambda mission: mission.act("Stop")):
    mind = Controller(build, rules=[catalog.find("rules", "own").path])
    agent, _ = mock_agent(catalog.load_robot("rover"), mind, AgentRuntime(SimulatedClock(0.05), NullSink()))
    (model,) = agent.knowledge.reactive_models
    return agent, model


def test_a_robot_has_its_own_thresholds(project):
    _, model = agent_of(project("0.7 m"))
    assert model.rules.thresholds == {"near": 0.7}


def test_a_wrong_one_is_told_in_the_robots_file(project, tmp_path):
    with pytest.raises(InputError, match=r"robot.toml:5:1: 'near' must be in m, found '1 s'"):
        agent_of(project("1 s"))
    catalog = project(robot='[rules.ownn]\nnear = "{}"\n')
    found = [str(f) for f in check_content([catalog.find("robot", "rover").path]).faults]
    assert any("robot.toml:4:1" in f and "no rule file is named 'ownn'. Did you mean 'own'?" in f for f in found), found


def test_the_mode_is_the_agents_own_nodes(project):
    agent, model = agent_of(project())
    assert model.mode == ""
    agent.knowledge.graph.set(agent.knowledge.agent, mode="drive")
    assert model.mode == "drive"


def test_a_mission_enters_a_mode(project):
    entered = []

    def build(mission):
        entered.append(mission.enter("drive"))
        return entered[0]

    _, model = agent_of(project(), build)
    entered[0].tick_once()
    assert model.mode == "drive"


def test_an_included_file_is_content(project, tmp_path):
    catalog = project(rules='include = ["parts/common.toml"]\n' + RULES.replace("format", "format", 1))
    (tmp_path / "rules" / "parts").mkdir()
    common = tmp_path / "rules" / "parts" / "common.toml"
    common.write_text('format = "reflex/1"\n')
    shipped = Catalog().find("scenario", "exp1").path.read_text()
    (tmp_path / "scenarios").mkdir()
    scenario = tmp_path / "scenarios" / "yard.toml"
    scenario.write_text(shipped.replace('rules = ["avoid_collision"]', 'rules = ["own"]'))
    loaded = catalog.load_scenario("yard")
    before = content_hash(catalog.content_of(loaded))
    common.write_text('format = "reflex/1"\ndoc = "Else."\n')
    assert content_hash(Catalog(tmp_path).content_of(loaded)) != before
