"""docs/write-a-planner.md: its classes are those of the package, its planner drives any wheels."""

import re

import pytest

from rocs_bt import run
from rocs_bt.catalog import Catalog

from . import planner_classes

TEXT = planner_classes.PAGE.read_text("utf-8")


def test_every_attribute_of_what_a_planner_gets_is_on_the_page():
    assert planner_classes.page() == TEXT, "write it with: python tests/docs/planner_classes.py"
    for cls in planner_classes.CLASSES:
        named = planner_classes.attributes(cls.__doc__.replace("\n    ", "\n"))
        assert set(getattr(cls, "__annotations__", {})) <= set(named), cls


def wheeled():
    robots = {entry.name: Catalog().load_robot(entry.name) for entry in Catalog().list("robot")}
    return [name for name, robot in robots.items() if "axes" not in robot.locomotion.parameters and not robot.bases]


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
