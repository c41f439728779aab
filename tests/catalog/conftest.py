"""A small project with one of each kind, without any simulation."""

from __future__ import annotations

from pathlib import Path

import pytest

ROBOT = """\
format = "robot/3"
doc = "A bot."
model = "robot.xml"

[locomotion]
kind = "differential"
wheel_separation = "33.1 cm"
max_wheel_speed = "1.2 m/s"
max_wheel_acceleration = "1.5 m/s2"

[body]
length = "0.4 m"
width = "40 cm"

[[sensor]]
name = "sonar"
driver = "range_cone"
sites = ["sonar0", "sonar1"]
half_angle = "15 deg"
rays = 5
range = ["0.1 m", "1.0 m"]
rate = "20 Hz"
noise = "2 cm"
unit = "m"
monitor = "range"

[[sensor]]
name = "position"
driver = "position"
monitor = "PoseMonitor"
unit = "m"

[[monitor]]
name = "range"
class = "RangeMonitor"
[monitor.group.front]
beams = [0, 1]
weights = [0.5, 1.0]

[[analyze]]
name = "obstacle"
class = "PassRange"
monitors = ["range", "position"]

[[actuator]]
name = "wheels"
driver = "velocity"
motors = ["left", "right"]
range = ["-1.2 m/s", "1.2 m/s"]
wheel_radius = "9.75 cm"
"""

SCENARIO = """\
format = "scenario/2"
doc = "A walk."
world = "room"
duration = "20 s"

[rate]
plan = "5 Hz"

[[place]]
name = "dock"
x = "0 m"
y = "-10 cm"
tolerance = "5 cm"
agents = ["R1"]

[[agent]]
name = "R1"
robot = "bot"
mission = "go"
rules = ["calm"]
x = "1 m"
y = "2 m"
yaw = "180 deg"
jitter = { x = "5 cm", yaw = "10 deg" }
success = { goal = "dock" }
[agent.parameters]
goal = "dock"
cruise = "0.5 m/s"

[[actor]]
name = "R2"
robot = "bot"
script = "random_walk"
x = "-1 m"
y = "-1 m"
max_speed = "0.3 m/s"
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    root = tmp_path / "project"
    files = {
        "robots/bot/robot.toml": ROBOT,
        "robots/bot/robot.xml": "<mujoco/>",
        "scenarios/walk.toml": SCENARIO,
        "scenarios/worlds/room.xml": "<!-- A room.\nIts second line. --><mujoco/>",
        "planners/missions/go.py": '"""Go there.\n\nAt once.\n"""\n\n\ndef build():\n    return 1\n',
        "rules/calm.toml": 'doc = "Stay calm."\n',
    }
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    return root
