"""The Pioneer that keeps the things around it, in EXP1: what it believes in is there, and stands."""

from __future__ import annotations

import math
from pathlib import Path

from rocs_bt import run
from rocs_bt.catalog import Catalog
from rocs_bt.record import Recording
from rocs_bt.record.knowledge import recorded_log

SCENARIO = 'format = "scenario/2"\nbase = "exp1"\n[[agent]]\nname = "R2"\nrobot = "pioneer_p3dx_tracking"\n'


def away(x: float, y: float) -> float:
    """From the nearest wall of the arena, or the box in it [m]."""
    beside = [abs(x + 0.5) - 0.25, abs(y - 1.0) - 0.25]
    box = math.hypot(*(max(d, 0.0) for d in beside)) if max(beside) > 0.0 else -max(beside)
    return min(box, abs(x - 2.475), abs(x + 2.45), abs(y - 2.475), abs(y + 2.425))


def test_what_it_believes_in_is_there_and_what_stands_is_not_said_to_move(tmp_path: Path) -> None:
    path = tmp_path / "scenarios/track.toml"
    path.parent.mkdir()
    path.write_text(SCENARIO, encoding="utf-8")
    result = run("track", Catalog(tmp_path), out=tmp_path / "run", report=False)
    assert result.summary.agents["R2"].outcome == "success"
    errors, moving = [], 0
    log = recorded_log(Recording.open(tmp_path / "run"))
    for t in range(1, 15):
        state = log.as_of(float(t))
        for node in (n for n in state.nodes("object") if state.get(n, "pose") is not None):
            errors.append(away(*state.get(node, "pose")[:2]))
            moving += bool(state.get(node, "moves"))
    assert len(errors) > 40
    assert max(errors) < 0.5
    assert sum(error < 0.35 for error in errors) > 0.9 * len(errors)
    assert moving == 0
