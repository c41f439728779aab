"""What robot.toml says of a sensor's readings holds in the agent that is built from it."""

import shutil

import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.event import ListSink
from rocs_bt.running.simulated_stage import simulated_agents
from rocs_bt.simulation import build_world


@pytest.mark.parametrize(("line", "age"), [("", 0.15), ('max_age = "0.4 s"\n', 0.4)])
def test_a_reading_is_valid_for_its_max_age(line, age, tmp_path):
    shipped = Catalog()
    shutil.copytree(shipped.find("robot", "pioneer_p3dx").path.parent, tmp_path / "robots" / "pioneer_p3dx")
    file = tmp_path / "robots" / "pioneer_p3dx" / "robot.toml"
    file.write_text(file.read_text().replace('name = "encoders"\n', f'name = "encoders"\n{line}'))
    catalog, sink = Catalog(tmp_path), ListSink()
    scenario = catalog.load_scenario("exp1")
    stage = build_world(scenario, catalog, 1, sink)
    (agent,) = simulated_agents(scenario, stage, catalog, sink)
    agent.step(0)
    signals = agent.knowledge.signals
    assert signals.value("speed", age - 0.01) == signals.value("speed", 0.0)
    assert not signals.value("speed", age + 0.01) < 1e9  # NaN
