"""docs/write-a-planner.md: its planner drives any wheels."""

import re

import pytest

from docs.tables import ROOT, wheeled
from rocs_bt import run
from rocs_bt.catalog import Catalog

TEXT = (ROOT / "docs/write-a-planner.md").read_text("utf-8")


@pytest.mark.parametrize("robot", wheeled())
def test_the_planner_of_the_page_drives_any_wheels(tmp_path, robot):
    for name, content in re.findall(r"Save as `(.+?)`:\n\n```\w+\n(.*?)```", TEXT, re.DOTALL):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(content)
    catalog = Catalog(tmp_path)
    planner = catalog.load_planner(f"straight@{robot}")
    spec = planner.drives(catalog.load_scenario("exp1"), "R2")
    found = run(spec, catalog, duration=1.0).summary.agents["R2"]
    assert found.robot == robot
    assert 0.2 < found.path_length < 0.45
