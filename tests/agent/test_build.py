"""An agent is exactly what its robot.toml says, and what it cannot be is told with the file."""

import shutil

import pytest

from rocs_bt.agent import AgentRuntime, Controller
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError, WiringError
from rocs_bt.catalog import Catalog
from rocs_bt.event import NullSink
from rocs_bt.testing.mock_agent import mock_agent


def build(spec, **mind):
    given = {"build": lambda mission: mission.act("Stop"), **mind}
    return mock_agent(spec, Controller(**given), AgentRuntime(SimulatedClock(0.05), NullSink()))


@pytest.fixture
def edited(tmp_path):
    """The shipped P3DX with something else in its robot.toml."""

    def edited(old, new):
        folder = tmp_path / "robots" / "pioneer_p3dx"
        shutil.copytree(Catalog().find("robot", "pioneer_p3dx").path.parent, folder)
        text = (folder / "robot.toml").read_text()
        assert text.count(old) == 1
        (folder / "robot.toml").write_text(text.replace(old, new))
        return Catalog(tmp_path).load_robot("pioneer_p3dx")

    return edited


def test_there_is_one_of_each_and_what_the_file_lists(p3dx):
    agent, _ = build(p3dx)
    assert [m.name for m in agent.monitors] == [m.name for m in p3dx.monitors]
    assert [a.name for a in agent.analyzes] == [a.name for a in p3dx.analyzers]
    assert agent.plan.pipeline is agent.execute.pipeline is agent.pipeline
    assert {b.knowledge for b in (agent.plan, *agent.monitors, *agent.analyzes)} == {agent.knowledge}
    graph = agent.knowledge.graph
    assert set(graph.nodes("sensor")) == set(agent.sensors) == {s.name for s in p3dx.sensors}
    assert set(graph.nodes("actuator")) == set(agent.actuators)
    assert graph.get("sonar", "driver") == "range_cone"


def test_two_agents_share_nothing(p3dx):
    (one, _), (two, _) = build(p3dx), build(p3dx)
    for part in ("knowledge", "plan", "execute", "pipeline", "arc"):
        assert getattr(one, part) is not getattr(two, part)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('class = "RangeMonitor"', 'class = "RangeMonitr"', ["RangeMonitr", "RangeMonitor"]),
        ('class = "PassPosition"', 'class = "PassPositon"', ["PassPositon", "PassPosition"]),
        ('min_vanish_range = "0.7 m"', 'min_vanish_rang = "0.7 m"', ["RangeMonitor 'range'", "min_vanish_rang"]),
        ("beams = 16", 'beams = "many"', ["beams must be a whole number", "many"]),
        ("beams = [0, 1, 2, 3]", "beams = [0, 1, 2, 33]", ["group 'left_gap'", "33"]),
        ('signal = "wheel_speeds"', 'signal = "wheel_sped"', ["wheel_sped", "wheel_speeds"]),
    ],
)
def test_what_cannot_be_built_is_told_with_its_file(old, new, words, edited):
    with pytest.raises(InputError) as told:
        build(edited(old, new))
    assert "robot.toml" in str(told.value)
    for word in words:
        assert word in str(told.value)


def test_a_mission_with_an_unknown_action_is_told(p3dx):
    with pytest.raises(InputError, match=r"GoToo.*GoTo"):
        build(p3dx, build=lambda mission: mission.act("GoToo"))


def test_only_the_wires_of_the_architecture_can_be_laid(p3dx):
    agent, _ = build(p3dx)
    monitor, analyze = agent.monitors[0], agent.analyzes[0]
    for block, target, wanted in (
        (monitor, agent.plan, "an Analyze"),
        (monitor, monitor, "an Analyze"),
        (analyze, analyze, "a Plan"),
        (analyze, agent.execute, "a Plan"),
    ):
        with pytest.raises(WiringError, match=f"can be attached to {wanted} only, found {type(target).__name__}"):
            block.attach(target)


def test_a_mission_knows_why_the_gate_of_the_locomotion_is_held(p3dx):
    missions = []
    _, stage = build(p3dx, build=lambda mission: missions.append(mission) or mission.act("Stop"))
    stage.actuators[p3dx.motion.actuator].hold("emergency stop")
    assert [mission.motion_held() for mission in missions] == ["emergency stop"]
    stage.actuators[p3dx.motion.actuator].release()
    assert [mission.motion_held() for mission in missions] == [""]
