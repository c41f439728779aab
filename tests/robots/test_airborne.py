"""Reflexes of airborne.toml on the quadrotor: over a wall, before a roof, down on low battery, still when blind."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

import rocs_bt
from rocs_bt.catalog import Catalog
from rocs_bt.event import BodyMoved, ListSink, RuleChanged
from rocs_bt.running import RunResult
from rocs_bt.simulation import SimulatedWorld
from rocs_bt.testing.faults import DeadSensor, break_sensor

WALL = '<geom name="wall" type="box" size="0.15 3 0.4" pos="1.5 0 0.4"/>'
ROOF = '<geom name="roof" type="box" size="2 3 0.02" pos="0.5 0 0.8"/>'

ROBOT = """format = "robot/3"
base = "quadrotor"
doc = "Quadrotor with changes of one sensor."

[[sensor]]
name = "battery"
charge = {charge}
"""

SCENARIO = """format = "scenario/2"
world = "field"
duration = "{duration} s"
[[place]]
name = "goal"
kind = "goal"
x = "3 m"
y = "0 m"
tolerance = "0.1 m"
[[agent]]
name = "D"
robot = "drone"
mission = "{mission}"
rules = {rules}
x = "0 m"
y = "0 m"
success = {{ goal = "goal" }}
[agent.parameters]
goal = "goal"
cruise = "0.8 m/s"
"""


MISSION = """
from math import inf

from py_trees.composites import Sequence
from rocs_bt.plan import Mission
from rocs_bt.base.units import Metres, PositiveMetresPerSecond, PositiveSeconds


def build(
    mission: Mission,
    *,
    goal: str,
    cruise: PositiveMetresPerSecond,
    rise: PositiveSeconds = 1.0,
    height: Metres = inf,
    hover: bool = False,
):
    go = mission.act("SetTwist", turn=0.001, duration=20.0) if hover else mission.act("GoTo", goal=goal, height=height)
    return Sequence("fly", memory=True, children=[mission.act("SetTwist", up=0.4, duration=rise), go])
"""
"""Climbs at 0.4 m/s, then goes to the goal at a height, or hovers."""


class Flight:
    """One run: its result, positions, and the rules that fired."""

    def __init__(
        self,
        project: Path,
        geoms: str = "",
        *,
        rules: bool = True,
        charge: float = 1.0,
        mission: str = "go_to",
        parameters: str = "",
        actors: str = "",
        duration: float = 15.0,
        prepare: Callable[[SimulatedWorld], None] | None = None,
    ) -> None:
        files = {
            "scenarios/worlds/field.xml": '<mujoco><worldbody><geom name="floor" type="plane" size="9 9 1"/>'
            f"{geoms}</worldbody></mujoco>",
            "robots/drone/robot.toml": ROBOT.format(charge=charge),
            "planners/missions/rise.py": MISSION,
            "scenarios/fly.toml": SCENARIO.format(
                duration=duration, rules='["airborne"]' if rules else "[]", mission=mission
            )
            + parameters
            + actors,
        }
        for name, text in files.items():
            (project / name).parent.mkdir(parents=True, exist_ok=True)
            (project / name).write_text(text, encoding="utf-8")
        sink = ListSink()
        self.result: RunResult = rocs_bt.run(
            "fly", Catalog(project), seed=1, sinks=[sink], report=False, prepare=prepare
        )
        self.agent = self.result.summary.agents["D"]
        self.moves = [e for e in sink.events if isinstance(e, BodyMoved)]
        self.fired = {
            e.rule.rpartition("/")[2] for e in sink.events if isinstance(e, RuleChanged) and e.phase == "fired"
        }


def test_it_climbs_over_a_wall_that_it_hits_without_the_rules(tmp_path: Path) -> None:
    found = Flight(tmp_path / "with", WALL)
    assert (found.agent.outcome, found.agent.collisions) == ("success", 0)
    assert found.fired == {"Climb"}
    assert max(e.height for e in found.moves) > 0.9
    blind = Flight(tmp_path / "without", WALL, rules=False)
    assert blind.agent.outcome == "collision"


def test_it_stops_before_a_wall_under_a_roof(tmp_path: Path) -> None:
    found = Flight(tmp_path, WALL + ROOF, duration=10.0)
    assert found.agent.collisions == 0
    assert "Halt" in found.fired
    assert max(e.x for e in found.moves) < 1.35 - 0.338 - 0.05


def test_low_battery_lands(tmp_path: Path) -> None:
    found = Flight(tmp_path, charge=0.152, duration=9.0)
    assert found.fired == {"Land"}
    assert max(e.height for e in found.moves) > 0.35
    assert found.moves[-1].height == pytest.approx(0.1, abs=0.005)
    assert found.agent.collisions == 0


@pytest.mark.parametrize("sensor", ["ring", "vertical", "height", "twist"])
def test_a_lost_sensor_makes_it_hover_and_then_land(tmp_path: Path, sensor: str) -> None:
    found = Flight(tmp_path, duration=11.0, prepare=lambda world: break_sensor(world, sensor, DeadSensor, at=2.5))
    assert found.fired == {"Blind"}
    hover = [e for e in found.moves if 5.0 < e.t < 7.0]
    assert max(abs(e.x - hover[0].x) for e in hover) < 0.02
    assert all(e.height == pytest.approx(0.4, abs=0.03) for e in hover)
    assert found.moves[-1].height == pytest.approx(0.1, abs=0.005)


@pytest.mark.parametrize(
    ("low", "high"),
    [(0.0, 0.34), (0.31, 0.33), (0.38, 0.5), (0.4, 0.44), (0.48, 0.6)],
    ids=str,
)
def test_it_does_not_touch_a_bar_at_any_height_of_its_body(tmp_path: Path, low: float, high: float) -> None:
    bar = f'<geom name="bar" type="box" size="0.05 3 {0.5 * (high - low)}" pos="1.6 0 {0.5 * (high + low)}"/>'
    found = Flight(tmp_path, bar)
    assert found.agent.collisions == 0
    assert found.fired & {"Climb", "Halt"}


def test_it_stops_its_take_off_under_a_roof(tmp_path: Path) -> None:
    found = Flight(tmp_path, '<geom name="roof" type="box" size="2 2 0.02" pos="0 0 0.42"/>', duration=6.0)
    assert found.agent.collisions == 0
    assert "StopClimb" in found.fired


def test_it_stops_a_climb_under_a_roof(tmp_path: Path) -> None:
    roof = '<geom name="roof" type="box" size="2 2 0.02" pos="0 0 1.5"/>'
    found = Flight(tmp_path, roof, mission="rise", parameters='rise = "9 s"\nhover = true\n', duration=8.0)
    assert found.agent.collisions == 0
    assert found.fired == {"StopClimb"}
    assert max(e.height for e in found.moves) > 1.2


def test_a_height_beyond_a_roof_is_not_reached(tmp_path: Path) -> None:
    """The action keeps its distance by the ranges alone, without the rules."""
    roof = '<geom name="roof" type="box" size="4 4 0.02" pos="1 0 1.6"/>'
    found = Flight(tmp_path, roof, rules=False, mission="rise", parameters='height = "2 m"\n', duration=10.0)
    assert found.agent.collisions == 0
    assert found.moves[-1].x == pytest.approx(3.0, abs=0.1)
    assert 1.3 < max(e.height for e in found.moves) < 1.45


def test_it_descends_behind_what_it_flies_over(tmp_path: Path) -> None:
    """Also by the ranges alone."""
    table = '<geom name="table" type="box" size="0.5 0.6 0.02" pos="1 0 0.6"/>'
    found = Flight(
        tmp_path, table, rules=False, mission="rise", parameters='rise = "2.5 s"\nheight = "0.4 m"\n', duration=15.0
    )
    assert (found.agent.outcome, found.agent.collisions) == ("success", 0)
    assert min(e.height for e in found.moves if 0.3 < e.x < 1.8) > 0.7
    assert found.moves[-1].height == pytest.approx(0.4, abs=0.1)


@pytest.mark.parametrize("bearing", [0, 45, 90, 101, 107, 112, 118, 135, 180, -112])
def test_it_evades_a_post_that_comes_from_any_side(tmp_path: Path, bearing: float) -> None:
    c, s = math.cos(math.radians(bearing)), math.sin(math.radians(bearing))
    post = '<body name="post" mocap="true" pos="0 0 0.5"><geom type="cylinder" size="0.05 0.5"/></body>'
    slide = f"""
[[actor]]
name = "post"
script = "slide"
x = "{1.2 * c} m"
y = "{1.2 * s} m"
to_x = "{0.2 * c} m"
to_y = "{0.2 * s} m"
depart_at = "2 s"
duration = "6.7 s"
"""
    found = Flight(tmp_path, post, mission="rise", parameters="hover = true\n", actors=slide, duration=10.0)
    assert found.agent.collisions == 0
    assert found.fired & {"BackOff", "DriftLeft", "DriftRight"}
