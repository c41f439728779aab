"""A mission with nodes of ROS 2 through `rocs_bt.drive`: the robot and the servers are plain rclpy."""

from __future__ import annotations

import pytest

from rocs_bt import ListSink, drive
from rocs_bt.catalog import Catalog

from ..exp1 import OPTIONS, start_of, write_project

pytestmark = pytest.mark.usefixtures("awake")

ERRAND = """<root BTCPP_format="4"><BehaviorTree ID="errand"><Sequence>
  <RosAction action="fibonacci" type="test_msgs/action/Fibonacci" goal="order = 5" result="sequence[5] -> {n}"/>
  <RosPublish topic="say" type="std_msgs/msg/String" values="data = {n}"/>
  <RosService service="lamp" type="std_srvs/srv/SetBool" request="data = true" response="success -> {lit}"/>
  <ScriptCondition code="n == 5 &amp;&amp; lit"/>
</Sequence></BehaviorTree></root>"""
LONG = """<root BTCPP_format="4"><BehaviorTree ID="errand">
  <RosAction action="fibonacci" type="test_msgs/action/Fibonacci" goal="order = 29"/>
</BehaviorTree></root>"""
NAVIGATE = '''"""A node like those of Nav2, for an action type that is installed."""
from rocs_bt.ros2.nodes.nav2_actions import Nav2Motion


class Navigate(Nav2Motion):
    """Like NavigateToPose."""

    type = "test_msgs/action/Fibonacci"

    def fields(self, known, types):
        return {"order": 39, "of_a_later_distribution": 1}


def build(mission):
    return Navigate("go", server_name="fibonacci", cmd_vel="cmd_vel_nav2")
'''


def project(folder, mission, name="errand.xml") -> Catalog:
    catalog = write_project(folder, transport="rclpy")
    scenario = folder / "scenarios" / "real.toml"
    scenario.write_text(scenario.read_text() + 'mission = "errand"\nparameters = {}\nrules = []\n')
    file = folder / "planners" / "missions" / name
    file.parent.mkdir(parents=True)
    file.write_text(mission)
    return catalog


def test_a_mission_uses_topics_services_and_actions(counterpart, servers, tmp_path):
    counterpart(*OPTIONS, *start_of(1))
    found = drive("real", project(tmp_path, ERRAND), duration=30.0, out=tmp_path / "out")
    assert found.summary.agents["R2"].outcome == "success", found.summary.agents["R2"].reason
    assert servers.until("lamp") is True
    assert servers.seen.count(["ended", 5]) == 1


def test_the_end_of_a_run_cancels_the_goal(counterpart, servers, tmp_path):
    counterpart(*OPTIONS, *start_of(1))
    found = drive("real", project(tmp_path, LONG), duration=1.0, out=tmp_path / "out")
    assert found.summary.agents["R2"].outcome == "timeout"
    servers.until("cancelled")


def test_a_dry_run_sends_no_goal(counterpart, servers, tmp_path):
    counterpart(*OPTIONS, *start_of(1))
    found = drive("real", project(tmp_path, LONG), duration=10.0, out=tmp_path / "out", dry_run=True)
    assert found.summary.agents["R2"].outcome == "failed"
    assert "dry run" in found.summary.agents["R2"].reason
    assert not [happened for happened in servers.seen if happened[0] == "asked"]


def test_commands_of_a_navigator_pass_the_gate_and_end_with_its_goal(counterpart, servers, tmp_path):
    robot, sink = counterpart(*OPTIONS, *start_of(1)), ListSink()
    begun = robot.report()["pose"]
    found = drive("real", project(tmp_path, NAVIGATE, "errand.py"), duration=30.0, out=tmp_path / "out", sinks=[sink])
    agent = found.summary.agents["R2"]
    assert agent.outcome == "success", agent.reason
    assert agent.actions["RelayTwist"]["CANCELLED"] >= 1, agent.actions
    robot.until("speeds == [0.0, 0.0]")
    ended = robot.end()["pose"]
    moved = ((ended[0] - begun[0]) ** 2 + (ended[1] - begun[1]) ** 2) ** 0.5
    commands = [line for line in robot.lines() if line.what == "command"]
    assert moved > 0.05
    assert max(line.v for line in commands) == pytest.approx(0.15)
    assert commands[-1].rests
