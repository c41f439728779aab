"""The hybrid planner without a map: through a field of posts, the same way each time, and stopped by its reflex."""

import math

import pytest

from rocs_bt import run
from rocs_bt.catalog import Catalog, read_planner
from rocs_bt.compare import load_family
from rocs_bt.interfaces.device import Reading


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fields")
    scene = load_family(Catalog.here(), "barn_like").scene(100)
    scene.write(folder)
    return Catalog(folder), scene.name


def drive(project, seed=1, **changed):
    catalog, name = project
    planner = read_planner(catalog.find("planner", "hybrid").path)
    return run(planner.drives(catalog.load_scenario(name), "R"), catalog, seed=seed, **changed)


def test_it_reaches_the_goal_unhurt_and_repeats_to_the_bit(project):
    first, second = drive(project).summary, drive(project).summary
    assert first.agents["R"].outcome == "success"
    assert first.agents["R"].collisions == 0
    assert first.trajectory_hash == second.trajectory_hash
    assert first.agents["R"].actions["FollowRoute"]["SUCCEEDED"] == 1


def test_blind_it_stands_still(project):
    def break_the_scanner(stage):
        stage.sensors["R"]["lidar"].read = lambda: Reading(stage.world.stamp, [math.nan] * 720)

    result = drive(project, prepare=break_the_scanner, duration=3.0).summary.agents["R"]
    assert result.path_length < 0.1
    assert result.collisions == 0
