"""Reflexes of airborne.toml on the quadrotor: over a wall, before a roof, down on low battery, still when blind."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

import rocs_bt
from rocs_bt.catalog import Catalog
from rocs_bt.event import BodyMoved, ListSink, RuleChanged
from rocs_bt.simulation import RunResult, SimulatedWorld
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
mission = "go_to"
rules = {rules}
x = "0 m"
y = "0 m"
success = {{ goal = "goal" }}
[agent.parameters]
goal = "goal"
cruise = "0.8 m/s"
"""


class Flight:
    """One run: its result, positions, and the rules that fired."""

    def __init__(
        self,
        project: Path,
        geoms: str = "",
        *,
        rules: bool = True,
        charge: float = 1.0,
        duration: float = 15.0,
        prepare: Callable[[SimulatedWorld], None] | None = None,
    ) -> None:
        files = {
            "scenarios/worlds/field.xml": '<mujoco><worldbody><geom name="floor" type="plane" size="9 9 1"/>'
            f"{geoms}</worldbody></mujoco>",
            "robots/drone/robot.toml": ROBOT.format(charge=charge),
            "scenarios/fly.toml": SCENARIO.format(duration=duration, rules='["airborne"]' if rules else "[]"),
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


@pytest.mark.parametrize("sensor", ["ring", "vertical", "height"])
def test_a_lost_sensor_makes_it_hover_and_then_land(tmp_path: Path, sensor: str) -> None:
    found = Flight(tmp_path, duration=11.0, prepare=lambda world: break_sensor(world, sensor, DeadSensor, at=2.5))
    assert found.fired == {"Blind"}
    hover = [e for e in found.moves if 5.0 < e.t < 7.0]
    assert max(abs(e.x - hover[0].x) for e in hover) < 0.02
    assert all(e.height == pytest.approx(0.4, abs=0.03) for e in hover)
    assert found.moves[-1].height == pytest.approx(0.1, abs=0.005)
