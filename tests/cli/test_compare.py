"""`rocs-bt compare`: what it tells, and what it refuses before anything is played."""

from __future__ import annotations

import json

import pytest

SHORT = """format = "scenario/2"
base = "exp1"
duration = "0.5 s"
"""


def test_a_comparison_tells_estimates_outcomes_and_verdicts(rocs_bt, tmp_path):
    (tmp_path / "scenarios").mkdir()
    (tmp_path / "scenarios" / "brief.toml").write_text(SHORT)
    told = rocs_bt("compare", "tree", "none", "--scenario", "brief", "--seeds", 2, "--metric", "success")
    assert told.code == 0, told.err
    assert "2 seeds; 4 played now, 0 before" in told.out
    head, *rows = [
        line.split() for line in told.out.splitlines() if line.strip().startswith(("planner", "tree", "none"))
    ]
    assert head[-1] == "timeout"
    assert {row[0]: row[-1] for row in rows} == {"tree": "2", "none": "2"}
    assert "none in success" in told.out
    again = rocs_bt("compare", "tree", "none", "--scenario", "brief", "--seeds", 2, "--metric", "success")
    assert "0 played now, 4 before" in again.out
    assert (tmp_path / "runs" / "compare" / "episodes.sqlite").exists()


@pytest.mark.parametrize(
    ("planners", "names"),
    [([], {"@pioneer_p3dx", "@robotino"}), (["tree"], {"tree@pioneer_p3dx", "tree@robotino"})],
)
def test_robots_are_compared_as_planners_are(rocs_bt, tmp_path, planners, names):
    (tmp_path / "scenarios").mkdir()
    (tmp_path / "scenarios" / "brief.toml").write_text(SHORT)
    robots = ["--robot", "pioneer_p3dx", "--robot", "robotino"]
    told = rocs_bt("compare", *planners, *robots, "--scenario", "brief", "--seeds", 1, "--metric", "time", "--json")
    assert told.code == 0, told.err
    assert {result["planner"] for result in json.loads(told.out)["results"]} == names
    assert rocs_bt("run", "brief", "--planner", min(names)).code == 1  # a timeout, as in the comparison


def test_an_error_is_told_with_the_command_that_plays_it_again(rocs_bt, tmp_path):
    for folder in ("scenarios", "planners"):
        (tmp_path / folder).mkdir()
    (tmp_path / "scenarios" / "brief.toml").write_text(SHORT)
    (tmp_path / "planners" / "bad.py").write_text(
        '"""Bad."""\n\n\nclass Bad:\n    def reset(self, task, rng):\n        pass\n\n'
        "    def act(self, observation):\n        return 1 / 0\n"
    )
    (tmp_path / "planners" / "bad.toml").write_text('format = "planner/1"\ndoc = "Bad."\npython = "bad.py:Bad"\n')
    told = rocs_bt("compare", "bad", "--scenario", "brief", "--seeds", 1, "--jobs", 1)
    assert told.code == 1
    assert "ZeroDivisionError" in told.err
    assert "3 exceptions, failed: the mission failed: planner 'Bad' raised ZeroDivisionError" in told.err
    assert "(bad.py:9)" in told.err
    assert "rocs-bt run brief --planner bad --seed 1" in told.err


def test_a_wrong_parameter_is_told_at_its_place_in_the_planners_file(rocs_bt, tmp_path):
    (tmp_path / "planners").mkdir()
    file = tmp_path / "planners" / "odd.toml"
    file.write_text('format = "planner/1"\ndoc = "Odd."\nmission = "go_to"\n\n[parameters]\nspede = 1\n')
    told = rocs_bt("compare", "odd", "--family", "exp1_family", "--jobs", 1)
    assert told.code == 2
    assert f"{file}:6:1" in told.err
    assert "no parameter is named 'spede'" in told.err
