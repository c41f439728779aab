"""A mission of Nav2's default shape in a flat of four rooms: through the doors, before a shut one, to a closed room."""

import json

import pytest

from rocs_bt.event import NodeTicked
from rocs_bt.record import Recording

from .nav2_mission import mission

WORLD = """<mujoco model="flat">
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <geom name="west" type="box" size="0.05 3 0.5" pos="-4 0 0.5"/>
    <geom name="east" type="box" size="0.05 3 0.5" pos="4 0 0.5"/>
    <geom name="south" type="box" size="4 0.05 0.5" pos="0 -3 0.5"/>
    <geom name="north" type="box" size="4 0.05 0.5" pos="0 3 0.5"/>
    <geom name="across_1" type="box" size="0.05 0.45 0.5" pos="0 -2.55 0.5"/>
    <geom name="across_2" type="box" size="0.05 0.9 0.5" pos="0 0 0.5"/>
    <geom name="across_3" type="box" size="0.05 0.45 0.5" pos="0 2.55 0.5"/>
    <geom name="along_1" type="box" size="2.7 0.05 0.5" pos="-1.3 0 0.5"/>
    <geom name="along_2" type="box" size="0.7 0.05 0.5" pos="3.3 0 0.5"/>
    <body name="first_door" mocap="true" pos="0 0 0"><geom type="box" size="0.03 0.6 0.48" pos="0 0 0.5"/></body>
    <body name="second_door" mocap="true" pos="0 0 0"><geom type="box" size="0.6 0.03 0.48" pos="0 0 0.5"/></body>
  </worldbody>
</mujoco>
"""
"""Rooms south-west (start), south-east, north-east (goal) and north-west, with a doorway from each to the next."""

SCENARIO = """format = "scenario/2"
world = "flat"
duration = "150 s"
end_on_collision = false
nodes = "nav2:jazzy"

[[place]]
name = "goal"
kind = "goal"
x = "2.5 m"
y = "1.8 m"
tolerance = "0.3 m"
agents = ["R2"]

[[agent]]
name = "R2"
robot = "{robot}"
mission = "navigate_here"
rules = ["contact"]
x = "-2 m"
y = "-1.5 m"
yaw = "0 deg"
success = {{ goal = "goal" }}
[agent.parameters]
goal = "goal"
{doors}"""

DOOR = """
[[actor]]
name = "{name}"
script = "slide"
x = "{x}"
y = "{y}"
to_x = "{to_x}"
to_y = "{to_y}"
{times}
duration = "0.5 s"
"""


def first_door(times):
    return DOOR.format(name="first_door", x="0 m", y="0 m", to_x="0 m", to_y="-1.5 m", times=times)


def second_door(times):
    return DOOR.format(name="second_door", x="0.7 m", y="0 m", to_x="2 m", to_y="0 m", times=times)


@pytest.fixture
def flat(rocs_bt, tmp_path):
    def play(robot, doors=""):
        for folder in ("planners/missions", "scenarios/worlds"):
            (tmp_path / folder).mkdir(parents=True)
        (tmp_path / "scenarios/worlds/flat.xml").write_text(WORLD)
        (tmp_path / "planners/missions/navigate_here.xml").write_text(mission(spin=1.57, wait=5.0, back_up=0.3))
        text = SCENARIO.format(robot=robot, doors=doors)
        (tmp_path / "scenarios/flat.toml").write_text(text)
        ran = rocs_bt("run", "flat", "--no-report", "--out", tmp_path / "out")
        (agent,) = json.loads((tmp_path / "out/summary.json").read_text())["agents"].values()
        events = [e for e in Recording.open(tmp_path / "out").events() if isinstance(e, NodeTicked)]
        return ran, agent, events

    return play


def recoveries(events):
    """Recoveries that succeeded, in order, each with its time."""
    ended = [e for e in events if e.status == "SUCCESS" and "in turn/" in e.node]
    children = [(e.t, e.node.rpartition("in turn/")[2]) for e in ended]
    return [(t, name) for t, name in children if "/" not in name]


@pytest.mark.parametrize("robot", ["jackal", "turtlebot3_burger"])
def test_it_drives_through_the_doors(flat, robot):
    ran, agent, _ = flat(robot)
    assert (ran.code, agent["outcome"], agent["collisions"]) == (0, "success", 0), ran.text


SLOW = pytest.param("turtlebot3_burger", 18, 30, marks=pytest.mark.soak)


@pytest.mark.parametrize(("robot", "shuts", "opens"), [("jackal", 7, 17), SLOW])
def test_it_recovers_before_a_shut_door_and_drives_on_when_it_opens(flat, robot, shuts, opens):
    ran, agent, events = flat(robot, second_door(f'depart_at = "{shuts} s"\nreturn_at = "{opens} s"'))
    assert (ran.code, agent["outcome"], agent["collisions"]) == (0, "success", 0), ran.text
    found = recoveries(events)
    assert [name for _, name in found[:2]] == ["clear", "Spin"]
    assert all(shuts < t < opens + 5.5 for t, _ in found), found
    assert agent["time_to_goal"] > opens


@pytest.mark.parametrize("robot", ["jackal", pytest.param("turtlebot3_burger", marks=pytest.mark.soak)])
def test_it_fails_after_its_recoveries_if_the_goal_cannot_be_reached(flat, rocs_bt, robot, tmp_path):
    ran, agent, events = flat(robot, first_door('depart_at = "0 s"'))
    assert (ran.code, agent["outcome"], agent["collisions"]) == (1, "failed", 0), ran.text
    assert [name for _, name in recoveries(events)[:4]] == ["clear", "Spin", "Wait", "BackUp"]
    why = "ComputePathToPose: BLOCKED: the map contains no path to the goal"
    assert why in agent["reason"]
    moment = ran.text.split("--why ")[1].split()[0]
    assert why in rocs_bt("replay", tmp_path / "out", "--why", moment).text
