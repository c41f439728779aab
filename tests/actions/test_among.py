"""FollowRoute among people in physics: the shipped mission `navigate`, and a robot that tracks what moves."""

from __future__ import annotations

import math
import re
import shutil
from pathlib import Path

import pytest

from rocs_bt import run
from rocs_bt.actions.among import Among
from rocs_bt.actions.follow_route import FollowRoute
from rocs_bt.base.errors import InputError
from rocs_bt.catalog import Catalog
from rocs_bt.event import BodyMoved, PathPlanned
from rocs_bt.interfaces.action import make_action
from rocs_bt.record import Recording
from rocs_bt.record.explanation.why import explain

REPO = Path(__file__).parents[2]
PERSON = '<body name="{0}" mocap="true" pos="0 0 0.85"><geom name="{0}" type="cylinder" size="0.25 0.85"/></body>'
WALLS = "".join(
    f'<geom name="wall_{side}" type="box" size="6 0.05 0.5" pos="3 {y} 0.5"/>' for side, y in (("n", 2), ("s", -2))
)
WORLD = '<mujoco><worldbody><geom name="floor" type="plane" size="20 20 0.1"/>{}</worldbody></mujoco>'
SCENARIO = """
format = "scenario/2"
doc = "The robot drives along a hall in which people walk."
world = "hall"
duration = "{} s"
{}
[[place]]
name = "goal"
x = "7 m"
y = "0 m"
tolerance = "0.5 m"
[[agent]]
name = "R"
robot = "{}"
mission = "navigate"
parameters = {{ goal = "goal" }}
rules = ["contact"]
x = "0 m"
y = "0 m"
success = {{ goal = "goal" }}
"""
WALK = """
[[actor]]
name = "{}"
{}
x = "{} m"
y = "{} m"
to_x = "{} m"
to_y = "{} m"
"""
STROLL = 'script = "polynomial"\nspeed = "0.8 m/s"'
DOOR = "".join(
    f'<geom name="jamb_{side}" type="box" size="0.05 0.775 0.5" pos="3 {y} 0.5"/>'
    for side, y in (("n", 1.225), ("s", -1.225))
)


@pytest.fixture
def walked(tmp_path):
    def play(*walks, bodies=WALLS, more="", robot="jackal", script=STROLL, duration=40):
        (tmp_path / "scenarios/worlds").mkdir(parents=True, exist_ok=True)
        names = [f"P{i}" for i in range(len(walks))]
        people = "".join(WALK.format(name, script, *walk) for name, walk in zip(names, walks, strict=True))
        (tmp_path / "scenarios/hall.toml").write_text(SCENARIO.format(duration, more, robot) + people)
        bodies += "".join(PERSON.format(name) for name in names)
        (tmp_path / "scenarios/worlds/hall.xml").write_text(WORLD.format(bodies))
        return run("hall", Catalog(tmp_path), out=tmp_path / "run", report=False).summary.agents["R"]

    return play


def driven(folder):
    return [(e.t, e.x, e.y) for e in Recording.open(folder).events() if isinstance(e, BodyMoved) and e.body == "R"]


@pytest.mark.parametrize(
    "walks",
    [[(3.5, 1.6, 3.5, -1.6)], [(6.5, 0.1, 0.5, 0.1)], [(3.0, 1.6, 3.0, -1.6), (5.0, -1.6, 5.0, 1.6)]],
    ids=["crosses", "oncoming", "two cross"],
)
def test_it_arrives_and_nobody_touches_it(walked, walks) -> None:
    result = walked(*walks)
    assert (result.outcome, result.collisions, result.struck) == ("success", 0, 0), result.reason
    assert not result.faults


def test_it_arrives_at_a_control_rate_at_which_each_period_plans(walked) -> None:
    result = walked((3.5, 1.6, 3.5, -1.6), more='rate = { control = "10 Hz", sensors = "10 Hz" }')
    assert (result.outcome, result.collisions) == ("success", 0), result.reason


def test_the_planned_motions_are_recorded(walked, tmp_path) -> None:
    walked((3.5, 1.6, 3.5, -1.6))
    plans = [e for e in Recording.open(tmp_path / "run").events() if isinstance(e, PathPlanned)]
    near = [e for e in plans if 1.0 < e.t < 3.0]
    assert len(near) > 10
    at = {round(t, 2): (x, y) for t, x, y in driven(tmp_path / "run")}
    for plan in near:
        assert math.dist(plan.points[0], at[round(plan.t, 2)]) < 0.3, "a plan begins at the robot"


def test_why_names_what_moves_around_it_the_nearest_first(walked, tmp_path) -> None:
    walked((3.0, 1.6, 3.0, -1.6), (5.0, -1.6, 5.0, 1.6))
    text = str(explain(Recording.open(tmp_path / "run"), 1.5, "R"))
    (line,) = (line for line in text.splitlines() if line.startswith("around"))
    away = [float(number) for number in re.findall(r"(\S+) m away", line)]
    assert len(away) == 2
    assert away == sorted(away)
    assert re.findall(r"at (\S+) m/s", line)


def test_without_movers_it_drives_as_without_a_tracker(walked, tmp_path) -> None:
    assert walked().outcome == "success"
    tracked = driven(tmp_path / "run")
    untracked = tmp_path / "robots/untracked/robot.toml"
    shutil.copytree(REPO / "robots/jackal", untracked.parent)
    cut, count = re.subn(r'\[\[analyze\]\]\nname = "mover".*?\n\n', "", untracked.read_text(), flags=re.DOTALL)
    assert count == 1
    untracked.write_text(cut)
    assert walked(robot="untracked").outcome == "success"
    assert driven(tmp_path / "run") == tracked


@pytest.mark.parametrize("gone", [2.5, 6.0])
def test_after_a_wait_among_movers_it_drives_on(walked, monkeypatch, gone) -> None:
    monkeypatch.setattr(Among, "near", lambda self, _: self._body.clock.now() < gone)
    monkeypatch.setattr(Among, "step", lambda self, *_: self._drive.brake())
    result = walked()
    assert result.actions == {"FollowRoute": {"SUCCEEDED": 1}}
    assert gone < result.time_to_goal < gone + 7.0


def test_it_waits_for_one_that_stays_in_the_door(walked) -> None:
    stays = 'script = "slide"\ndepart_at = "0.3 s"\nduration = "1.5 s"'
    result = walked((4.5, 0.8, 3.0, 0.0), script=stays, bodies=WALLS + DOOR, duration=9)
    assert "FAILED" not in result.actions["FollowRoute"]
    assert (result.collisions, result.struck) == (0, 0)


@pytest.mark.parametrize("side", ["rigth", ""])
def test_an_unknown_side_is_refused(side) -> None:
    route = {"points": [[0.0, 0.0], [1.0, 0.0]], "goal": "goal"}
    with pytest.raises(InputError, match="pass_on must be right, left or either, found"):
        make_action({"FollowRoute": FollowRoute}, "FollowRoute", {**route, "pass_on": side})
