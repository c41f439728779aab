"""Planners with predicted movers: what they do when a person comes toward them on an open floor."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from rocs_bt import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.control.locomotion_kinds import make_locomotion
from rocs_bt.knowledge import Movers, OccupancyGrid
from rocs_bt.plan import Observation, Task

PEERS = {
    "dynamic_window_among": {
        "look": 2.5,
        "horizon": 2.4,
        "clearance": 0.05,
        "contact": 4.0,
        "speed": 0.25,
        "back": 0.4,
    },
    "mppi_among": {"back": 0.4, "contact": 20.0, "temperature": 0.1},
    "pure_pursuit_among": {"cruise": 1.2, "back": 0.4, "horizon": 1.5, "comfort": 0.1},
}


def speed(name, gap=None, t=10.0, calls=1):
    """Speed ahead [m/s] that a planner commands with a mover at a gap, which comes at 1 m/s; the goal is behind it."""
    world = SimpleNamespace(movers=None, occupancy=OccupancyGrid(0.05, 10.0))
    drive = make_locomotion(
        "differential",
        wheel_separation=0.5,
        max_wheel_speed=2.0,
        max_wheel_acceleration=2.5,
        delay=0.1,
    )
    task = Task(
        goals={"goal": Pose2(6.0, 0.0, 0.0)},
        tolerances={"goal": 0.2},
        locomotion=drive,
        knowledge=SimpleNamespace(
            world=world,
            graph=SimpleNamespace(attributes=lambda name: {"length": 0.5, "width": 0.4}),
            agent="R",
        ),
        route=lambda name: SimpleNamespace(moving=True, route=lambda pose, goal, gap: [pose[:2], goal[:2]]),
    )
    catalog = Catalog()
    spec = catalog.load_planner(name)
    planner = catalog.load_class(spec.file.parent / spec.mission.split(":")[0], spec.mission.split(":")[1])(
        movers=True, **PEERS[name]
    )
    planner.reset(task, np.random.default_rng(1))
    moving = {"speed": np.array([0.4]), "turn_rate": np.array([0.0])}
    for now in t + 0.05 * np.arange(calls):
        if gap is not None:
            world.movers = Movers.of(now, np.array([[0.5 + gap, 0.0, -1.0, 0.0]]), 0.25)
        command = planner.act(Observation(now, Pose2(0.0, 0.0, 0.0), moving))
    return drive.twist(np.array(command)).forward


@pytest.mark.parametrize("name", PEERS)
def test_on_a_free_floor_they_drive_on(name):
    assert speed(name, calls=8) > 0.5


@pytest.mark.parametrize("name", PEERS)
@pytest.mark.parametrize("gap", [0.15, 0.4, 0.8])
def test_none_drives_on_into_what_comes_however_near_it_is(name, gap):
    # The nearest one is within every margin, so that all motions end in a contact: the latest one is the best.
    assert speed(name, gap, calls=8) < 0.25


@pytest.mark.parametrize("name", PEERS)
def test_each_backs_off_from_what_comes_near(name):
    assert speed(name, 0.4, calls=8) < -0.1
