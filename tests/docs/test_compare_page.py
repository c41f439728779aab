"""docs/compare.md: its metrics are the registry's, its planner drives, its Python runs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rocs_bt import compare, run
from rocs_bt.catalog import Catalog
from rocs_bt.compare.metric import METRICS

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "compare.md").read_text("utf-8")
PUBLIC = {
    "Block", "Building", "Comparison", "Family", "FamilyScene", "Ground", "Post", "ScenarioScene", "Scene", "Store",
    "SweepOptions", "TaskFamily", "goal_scenario", "length_of", "load_family", "position", "quantity", "scenes_of",
    "shortest_cells", "sweep", "walls_around",
}  # fmt: skip  # a table
PYTHON = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)


def test_what_families_and_comparisons_need_is_public_and_nothing_else():
    assert set(compare.__all__) == PUBLIC
    assert all(hasattr(compare, name) for name in PUBLIC)


def test_every_metric_is_told_with_its_unit_and_its_direction():
    rows = [re.split(r" *\| *", line.strip("| \n")) for line in PAGE.splitlines() if line.startswith("| `")]
    told = {name: (unit, better) for names, unit, better, *_ in rows for name in re.findall(r"`(.+?)`", names)}
    assert told.pop("margin of NAME") == told.pop("holds NAME") == ("", "up")
    assert told == {name: (metric.unit, metric.direction) for name, metric in METRICS.items()}


def test_the_planner_of_the_page_drives(tmp_path):
    (code,) = [block for block in PYTHON if "class Straight" in block]
    (file,) = [block for block in re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL) if "straight.py" in block]
    (tmp_path / "planners").mkdir()
    (tmp_path / "planners" / "straight.py").write_text(code)
    (tmp_path / "planners" / "straight.toml").write_text(file)
    catalog = Catalog(tmp_path)
    planner = catalog.load_planner("straight")
    spec = planner.drives(catalog.load_scenario("exp1"), "R2")
    found = run(spec, catalog, duration=1.0).summary.agents["R2"]
    assert found.path_length == pytest.approx(0.4, abs=0.05)


def test_the_sweep_of_the_page_runs(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    (code,) = [block for block in PYTHON if "Comparison(" in block]
    names: dict = {}
    exec(compile(code, "compare.md", "exec"), names)
    assert names["comparison"].planners == ("tree", "none")
    assert names["done"].played == 4
