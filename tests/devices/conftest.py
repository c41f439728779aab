"""A world to drive in, and the shipped robot's devices."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from rocs_bt.catalog import RobotSpec, load_robot
from rocs_bt.devices.mujoco import MujocoWorld, RobotInstance, compose_world
from tests.made_devices import sensor_mount

ROOT = Path(__file__).parents[2]

EMPTY = """<mujoco><worldbody><geom name="floor" type="plane" size="20 20 0.1"/>{}</worldbody></mujoco>"""


@pytest.fixture(scope="session")
def p3dx() -> RobotSpec:
    return load_robot(ROOT / "robots" / "pioneer_p3dx" / "robot.toml")


@pytest.fixture
def make_world(tmp_path: Path, p3dx: RobotSpec) -> Callable[..., MujocoWorld]:
    """A floor with whatever geoms a test wants on it, the robot R2 with sensors, and others without."""

    def make(geoms: str = "", others: tuple[str, ...] = (), step: float = 0.005) -> MujocoWorld:
        arena = tmp_path / "arena.xml"
        arena.write_text(EMPTY.format(geoms))
        assert p3dx.model is not None
        mounts = [sensor_mount(s.name, s.driver, s.arguments) for s in p3dx.sensors]
        robots = [RobotInstance("R2", p3dx.model, mounts), *(RobotInstance(name, p3dx.model) for name in others)]
        return compose_world(arena, robots, step=step)

    return make
