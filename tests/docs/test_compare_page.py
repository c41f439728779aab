"""docs/compare.md: its metrics are the registry's, its Python runs."""

from __future__ import annotations

import re
from pathlib import Path

from rocs_bt import compare
from rocs_bt.compare.metric import METRICS

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "compare.md").read_text("utf-8")
PUBLIC = {
    "Block", "Building", "Comparison", "EpisodeStore", "Family", "FamilyScene", "Floor", "PeopleFamily", "Post",
    "ScenarioScene", "Scene", "SweepOptions", "TaskFamily", "TrafficFamily", "Walk", "goal_scenario", "length_of",
    "load_family", "one_of", "position", "quantity", "scenes_of", "shortest_cells", "sweep", "walls_around",
}  # fmt: skip  # names, several on a line
PYTHON = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)


def test_what_families_and_comparisons_need_is_public_and_nothing_else():
    assert set(compare.__all__) == PUBLIC
    assert all(hasattr(compare, name) for name in PUBLIC)


def test_every_metric_is_told_with_its_unit_and_its_direction():
    rows = [re.split(r" *\| *", line.strip("| \n")) for line in PAGE.splitlines() if line.startswith("| `")]
    told = {name: (unit, better) for names, unit, better, *_ in rows for name in re.findall(r"`(.+?)`", names)}
    assert told.pop("margin of NAME") == told.pop("holds NAME") == ("", "up")
    assert told == {name: (metric.unit, metric.direction) for name, metric in METRICS.items()}


def test_the_sweep_of_the_page_runs(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    (code,) = [block for block in PYTHON if "Comparison(" in block]
    names: dict = {}
    exec(compile(code, "compare.md", "exec"), names)
    assert names["comparison"].planners == ("tree", "none")
    assert names["done"].played == 4
