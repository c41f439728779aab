"""`rocs-bt search`: what it tells, keeps, refuses, and exits with."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

BARE = '''"""Nothing but a goal."""

from rocs_bt import Pose2
from rocs_bt.compare import Family, Floor, Post, Scene, goal_scenario


class Bare(Family):
    """Nothing but a goal."""

    robot: str = "pioneer_p3dx"

    def scene(self, index):
        floor = Floor((-2.0, -2.0), (2.0, 2.0), [Post("post", 1.5, 1.5, 0.1)])
        name = self.scene_name(index)
        scenario = goal_scenario(self, name, "Bare.", Pose2(0.0, 0.0), (1.5, 0.0), tolerance=0.2, duration=1.0)
        return Scene(scenario, floor)
'''


@pytest.fixture
def bare(tmp_path):
    """A project with a family of its own."""
    (tmp_path / "scenarios" / "families").mkdir(parents=True)
    (tmp_path / "scenarios" / "families" / "bare.py").write_text(BARE)
    return "--family", "bare", "--jobs", 1


def test_a_scene_that_was_found_is_kept_told_and_tested(rocs_bt, tmp_path, bare):
    told = rocs_bt("search", "none", *bare, "--budget", 12, "--out", ".")
    assert told.code == 1, told.err
    assert "none fails in bare-" in told.out
    assert "0 obstacles" in told.out
    assert "rocs-bt run none_in_bare --planner none --seed 1" in told.out
    assert (tmp_path / "scenarios" / "worlds" / "none_in_bare.xml").exists()
    plain = rocs_bt("search", "none", *bare, "--budget", 12, "--json")
    scenario = (tmp_path / "scenarios" / "none_in_bare.toml").read_text()
    assert json.loads(plain.out)["smallest"]["scenario"] == scenario
    taken = rocs_bt("search", "none", *bare, "--out", ".")
    assert taken.code == 2
    assert "'none_in_bare' already exists" in taken.err
    test = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--compare-jobs", "1", "tests"]
    done = subprocess.run(test, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1, done.stdout + done.stderr
    assert "{'timeout': 1} == {'success': 1}" in done.stdout


def test_the_scene_of_a_planner_on_a_robot_has_this_robot(rocs_bt, tmp_path, bare):
    told = rocs_bt("search", "none@robotino", *bare, "--budget", 12, "--out", ".")
    assert told.code == 1, told.err
    assert "rocs-bt run none_robotino_in_bare --planner none@robotino --seed 1" in told.out
    scenario = (tmp_path / "scenarios" / "none_robotino_in_bare.toml").read_text()
    assert 'robot = "robotino"' in scenario
    test = (tmp_path / "tests" / "test_none_robotino_in_bare.py").read_text()
    assert '@pytest.mark.planners("none@robotino")' in test


def test_a_planner_that_fails_nowhere_ends_with_0(rocs_bt, bare):
    told = rocs_bt("search", "none", *bare, "--failure", "collision", "--budget", 2)
    assert told.code == 0, told.err
    assert told.out == "none failed in none of 2 scenes of bare.\n"
