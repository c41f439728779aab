"""Every shipped robot with a scanner builds a map, and the planner and the rules that read it work on that robot."""

import pytest

from rocs_bt import run
from rocs_bt.catalog import Catalog
from rocs_bt.declare import replaced

CATALOG = Catalog()
ROBOTS = {entry.name: CATALOG.load_robot(entry.name) for entry in CATALOG.list("robot")}
WITH_SCANNER = sorted(name for name, robot in ROBOTS.items() if any(m.cls == "ScanMonitor" for m in robot.monitors))
SIMULATED = [name for name in WITH_SCANNER if not name.endswith("_ros2")]


@pytest.mark.parametrize("name", WITH_SCANNER)
def test_a_robot_with_a_scanner_has_a_map(name):
    scans = {monitor.name for monitor in ROBOTS[name].monitors if monitor.cls == "ScanMonitor"}
    assert any(block.cls == "LocalMap" and scans & {*block.monitors} for block in ROBOTS[name].analyzers)


@pytest.mark.parametrize("name", SIMULATED)
def test_its_contact_time_is_valid_between_two_scans(name):
    scenario = CATALOG.load_scenario("exp1")
    agent = replaced(scenario.agents[0], robot=name, rules=("contact",), mission="go_to")
    scenario = replaced(scenario, world="plane", agents=(agent,), actors=(), duration=1.5)
    (summary,) = run(scenario, CATALOG, seed=1).summary.agents.values()
    assert not summary.reflex_activations  # the rule Blind of `contact` fires while `contact_time` is invalid
