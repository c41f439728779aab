"""What holds for every robot, rule file, mission, scenario and driver that we ship."""

import math
import re

import numpy as np
import pytest

from rocs_bt import run
from rocs_bt.actions import ACTIONS
from rocs_bt.analyze import ANALYZERS
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.catalog import KINDS, Catalog, content_hash
from rocs_bt.check import check_content
from rocs_bt.event import NullSink
from rocs_bt.interfaces.action import parameters_of
from rocs_bt.monitor import MONITORS
from rocs_bt.running.hardware_devices import on_hardware
from rocs_bt.simulation import build_world

CATALOG = Catalog()
ENTRIES = CATALOG.list()
ROBOTS = [e.name for e in CATALOG.list("robot")]
HARDWARE = [name for name in ROBOTS if on_hardware(CATALOG, CATALOG.load_robot(name))]
SCENARIOS = [
    e.name
    for e in CATALOG.list("scenario")
    if not {a.robot for a in CATALOG.load_scenario(e.name).agents} & {*HARDWARE}
]
STANDARD_SIGNALS = {
    "front", "left_gap", "right_gap", "rear", "speed", "turn_rate", "stop_distance", "goal_distance", "pose",
}  # fmt: skip  # names, several on a line


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda e: f"{e.kind}-{e.name}")
def test_content_is_described_and_in_its_folders_table(entry):
    assert re.fullmatch(r"[A-Z].{10,120}\.", entry.doc), "one sentence for people"
    folder = CATALOG.shipped / KINDS[entry.kind].patterns[0].split("/")[0]
    table = [line for line in (folder / "README.md").read_text("utf-8").splitlines() if line.startswith("|")]
    assert any(re.search(rf"[`\[/]{entry.name}\b", line) for line in table)
    assert content_hash([entry]) == content_hash([entry])


def test_nothing_that_is_shipped_is_wrong():
    found = check_content([CATALOG.shipped / kind for kind in ("robots", "rules", "scenarios", "planners")])
    assert not found.has_errors, found.faults
    assert len(found.files) >= len(ENTRIES) - len(CATALOG.list("world"))


@pytest.fixture(scope="module")
def stages():
    return {name: build_world(CATALOG.load_scenario(name), CATALOG, 1, NullSink()) for name in SCENARIOS}


@pytest.mark.parametrize("robot", ROBOTS)
def test_a_robot_declares_the_standard_signals(robot):
    from rocs_bt.check.stub_agent import stub_agent

    agent = stub_agent(CATALOG.load_robot(robot), CATALOG.load_class)
    assert set(agent.knowledge.signals.names) >= STANDARD_SIGNALS
    for sensor in CATALOG.load_robot(robot).sensors:
        live = agent.knowledge.graph.get(sensor.name, "values")
        assert live.size == agent.knowledge.signals.spec(sensor.signal).size
        assert not live.flags.writeable


@pytest.mark.parametrize("robot", HARDWARE)
def test_a_robot_on_hardware_differs_from_a_simulated_one_only_in_its_drivers_and_limits(robot):
    spec = CATALOG.load_robot(robot)
    base = CATALOG.load_robot(spec.bases[0].parent.name)
    assert base.name not in HARDWARE
    assert "ros2" in spec.tables
    blocks = [[(b.name, b.cls, b.parameters) for b in (*of.monitors, *of.analyzers)] for of in (spec, base)]
    assert blocks[0] == blocks[1]
    assert [(s.name, s.signal, s.monitor, s.rate) for s in spec.sensors] == [
        (s.name, s.signal, s.monitor, s.rate) for s in base.sensors
    ]
    assert {device.driver for device in (*spec.sensors, *spec.actuators)} == {"ros2"}
    assert all(actuator.isolated for actuator in spec.actuators)
    for own, limit in zip(spec.actuators, base.actuators, strict=True):
        assert (own.limits.low, own.limits.high) == (limit.limits.low, limit.limits.high)


@pytest.mark.parametrize("robot", ROBOTS)
def test_every_number_of_a_robot_has_its_source(robot):
    lines = CATALOG.find("robot", robot).path.read_text("utf-8").splitlines()
    quantities = [line for line in lines if re.search(r'= \[?"-?[0-9.]+ [a-zA-Z]', line)]
    # A rate or a weight that follows from another line need not repeat it; physical numbers must say whence.
    physical = [line for line in quantities if not line.startswith(("rate", "max_command_age", "near", "clear"))]
    assert physical
    assert [line for line in physical if "[" not in line.partition("#")[2]] == []


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_a_stages_sensors_read_and_its_actuators_stop(scenario, stages):
    stage = stages[scenario]
    for name, sensors in stage.sensors.items():
        for sensor in sensors.values():
            reading = sensor.read()
            assert reading.stamp == stage.clock.now()
            assert not any(math.isnan(v) for v in reading.values)
            assert sensor.read().values == reading.values, "reading changes nothing"
        for actuator in stage.actuators[name].values():
            actuator.command([0.1] * actuator.size)
            actuator.neutral()
            stage.world.advance(200)
        assert not stage.world.commanded(name)


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_a_scenario_begins_and_repeats(scenario):
    first, second = (run(scenario, CATALOG, seed=5, duration=1.0).summary for _ in range(2))
    assert first.trajectory_hash == second.trajectory_hash
    assert first.sim_time == pytest.approx(1.0)
    assert all(a.outcome != "error" for a in first.agents.values())


@pytest.mark.parametrize("name", [*ACTIONS, *MONITORS, *ANALYZERS])
def test_blocks_and_actions_say_what_they_are(name):
    cls = {**ACTIONS, **MONITORS, **ANALYZERS}[name]
    assert len(cls.__doc__ or "") > 20
    assert cls.__name__ == name


@pytest.mark.parametrize("name", ACTIONS)
def test_an_action_takes_its_parameters_and_tells_them(name):
    declared = parameters_of(ACTIONS[name])
    given = {p.name: "goal" if p.hint is str else 0.5 for p in declared.values() if p.required}
    given |= {n: [(0.0, 0.0), (1.0, 0.0)] if n == "points" else [0.1, 0.1] for n in ("points", "speeds") if n in given}
    action = ACTIONS[name](**given)
    unset = {"heading", "height"}  # recorded only where they are set
    assert set(declared) - unset <= set(action.parameters) <= set(declared)
    action.update(**{k: v for k, v in given.items() if isinstance(v, float)})


def test_standing_robots_are_free_at_their_starts_for_many_seeds():
    spec = CATALOG.load_scenario("exp1")
    for seed in np.arange(1, 31).tolist():
        stage = build_world(spec, CATALOG, seed, NullSink(), clock=SimulatedClock(spec.rate.physics))
        assert all(stage.world.clearance(name)[0] > 0.0 for name in stage.world.robots)
