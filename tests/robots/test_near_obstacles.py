"""Scanners of robots with legs: an obstacle has a range at any distance, down to its contact with the robot."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.event import NullSink
from rocs_bt.simulation import build_world

RADIUS = 0.05  # [m] of the post
MINIMUM = 0.05  # [m] range of the scanners
WORLD = f"""<mujoco><worldbody>
  <geom name="floor" type="plane" size="9 9 1"/>
  <body name="post" mocap="true" pos="3 0 0.6"><geom type="cylinder" size="{RADIUS} 0.6"/></body>
</worldbody></mujoco>"""
SCENARIO = """
format = "scenario/2"
world = "field"
duration = "9 s"
[[agent]]
name = "R"
robot = "{robot}"
mission = "go_to"
x = "0 m"
y = "0 m"
"""


@pytest.mark.parametrize("bearing", [0, 25, 50, 90, 130, 180, 250, 310])
@pytest.mark.parametrize("robot", ["humanoid", "quadruped"])
def test_the_range_of_a_post_decreases_until_it_touches(tmp_path: Path, robot: str, bearing: int) -> None:
    for name, text in {"worlds/field.xml": WORLD, "post.toml": SCENARIO.format(robot=robot)}.items():
        file = tmp_path / "scenarios" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    catalog = Catalog(tmp_path)
    simulated = build_world(catalog.load_scenario("post"), catalog, 1, NullSink())
    world, lidar = simulated.world, simulated.sensors["R"]["lidar"]
    world.advance(40)
    c, s = math.cos(math.radians(bearing)), math.sin(math.radians(bearing))
    distance, before = 0.8, math.inf
    while not world.contacts():
        world.data.mocap_pos[0, :2] = distance * c, distance * s
        world.advance(10)
        nearest = min(lidar.read().values)
        assert MINIMUM <= nearest < distance - RADIUS + 0.06, f"{distance:.2f} m"
        assert nearest < before + 0.05, f"{distance:.2f} m"  # five times the noise
        distance, before = distance - 0.01, nearest
    assert distance > 0.1, "it touches"
