"""TurnAngle on the motors of every robot that we ship, which follow late, and on tyres that slip."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from rocs_bt import run
from rocs_bt.catalog import Catalog
from rocs_bt.event import BodyMoved
from rocs_bt.record.file.recording import Recording

ROBOTS = [
    "humanoid",
    "jackal",
    "pioneer_p3dx",
    "quadrotor",
    "quadruped",
    "robotino",
    "rosbot_xl",
    "summit_xl",
    "turtlebot3_burger",
]

MISSION = """<root BTCPP_format="4" main_tree_to_execute="turn"><BehaviorTree ID="turn"><Sequence>
<TurnAngle angle="90 deg" rate="2.5 rad/s"/><Stop/><TurnAngle angle="-60 deg" rate="2.5 rad/s"/><Stop/>
</Sequence></BehaviorTree></root>"""

SCENARIO = """format = "scenario/2"
world = "plane"
duration = "10 s"
[[agent]]
name = "R"
robot = "{robot}"
mission = "turn"
x = "0 m"
y = "0 m"
"""


@pytest.mark.parametrize("robot", ROBOTS)
def test_a_quick_turn_ends_where_it_should_and_goes_no_farther(tmp_path: Path, robot: str) -> None:
    for file, text in (("planners/missions/turn.xml", MISSION), ("scenarios/turn.toml", SCENARIO.format(robot=robot))):
        (tmp_path / file).parent.mkdir(parents=True)
        (tmp_path / file).write_text(text, encoding="utf-8")
    result = run("turn", Catalog(tmp_path), out=tmp_path / "run", report=False)
    assert result.summary.agents["R"].outcome == "success"
    moves = [e for e in Recording.open(tmp_path / "run").events() if isinstance(e, BodyMoved) and e.body == "R"]
    yaws = [math.degrees(e.yaw) for e in moves]
    assert 88.5 < max(yaws) < 91.5
    assert yaws[-1] == pytest.approx(30.0, abs=1.5)


def test_that_is_every_robot_with_a_model_of_its_own() -> None:
    robots = {entry.name for entry in Catalog().list("robot") if (entry.path.parent / "robot.xml").is_file()}
    assert robots == set(ROBOTS)
