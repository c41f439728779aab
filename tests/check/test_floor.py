"""A floor of another friction than that on which a robot was identified."""

from __future__ import annotations

from pathlib import Path

import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.check import check_content


@pytest.mark.parametrize(
    ("robot", "floor", "friction"),
    [
        ("pioneer_p3dx", 'friction="2"', 2),
        ("pioneer_p3dx", 'friction="0.5"', None),  # MuJoCo takes the greater one
        ("pioneer_p3dx", 'friction="0.1" priority="2"', 0.1),
        ("jackal", 'friction="2"', None),  # its wheels have priority
        ("jackal", 'friction="0.1" priority="2"', 0.1),
    ],
)
def test_a_robot_is_not_identified_on_a_floor_of_another_friction(tmp_path, robot, floor, friction):
    (tmp_path / "scenarios/worlds").mkdir(parents=True)
    world = Path(str(Catalog().find("world", "plane").path)).read_text()
    assert '<geom name="floor"' in world
    (tmp_path / "scenarios/worlds/ice.xml").write_text(
        world.replace('<geom name="floor"', f'<geom name="floor" {floor}')
    )
    scenario = f'format = "scenario/2"\nworld = "ice"\n[[agent]]\nname = "R1"\nrobot = "{robot}"\nmission = "go_to"\n'
    file = tmp_path / "scenarios/own.toml"
    goal = '[[place]]\nname = "goal"\nx = "1 m"\ny = "0 m"\ntolerance = "0.2 m"\n'
    file.write_text(f'{scenario}rules = []\nx = "0 m"\ny = "0 m"\nparameters = {{ goal = "goal" }}\n{goal}')
    found = [str(fault) for fault in check_content([file]).faults]
    assert [f"its friction is {friction}, not 1" in text for text in found] == ([True] if friction else []), found
