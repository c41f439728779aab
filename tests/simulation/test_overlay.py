"""Tables of a scenario's agent that override those of its robot: noise, latency, slip, without a new robot."""

from __future__ import annotations

from pathlib import Path

import pytest

from rocs_bt import run
from rocs_bt.catalog import Catalog
from rocs_bt.event import ListSink, MapChanged, SensorRead
from rocs_bt.record import Recording
from rocs_bt.record.explanation.why import explain

SCENE = """
format = "scenario/2"
world = "plane"
duration = "1 s"
[[place]]
name = "goal"
x = "3 m"
y = "0 m"
[[agent]]
name = "R"
robot = "jackal"
mission = "go_to"
x = "0 m"
y = "0 m"
parameters = { goal = "goal" }
"""
FAULTS = """
[[agent.sensor]]
name = "lidar"
latency = "0.1 s"
drop_out = 0.2
missing_echo = 0.1
sweep = "25 ms"
[[agent.sensor]]
name = "position"
drift = "2 cm"
[[agent.actuator]]
name = "wheels"
slip = [0.1]
"""


def scene(folder: Path, more: str = "") -> str:
    file = folder / "scene.toml"
    file.write_text(SCENE + more)
    return str(file)


def play(folder: Path, more: str = "", out: Path | None = None):
    sink = ListSink()
    return run(scene(folder, more), Catalog(), seed=4, out=out, report=False, sinks=[sink]).summary, sink


def test_faults_of_a_scenario_change_the_run_and_only_the_seed_decides_them(tmp_path):
    plain, again, faulty, repeated = (play(tmp_path, more)[0] for more in ("", "\n", FAULTS, FAULTS))
    assert plain.trajectory_hash == again.trajectory_hash
    assert faulty.trajectory_hash == repeated.trajectory_hash != plain.trajectory_hash
    assert faulty.agents["R"].path_length < plain.agents["R"].path_length


def test_a_late_reading_is_recorded_with_the_stamp_of_its_measurement(tmp_path):
    _, sink = play(tmp_path, '[[agent.sensor]]\nname = "lidar"\nlatency = "0.1 s"\n')
    scans = [e for e in sink.events if isinstance(e, SensorRead) and e.sensor == "lidar"]
    assert {round(e.t - e.stamp, 6) for e in scans if e.t > 0.12} == {0.1}
    assert {round(e.t - e.stamp, 6) for e in sink.events if isinstance(e, SensorRead) and e.sensor == "position"} == {
        0.0
    }


def test_why_names_the_faults_of_the_devices(tmp_path):
    play(tmp_path, FAULTS, out=tmp_path / "run")
    text = explain(Recording.open(tmp_path / "run"), 0.8, "R").text(everything=True)
    assert "lidar: latency 0.1 s, drop_out 0.2, missing_echo 0.1, sweep 0.025 s" in text
    assert "position: drift 0.02 m" in text
    assert "wheels: slip 0.1" in text


def test_a_late_scan_is_entered_at_the_pose_at_which_it_was_measured(tmp_path):
    """A turning robot that took late scans for present ones would smear what it sees over its map."""
    turning = SCENE.replace('mission = "go_to"', 'mission = "go_to"\nrules = []').replace('x = "3 m"', 'x = "-3 m"')
    found = []
    for late in ("0 s", "0.1 s"):
        file = tmp_path / "scene.toml"
        file.write_text(
            turning.replace('"plane"', '"arena_box"') + f'[[agent.sensor]]\nname = "lidar"\nlatency = "{late}"\n'
        )
        sink = ListSink()
        run(str(file), Catalog(), seed=4, duration=2.0, report=False, sinks=[sink])
        cells = set()
        for event in sink.events:
            if isinstance(event, MapChanged):
                cells = (cells | set(event.occupied)) - set(event.cleared)
        found.append(len(cells))
    assert found[0] > 100
    assert found[1] < 1.15 * found[0]


@pytest.mark.parametrize("robot", [entry.name for entry in Catalog().list("robot")])
def test_every_shipped_robot_can_be_overridden(tmp_path, robot):
    """Also one with a base, whose tables are merged before."""
    device = Catalog().load_robot(robot).sensors[0].name
    overlay = f'[[agent.sensor]]\nname = "{device}"\nrate = "10 Hz"\n'
    file = tmp_path / "scene.toml"
    file.write_text(SCENE.replace('"jackal"', f'"{robot}"') + overlay)
    (agent,) = Catalog().load_scenario(str(file)).agents
    assert next(sensor.rate for sensor in Catalog().robot_of(agent).sensors if sensor.name == device) == 10.0
