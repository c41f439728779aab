"""A robot that a reflex holds without end, through the front door."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

RULES = """format = "reflex/1"
[rule.Halt]
when = "goal_distance < 2.5 m"
until = "goal_distance > 2.7 m"
priority = 10
[rule.Halt.action]
name = "Stop"
"""
WAITS = """
from rocs_bt.base.units import MetresPerSecond

def build(mission, *, first: str = "", second: str = "", cruise: MetresPerSecond = 0.4):
    return mission.wait("60 s")
"""


@pytest.fixture
def held(project: Path) -> Path:
    """A project whose rule stops the rover for ever once it is near its first goal."""
    (project / "rules/keep_clear.toml").write_text(RULES)
    return project


def outcome(folder: Path) -> tuple[str, str]:
    agent = json.loads((folder / "summary.json").read_text())["agents"]["R1"]
    return agent["outcome"], agent["reason"]


def test_a_reflex_that_latches_for_ever_is_stuck_and_its_rule_is_named(held, rocs_bt) -> None:
    told = rocs_bt("run", "first", "--out", "out", "--no-report")
    assert told.code == 1
    name, reason = outcome(held / "out")
    assert name == "stuck"
    assert reason.startswith("it moved less than 0.05 m in 15 s near x = ")
    assert "held by keep_clear/Halt for " in reason
    assert "(goal_distance = 2." in reason
    assert f"R1 stuck (first, seed 1): {reason}" in told.out


def test_a_mission_that_waits_is_not_stuck_whatever_a_reflex_does(held, rocs_bt) -> None:
    (held / "planners/missions/patrol.py").write_text(WAITS)
    (held / "rules/keep_clear.toml").write_text(
        RULES.replace("goal_distance < 2.5 m", "speed < 1 m/s").replace("goal_distance > 2.7 m", "speed > 2 m/s")
    )
    told = rocs_bt("run", "first", "--out", "out", "--no-report", "--for", "20")
    assert told.code == 1
    assert outcome(held / "out")[0] == "timeout"
    assert "R1 timeout" in told.out


def test_a_rule_that_waits_for_the_world_is_neither_stuck_nor_warned_of(held, rocs_bt) -> None:
    file = held / "rules/keep_clear.toml"
    assert "can hold the robot for ever" in rocs_bt("check", "rules/keep_clear.toml").out
    file.write_text(RULES.replace("priority = 10", 'priority = 10\nwaits_for = "a moved goal"'))
    assert "can hold the robot for ever" not in rocs_bt("check", "rules/keep_clear.toml").out
    rocs_bt("run", "first", "--out", "out", "--no-report", "--for", "20")
    assert outcome(held / "out")[0] == "timeout"
    file.write_text(RULES.replace("priority = 10", 'priority = 10\nwaits_for = ""'))
    assert "waits_for is empty" in rocs_bt("check", "rules/keep_clear.toml").out
