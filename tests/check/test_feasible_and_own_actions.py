"""A goal that leaves little room is told; an action that stands in a mission's own file can be used at once."""

from pathlib import Path

import pytest

from rocs_bt import run
from rocs_bt.catalog import Catalog
from rocs_bt.check import check_content

MISSION = '''"""Turn on the spot with an action of my own."""

from rocs_bt.interfaces.action import AtomicAction, Body, Progress
from rocs_bt.base.geometry import Twist2
from rocs_bt.plan import Mission
from rocs_bt.base.units import RadiansPerSecond


class Whirl(AtomicAction):
    """One turn of the wheels, for ten periods."""

    rate: RadiansPerSecond = 1.0
    turns: int = 0

    def act(self, body: Body) -> Progress:
        self.turns += 1
        body.move(Twist2(0.0, self.rate))
        return Progress.RUNNING if self.turns < 10 else Progress.SUCCEEDED


def build(mission: Mission):
    """One leaf."""
    return mission.act("Whirl", rate="30 deg/s")
'''

SCENARIO = """format = "scenario/2"
doc = "Whirl."
world = "arena_box"
duration = "5 s"
[[agent]]
name = "R2"
robot = "pioneer_p3dx"
mission = "whirl"
x = "1 m"
y = "-1 m"
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    (tmp_path / "planners" / "missions").mkdir(parents=True)
    (tmp_path / "scenarios").mkdir()
    (tmp_path / "planners" / "missions" / "whirl.py").write_text(MISSION)
    (tmp_path / "scenarios" / "whirl.toml").write_text(SCENARIO)
    return tmp_path


def test_a_missions_own_action_is_checked_and_runs(project):
    catalog = Catalog(project)
    found = check_content([project])
    assert [str(f) for f in found.faults] == []
    result = run("whirl", catalog)
    assert result.success
    assert result.summary.agents["R2"].actions == {"Whirl": {"SUCCEEDED": 1}}


def test_faults_come_by_file_and_line(project):
    file = project / "scenarios" / "whirl.toml"
    file.write_text(SCENARIO.replace("doc =", "dog =").replace('x = "1 m"', 'x = "1 s"'))
    assert [(f.file, f.line) for f in check_content([project]).faults] == [(file, 2), (file, 9)]


def test_an_action_beyond_the_limits_of_a_robot_is_told_with_robot_and_scenario(project):
    file = project / "scenarios" / "slow.toml"
    place = '[[place]]\nname = "goal"\nx = "2 m"\ny = "-1 m"\n'
    text = SCENARIO.replace("pioneer_p3dx", "turtlebot3_burger").replace('"whirl"', '"go_to"')
    file.write_text(text + "[agent.parameters]\ngoal = 'goal'\n" + place)
    (told,) = (str(fault) for fault in check_content([file]).faults)
    assert "go_to.py" in told
    assert "cruise is 0.5 m/s; the limit of turtlebot3_burger (R2 in slow) is 0.22 m/s." in told


def test_the_published_place_of_the_box_leaves_little_room_at_the_goal():
    shipped = Catalog().shipped
    tight = [str(f) for f in check_content([shipped / "scenarios" / "exp1_published.toml"]).faults]
    assert len(tight) == 1
    assert "the goal 'goal' of R2 is tight: pioneer_p3dx is free at 187 of the 408 poses" in tight[0]
    assert check_content([shipped / "scenarios" / "exp1.toml"]).faults == ()


TABLE = """<mujoco model="table">
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <geom name="table" type="box" size="0.5 0.5 0.25" pos="2 0 0.25"/>
  </worldbody>
</mujoco>
"""

OVER = """format = "scenario/2"
doc = "Fly over a table."
world = "table"
duration = "20 s"
[[place]]
name = "over"
x = "2 m"
y = "0 m"
z = "1.2 m"
tolerance = "0.3 m"
[[agent]]
name = "Q"
robot = "quadrotor"
mission = "go_to"
rules = ["airborne"]
x = "-1 m"
y = "0 m"
success = { goal = "over" }
[agent.parameters]
goal = "over"
"""


@pytest.mark.parametrize(("z", "faults"), [("1.2 m", []), ("0.4 m", ["inside 'table'"])])
def test_a_goal_with_a_height_is_checked_at_this_height_for_bodies_that_fly(project, z, faults):
    (project / "scenarios" / "worlds").mkdir()
    (project / "scenarios" / "worlds" / "table.xml").write_text(TABLE)
    file = project / "scenarios" / "over.toml"
    file.write_text(OVER.replace('z = "1.2 m"', f'z = "{z}"'))
    found = [str(fault) for fault in check_content([file]).faults]
    assert len(found) == len(faults), found
    assert all(words in text for words, text in zip(faults, found, strict=True))
