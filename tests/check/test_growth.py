"""Growth of the work of a check and of a run with the number of places: linear."""

from __future__ import annotations

import cProfile
import pstats
from collections.abc import Callable
from pathlib import Path

import pytest

from rocs_bt import Catalog, run
from rocs_bt.check import check_content, feasible
from rocs_bt.record.figures import arena

SCENARIO = """format = "scenario/2"
doc = "Many places."
world = "plane"
duration = "0.05 s"

[[agent]]
name = "R1"
robot = "pioneer_p3dx"
mission = "go_to"
rules = ["avoid_collision"]
x = "-1 m"
y = "0 m"
yaw = "0 deg"

[agent.parameters]
goal = "p0"
"""
PLACE = '\n[[place]]\nname = "p{0}"\nkind = "{1}"\nx = "{2:.2f} m"\ny = "{3:.2f} m"\n'


def check(project: Path) -> None:
    assert not check_content([project / "scenarios/many.toml"]).has_errors


def play(project: Path) -> None:
    run("many", Catalog(project), out=project / "out")


@pytest.mark.parametrize("kind", ["goal", pytest.param("place", marks=pytest.mark.soak)])
@pytest.mark.parametrize("work", [check, pytest.param(play, marks=pytest.mark.soak)])
def test_twice_as_many_places_are_at_most_twice_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, work: Callable[[Path], None], kind: str
) -> None:
    monkeypatch.setattr(feasible, "_MANY", 2)
    monkeypatch.setattr(arena, "PLACES", 10)

    def calls(count: int) -> int:
        """Number of function calls of the work with this many places."""
        places = [PLACE.format(i, kind, 0.01 * (i % 50), 0.01 * (i // 50)) for i in range(count)]
        (tmp_path / "scenarios").mkdir(exist_ok=True)
        (tmp_path / "scenarios/many.toml").write_text(SCENARIO + "".join(places))
        profile = cProfile.Profile()
        profile.runcall(work, tmp_path)
        return pstats.Stats(profile).total_calls

    calls(20)  # imports
    few, some, many = map(calls, (40, 80, 160))
    assert many - some < 2.2 * (some - few)
