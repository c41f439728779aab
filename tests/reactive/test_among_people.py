"""rules/among_people.toml on a robot that moves sideways; its other tests are in rules/tests/among_people.toml."""

import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.check import fitted_rules
from rocs_bt.reactive import run_tests

HOST = """format = "robot/3"
base = "rosbot_xl"
doc = "A robot with mecanum wheels that tracks people."
[[analyze]]
name = "mover"
class = "TrackObjects"
monitors = ["scan", "pose"]
ranges = "scan"
"""


@pytest.mark.parametrize("robot", ["jackal", "host"])
def test_every_rule_that_is_active_has_tests_that_pass(tmp_path, robot) -> None:
    (tmp_path / "robots/host").mkdir(parents=True)
    (tmp_path / "robots/host/robot.toml").write_text(HOST)
    catalog = Catalog(tmp_path)
    ((_, rules),) = fitted_rules(catalog.find("rules", "among_people"), catalog, robot)
    active = ["Yield", "YieldSideways", "Blind"] if robot == "host" else ["Yield", "Blind"]
    assert [rule.name.rpartition("/")[2] for rule in rules.rules] == active
    assert all(rule.tests for rule in rules.rules)
    assert [result.message for result in run_tests(rules) if not result.passed] == []
