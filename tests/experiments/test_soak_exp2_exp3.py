"""EXP2 and EXP3 over a hundred seeds each; the figures are in the test's output (`make soak`).

These are pinned seeds, so this guards what there is. Others differ: benchmarks/README.md has many hundreds.
"""

from __future__ import annotations

import json
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent

pytestmark = pytest.mark.soak


@cache
def campaign(experiment: str) -> dict[str, Any]:
    command = [sys.executable, str(HERE / "campaign.py"), experiment, "--seeds", "201", "300", "--json"]
    found = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    print(json.dumps(found, indent=1))
    return dict(found["agents"])


MINDS = [("exp2", "R3"), ("exp3", "R2"), ("exp3", "R3")]


@pytest.mark.parametrize(("experiment", "mind"), MINDS)
def test_at_most_three_of_a_hundred_collide(experiment: str, mind: str) -> None:
    assert campaign(experiment)[mind]["collided"]["count"] <= 3


@pytest.mark.parametrize(("experiment", "mind"), MINDS)
def test_nothing_is_run_into_but_the_walker(experiment: str, mind: str) -> None:
    touches = campaign(experiment)[mind]["touches"]
    assert not [what for what in touches if what.startswith("collision") and not what.endswith("R1")]


def test_r3_comes_to_its_place() -> None:
    assert campaign("exp2")["R3"]["goals"].get("1", 0) >= 97


def test_r2_visits_the_four_corners() -> None:
    assert campaign("exp3")["R2"]["goals"].get("4", 0) >= 95


def test_r3_keeps_within_its_band() -> None:
    assert campaign("exp3")["R3"]["following"]["in_band"] >= 0.95


def test_r3_never_drives_within_the_safety_distance() -> None:
    assert campaign("exp3")["R3"]["following"]["below_safety_driving"]["count"] == 0
