"""`base`: a file says what differs from another, and nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.catalog import Catalog, content_hash
from rocs_bt.declare import replaced

from ..changes import edit

ROBOT = """\
format = "robot/3"
base = "bot"
doc = "A bot that differs."

[locomotion]
wheel_separation = "40 cm"

[[sensor]]
name = "sonar"
rays = 3

[[sensor]]
name = "heading"
driver = "orientation"
monitor = "range"

[[actuator]]
name = "wheels"
max_command_age = "0.4 s"
"""

SCENARIO = """\
format = "scenario/2"
base = "walk"
doc = "Another walk."

[rate]
plan = "10 Hz"

[[agent]]
name = "R1"
robot = "other"
[agent.parameters]
cruise = "0.3 m/s"

[[agent]]
name = "R3"
robot = "bot"
mission = "go"
x = "3 m"
y = "3 m"
"""


@pytest.fixture
def based(project: Path) -> Path:
    for name, text in (("robots/other/robot.toml", ROBOT), ("scenarios/walk_on.toml", SCENARIO)):
        (project / name).parent.mkdir(exist_ok=True)
        (project / name).write_text(text)
    return project


def test_a_robot_is_its_base_but_for_what_it_says(based: Path) -> None:
    bot, other = (Catalog(based).load_robot(name) for name in ("bot", "other"))
    assert (other.name, other.doc) == ("other", "A bot that differs.")
    assert other.motion == replaced(bot.motion, wheel_separation=0.4)
    assert [s.name for s in other.sensors] == [*(s.name for s in bot.sensors), "heading"]
    assert other.sensors[0].parameters == replaced(bot.sensors[0].parameters, rays=3)
    assert other.monitors[0].parameters == bot.monitors[0].parameters
    assert [(a.name, a.max_command_age) for a in other.actuators] == [("wheels", 0.4)]
    assert other.model == bot.model
    assert other.bases == (bot.file,)


def test_a_scenario_is_its_base_but_for_what_it_says(based: Path) -> None:
    walk, on = (Catalog(based).load_scenario(name) for name in ("walk", "walk_on"))
    assert (on.name, on.duration, on.world) == ("walk_on", walk.duration, walk.world)
    assert on.rate.plan == 10.0
    assert [(a.name, a.robot) for a in on.agents] == [("R1", "other"), ("R3", "bot")]
    assert on.agents[0].parameters == {"goal": "dock", "cruise": "0.3 m/s"}
    assert on.agents[0].pose == walk.agents[0].pose
    assert on.actors[0].pose == walk.actors[0].pose
    assert on.bases == (walk.file,)


def test_who_is_given_another_mission_does_not_inherit_the_parameters_of_the_one_it_had(based: Path) -> None:
    file = based / "scenarios" / "walk_on.toml"
    edit(file, 'robot = "other"\n[agent.parameters]', 'robot = "other"\nmission = "stay"\n[agent.parameters]')
    (based / "planners" / "missions" / "stay.py").write_text((based / "planners" / "missions" / "go.py").read_text())
    assert Catalog(based).load_scenario("walk_on").agents[0].parameters == {"cruise": "0.3 m/s"}
    edit(file, '[agent.parameters]\ncruise = "0.3 m/s"\n', "")
    assert Catalog(based).load_scenario("walk_on").agents[0].parameters == {}


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("scenarios/walk.toml", 'x = "-1 m"', 'x = "-2 m"'),
        ("robots/bot/robot.xml", "<mujoco/>", "<mujoco></mujoco>"),
        ("robots/other/robot.toml", "40 cm", "41 cm"),
    ],
)
def test_the_hash_of_its_content_covers_what_it_is_based_on(based: Path, file: str, old: str, new: str) -> None:
    def digest() -> str:
        catalog = Catalog(based)
        return content_hash(catalog.content_of(catalog.load_scenario("walk_on")))

    before = digest()
    edit(based / file, old, new)
    assert digest() != before


def test_faults_stand_at_their_own_lines_and_those_of_the_base_at_base(based: Path) -> None:
    file = based / "robots/other/robot.toml"
    edit(file, "rays = 3", "rays = 0\nwings = 2")
    with pytest.raises(InputError) as caught:
        Catalog(based).load_robot("other")
    assert {(f.file, f.line) for f in caught.value.faults} == {(file, 10), (file, 11)}
    edit(file, "rays = 0\nwings = 2", "rays = 3")
    edit(based / "robots/bot/robot.toml", 'monitor = "PoseMonitor"', 'monitor = "PoseMonitr"')
    with pytest.raises(InputError, match="no monitor is named 'PoseMonitr'") as caught:
        Catalog(based).load_robot("other")
    assert {(f.file, f.line) for f in caught.value.faults} == {(file, 2)}


def test_a_file_of_the_base_is_found_beside_the_base(based: Path) -> None:
    edit(based / "robots/bot/robot.toml", 'monitor = "PoseMonitor"', 'monitor = "own.py:Mine"')
    (based / "robots/bot/own.py").write_text("class Mine:\n    pass\n")
    other = Catalog(based).load_robot("other")
    assert other.code == (based / "robots/bot/own.py",)
    (based / "robots/other/own.py").write_text("class Mine:\n    pass\n")
    assert Catalog(based).load_robot("other").code == (based / "robots/other/own.py",), "its own come first"


def test_a_chain_of_bases_and_a_shipped_one(based: Path) -> None:
    for name, base in (("third", "other"), ("own_p3dx", "pioneer_p3dx")):
        (based / f"robots/{name}").mkdir()
        (based / f"robots/{name}/robot.toml").write_text(f'format = "robot/3"\nbase = "{base}"\n')
    catalog = Catalog(based)
    third = catalog.load_robot("third")
    assert [file.parent.name for file in third.bases] == ["other", "bot"]
    assert third.motion.wheel_separation == pytest.approx(0.4)
    own = catalog.load_robot("own_p3dx").sensors
    assert own == catalog.load_robot("pioneer_p3dx").sensors
    assert {sensor.line for sensor in own} == {2}


@pytest.mark.parametrize(
    ("base", "message", "where"),
    [
        ("bott", "no robot is named 'bott'.*Did you mean 'bot'", "other"),
        ("other", "is itself based on this file", "other"),
        ("ring", "is itself based on this file", "ring"),
    ],
)
def test_a_base_that_cannot_be_is_told_at_its_line(based: Path, base: str, message: str, where: str) -> None:
    (based / "robots/ring").mkdir()
    (based / "robots/ring/robot.toml").write_text('format = "robot/3"\nbase = "other"\n')
    edit(based / "robots/other/robot.toml", 'base = "bot"', f'base = "{base}"')
    with pytest.raises(InputError, match=message) as caught:
        Catalog(based).load_robot("other")
    assert caught.value.faults[0].file == based / f"robots/{where}/robot.toml"
    assert caught.value.faults[0].line == 2
