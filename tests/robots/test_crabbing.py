"""A robot that crabs toward a wall turns away before it is 0.25 m from it, in each of eight directions."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from rocs_bt import run
from rocs_bt.catalog import Catalog
from rocs_bt.event import ListSink, MinClearanceLowered, RuleChanged, SignalsWritten

SPEEDS = {"rosbot_xl": 0.6, "robotino": 0.45}  # [m/s]
LIMIT = 0.25  # [m] minimum gap between hull and wall
TURN = 1.0  # [s] duration of a stop and a turn away, at most

SCENARIO = """format = "scenario/2"
doc = "Crab toward the eastern wall; the heading differs from the direction of motion by {away} deg."
world = "arena"
duration = "6 s"
end_on_collision = false
[rate]
physics = "5 ms"
control = "20 Hz"
plan = "10 Hz"
[[agent]]
name = "R2"
robot = "{robot}"
mission = "go_to"
rules = ["avoid_collision"]
x = "0 m"
y = "0 m"
yaw = "{yaw} deg"
jitter = {{ x = "0.3 m", y = "0.3 m", yaw = "15 deg" }}
"""


def case(robot: str, away: int, seed: int) -> object:
    quick = seed == 1 and (robot == "rosbot_xl" or away in (90, 180))
    return pytest.param(robot, away, seed, marks=() if quick else pytest.mark.soak)


@pytest.mark.parametrize(
    ("robot", "away", "seed"),
    [case(robot, away, seed) for robot in SPEEDS for away in range(0, 360, 45) for seed in range(1, 11)],
)
def test_it_turns_before_it_comes_too_near(tmp_path: Path, robot: str, away: int, seed: int) -> None:
    (tmp_path / "scenarios").mkdir()
    (tmp_path / "scenarios/crab.toml").write_text(SCENARIO.format(robot=robot, away=away, yaw=-away))
    speed, bearing, sink = SPEEDS[robot], math.radians(away), ListSink()
    result = run(
        "crab",
        Catalog(tmp_path),
        seed=seed,
        report=False,
        sinks=[sink],
        missions={
            "R2": lambda mission: mission.act(
                "SetTwist", forward=speed * math.cos(bearing), left=speed * math.sin(bearing)
            )
        },
    )
    fired = next(e for e in sink.events if isinstance(e, RuleChanged) and e.phase == "fired")
    assert fired.rule == "avoid_collision/AvoidCourse"
    before = [
        e for e in sink.events if isinstance(e, SignalsWritten) and e.t <= fired.t and "course_speed" in e.signals
    ]
    assert before[-1].values["course_speed"][0] > 0.95 * speed
    near = [e.distance for e in sink.events if isinstance(e, MinClearanceLowered) and e.t <= fired.t + TURN]
    assert min(near) > LIMIT
    assert result.summary.agents["R2"].collisions == 0
