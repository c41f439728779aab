"""A goal cannot be reached because of a reflex only if the reflex fires there, however the robot came."""

from __future__ import annotations

from pathlib import Path

import pytest

from rocs_bt.check import check_content, feasible
from rocs_bt.expression.absent import absent_name

SCENARIO = """format = "scenario/2"
doc = "Drive to a goal."
world = "arena_box"
duration = "30 s"
[[agent]]
name = "R1"
robot = "{robot}"
mission = "go_to"
rules = [{rules}]
x = "1.5 m"
y = "0 m"
parameters = {{ goal = "goal" }}
[[place]]
name = "goal"
x = "-1.5 m"
y = "0 m"
tolerance = "0.1 m"
"""
RULE = """format = "reflex/1"
[rule.Halt]
when = "{when}"
until = "speed > 1 m/s"
priority = 10
for = "{hold}"
on_invalid = "{policy}"
[rule.Halt.action]
name = "Stop"
"""


def unreachable(folder: Path, robot: str, rules: str) -> list[str]:
    (folder / "scenarios").mkdir(exist_ok=True)
    file = folder / "scenarios" / "goal.toml"
    file.write_text(SCENARIO.format(robot=robot, rules=rules))
    return [str(f) for f in check_content([file]).faults if "cannot be reached" in f.message]


@pytest.mark.parametrize("robot", ["jackal", "pioneer_p3dx_tracking"])
@pytest.mark.parametrize("rules", ['"contact"', '"avoid_collision"', '"contact", "avoid_collision"'])
def test_shipped_rules_make_no_free_goal_unreachable(tmp_path, robot, rules):
    assert unreachable(tmp_path, robot, rules) == []


@pytest.mark.parametrize(
    ("when", "hold", "policy", "fires"),
    [
        ("min(front) < 90 m", "0 s", "clear", True),
        ("min(front) < 90 m or contact_time < 1 s", "0.1 s", "trip", True),
        ("min(front) < 90 m or held(speed > 1 m/s, 1 s)", "0 s", "clear", True),
        ("min(front) < stop_distance + 90 m", "0 s", "clear", True),
        ("contact_time < 0.1 s", "0 s", "trip", False),  # no Analyze block runs here, so it is invalid
        ("rate(min(front), 0.5 s) < -9 m/s", "0 s", "trip", False),  # not yet valid at the first sample
        ("not held(min(front) > 0.1 m, 1 s)", "0 s", "clear", False),  # true only at the first sample
        ("held(min(front) < 90 m, 1 s)", "0 s", "clear", False),  # the robot is there before
        ("time_since(min(front) < 0.1 m) > 1 s", "0 s", "clear", False),  # it depends on the way
        ("min(front) < 90 m and speed < 0.1 m/s", "0 s", "clear", False),  # the robot comes faster
        ("min(front) < 90 m", "5 s", "clear", False),
    ],
)
def test_a_reflex_makes_a_goal_unreachable_only_by_the_position(tmp_path, when, hold, policy, fires):
    (tmp_path / "rules").mkdir()
    (tmp_path / "rules" / "own.toml").write_text(RULE.format(when=when, hold=hold, policy=policy))
    assert bool(unreachable(tmp_path, "jackal", '"own"')) is fires


DOOR = """<mujoco><worldbody>
<geom name="floor" type="plane" size="5 5 0.1"/>
<body name="door" mocap="true" pos="-1.5 0 0.5"><geom type="box" size="0.5 0.5 0.5"/></body>
</worldbody></mujoco>
"""


def test_an_object_that_moves_need_not_stay_at_the_goal(tmp_path):
    (tmp_path / "scenarios" / "worlds").mkdir(parents=True)
    (tmp_path / "scenarios" / "worlds" / "yard.xml").write_text(DOOR)
    file = tmp_path / "scenarios" / "goal.toml"
    text = SCENARIO.format(robot="jackal", rules="").replace("arena_box", "yard")
    file.write_text(text)
    assert any("inside 'door'" in f.message for f in check_content([file]).faults)
    actor = '[[actor]]\nname = "door"\nscript = "slide"\nx = "-1.5 m"\ny = "0 m"\n'
    file.write_text(text + actor + 'to_x = "-1.5 m"\nto_y = "3 m"\ndepart_at = "2 s"\nduration = "5 s"\n')
    faults = [str(f) for f in check_content([file]).faults]
    assert faults == []


def test_of_many_goals_only_some_are_checked_in_every_respect(tmp_path, monkeypatch):
    monkeypatch.setattr(feasible, "_MANY", 2)
    (tmp_path / "scenarios").mkdir()
    file, tried = tmp_path / "scenarios" / "goal.toml", []
    searched = feasible.free_goal_poses

    def counted(*args, **options):
        return (tried.append(pose) or pose for pose in searched(*args, **options))

    monkeypatch.setattr(feasible, "free_goal_poses", counted)
    text = SCENARIO.format(robot="jackal", rules='"contact"').replace("arena_box", "plane")
    places = [f'[[place]]\nname = "p{i}"\nx = "{0.1 * i} m"\ny = "0 m"\ntolerance = "0.1 m"\n' for i in range(20)]
    file.write_text(text + "".join(places))
    (note,) = check_content([file]).faults
    assert note.note
    assert "of 19 goals of R1, only their first free pose was searched" in note.message
    assert len(tried) == 2 * feasible.POSES_TRIED + 19


@pytest.mark.parametrize(("bad", "good", "further"), [(1, 2, 0), (2, 0, 0), (2, 1, 1), (3, 0, 1), (5, 1, 4)])
def test_after_some_faulty_goals_the_others_are_not_checked(tmp_path, monkeypatch, bad, good, further):
    monkeypatch.setattr(feasible, "_MANY", 2)
    (tmp_path / "scenarios").mkdir()
    file = tmp_path / "scenarios" / "goal.toml"
    text = SCENARIO.format(robot="jackal", rules='"contact"').split("[[place]]")[0]
    places = [
        f'[[place]]\nname = "p{i}"\nx = "{x} m"\ny = "0 m"\ntolerance = "0.1 m"\n'
        for i, x in enumerate([2.5] * bad + [-1.5] * good)
    ]
    file.write_text(text.replace('"goal"', '"p0"') + "".join(places))
    said = [fault.message for fault in check_content([file]).faults]
    assert len([each for each in said if "no free pose within" in each]) == min(bad, 2), said
    assert [each for each in said if "further" in each] == [
        f"{further} further goals of R1 were not checked." for _ in range(bool(further))
    ]


def test_a_goal_in_a_door_and_slow_sensors_are_warned_of(tmp_path):
    (tmp_path / "scenarios" / "worlds").mkdir(parents=True)
    (tmp_path / "scenarios" / "worlds" / "yard.xml").write_text(DOOR)
    file = tmp_path / "scenarios" / "goal.toml"
    text = SCENARIO.format(robot="jackal", rules="").replace("arena_box", "yard")
    file.write_text(text + '[rate]\nsensors = "2 Hz"\n')
    found = [str(fault) for fault in check_content([file]).warnings]
    assert len(found) == 2
    assert any("inside 'door'" in fault for fault in found)
    assert any("at 2 Hz, jackal drives up to 1 m from one reading of its sensors to the next" in text for text in found)


@pytest.mark.parametrize("signal", ["collision_time", "predicted_clearance"])
def test_a_robot_without_a_tracker_is_told_to_add_one(signal):
    assert "add a TrackObjects" in absent_name(signal, ["speed"]).hint


def test_a_robot_without_a_map_is_told_to_add_one_once_for_each_file(tmp_path):
    (tmp_path / "scenarios").mkdir()
    file = tmp_path / "scenarios" / "goal.toml"
    file.write_text(SCENARIO.format(robot="pioneer_p3dx", rules='"contact"'))
    (fault,) = (f for f in check_content([file]).faults if "named 'contact_time'" in f.message)
    assert "no signal or alias is named 'contact_time'" in fault.message
    assert "add a LocalMap" in fault.hint
