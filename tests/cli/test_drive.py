"""`rocs-bt drive`: the preflight check, a dry run, and the files of a run on hardware."""

from __future__ import annotations

import json
import re

import pytest

from rocs_bt.cli.drive import HoldOutput
from rocs_bt.event import ActuatorCommanded, MotionHeld, MotionReleased, SensorRead
from rocs_bt.record import Recording

from ..pages import data_of
from ..udp_robot import UdpRobot, write_project

pytestmark = pytest.mark.usefixtures("awake")


@pytest.fixture
def robot():
    with UdpRobot() as robot:
        yield robot


def test_a_mission_on_hardware_gives_the_files_and_texts_of_a_run(rocs_bt, tmp_path, robot):
    write_project(tmp_path, robot.port, isolated=False)
    told = rocs_bt("drive", "real")
    assert told.code == 0
    assert re.match(r"R2 success in [2-9]\.\d s \(real, seed 1\)\n  moved [01]\.\d\d m; [2-9]\.\d s in all\n", told.out)
    assert "collision" not in told.out
    assert "clearance" not in told.out
    warning, *lines = told.err.splitlines()
    assert "nothing sends neutral to 'wheels'" in warning
    table = [line.split() for line in lines]
    assert [row[0] for row in table] == ["sensor", "sonar", "position", "orientation", "encoders"]
    sonar = table[1]
    assert sonar[1:3] == ["udp.py:UdpSensor", f"udp://127.0.0.1:{robot.port}"]
    assert (sonar[4:7], sonar[9:]) == (["of", "20", "Hz"], ["16", "fresh", "avoid_collision"])
    assert 5.0 < float(sonar[3]) < 40.0
    assert robot.commands[-1] == [0.0, 0.0]
    recording = Recording.open(tmp_path / "runs/real-1")
    assert recording.header.command == "rocs-bt drive real --seed 1"
    assert recording.header.start >= 0.5
    assert min(e.t for e in recording.events() if isinstance(e, SensorRead)) >= recording.header.start
    summary = json.loads((tmp_path / "runs/real-1/summary.json").read_text())
    agent = summary["agents"]["R2"]
    assert [agent[key] for key in ("collisions", "struck", "contacts", "min_clearance")] == [None] * 4
    assert agent["time_to_goal"] == pytest.approx(summary["sim_time"], abs=0.2)
    page = data_of(tmp_path / "runs/real-1/report.html")
    assert page["header"]["command"] == "rocs-bt drive real --seed 1"
    assert "collisions" not in dict(page["results"]["R2"]["numbers"])
    suggested = re.search(r"rocs-bt (replay .* --why [\d.]+)", told.out)[1]
    assert rocs_bt(*suggested.split()).code == 0


@pytest.mark.parametrize(
    ("silent", "extra", "shown", "reason"),
    [
        ({"sonar"}, {}, "no sample", "no sample: the robot has not sent 'sonar' yet"),
        ({}, {"sonar": ["nan"] * 2 + ["inf"] * 14}, "2 of 16 values NaN", "2 of 16 values NaN"),
        ({}, {"sonar": ["soon"]}, "exception", "exception: sensor 'sonar' raised ValueError: could not convert"),
    ],
)
def test_without_a_needed_sensor_nothing_moves(rocs_bt, tmp_path, robot, silent, extra, shown, reason):
    robot.silent, robot.extra = set(silent), extra
    write_project(tmp_path, robot.port)
    told = rocs_bt("drive", "real", "--wait", 0.7)
    assert told.code == 1
    row = next(line for line in told.err.splitlines() if line.startswith(" sonar"))
    assert shown in row
    assert "the robots were not started: 1 needed sensor without fresh values for 0.7 s.\n  R2/sonar: " in told.err
    assert reason in told.err
    assert "optional = true" in told.err
    assert not robot.moved
    assert not (tmp_path / "runs").exists()


def test_a_sensor_that_falls_silent_is_stale_and_one_that_comes_late_is_waited_for(rocs_bt, tmp_path, robot):
    robot.extra = {"orientation": ["nan"]}
    write_project(tmp_path, robot.port, isolated=False)
    seen = []

    class Late:
        """Lets the values come after the check has run a while."""

        def __call__(self, report):
            seen.append([state.sensor for state in report.missing])
            if report.t > 0.8:
                robot.extra = {}

    import rocs_bt as package

    found = package.drive("real", package.Catalog(tmp_path), preflight=Late(), duration=0.3)
    assert found.outcomes == {"R2": "timeout"}
    assert ["orientation"] in seen
    assert seen[-1] == []


def test_a_second_drive_keeps_the_recording_of_the_first(rocs_bt, tmp_path, robot):
    write_project(tmp_path, robot.port, isolated=False)
    assert rocs_bt("drive", "real", "--for", 0.2).out.startswith("R2 timeout")
    files = {path.name: path.read_bytes() for path in (tmp_path / "runs/real-1").iterdir()}
    for number in (2, 3):
        assert f"runs/real-1_{number}/report.html" in rocs_bt("drive", "real", "--for", 0.2).out
    assert {path.name: path.read_bytes() for path in (tmp_path / "runs/real-1").iterdir()} == files
    rocs_bt("drive", "real", "--for", 0.2, "--out", "runs/real-1")
    assert (tmp_path / "runs/real-1/run.mcap").read_bytes() != files["run.mcap"]
    assert not (tmp_path / "runs/real-1_4").exists()


def test_an_optional_sensor_is_not_waited_for(rocs_bt, tmp_path, robot):
    robot.silent = {"encoders"}
    write_project(tmp_path, robot.port, isolated=False)
    toml = tmp_path / "robots/udp_p3dx/robot.toml"
    toml.write_text(toml.read_text().replace('name = "encoders"\n', 'name = "encoders"\noptional = true\n'))
    told = rocs_bt("drive", "real", "--wait", 0, "--for", 0.2)
    assert re.search(r"^ encoders .* no sample +optional$", told.err, re.MULTILINE)
    assert "not started" not in told.err
    assert told.out.startswith("R2 timeout")


def test_a_dry_run_opens_no_actuator_and_records_what_would_be_sent(rocs_bt, tmp_path, robot):
    write_project(tmp_path, robot.port)
    told = rocs_bt("drive", "real", "--dry-run", "--for", 2.5)
    assert told.code == 1
    assert robot.commands == []
    sent = re.findall(r"^(\d+) s: R2/wheels would get \[(.*), (.*)\] \((\w+)\)$", told.err, re.MULTILINE)
    assert [line[0] for line in sent] == ["1", "2"]
    assert float(sent[0][1]) > 0.05
    assert sent[0][3] == "deliberative"
    recording = Recording.open(tmp_path / "runs/real-1")
    assert recording.header.command == "rocs-bt drive real --seed 1 --for 2.5 --dry-run"
    assert any(any(e.values) for e in recording.events() if isinstance(e, ActuatorCommanded))


@pytest.mark.parametrize("late", ["", "the process of actuator wheels is late"])
@pytest.mark.parametrize("wait", ["paused by the page, waiting for go", "emergency stop released, waiting for go"])
def test_whatever_else_holds_a_robot_a_person_reads_that_enter_is_missing(capsys, wait, late):
    output, robot = HoldOutput(), {"agent": "R2", "actuator": "wheels"}
    reasons = [wait, *([f"{wait}; {late}", f"{late}; {wait}", late] if late else [])]
    for t, reason in enumerate(reasons):
        output.emit(MotionHeld(t=t, reason=reason, **robot))
    output.emit(MotionReleased(t=9.0, by="the terminal", **robot))
    *held, free = capsys.readouterr().err.splitlines()
    assert ["press Enter" in line for line in held] == [wait in reason for reason in reasons]
    assert free == "9.00 s: R2 goes on"


def test_each_of_run_and_drive_names_the_other(rocs_bt, tmp_path, robot):
    write_project(tmp_path, robot.port)
    for command, scenario, hint in (
        ("run", "real", "To drive a real robot: rocs-bt drive SCENARIO."),
        ("drive", "exp1", "To simulate this robot: rocs-bt run SCENARIO."),
    ):
        told = rocs_bt(command, scenario)
        assert (told.code, told.out) == (2, "")
        assert hint in told.err


def test_wrong_options_are_reported(rocs_bt):
    assert rocs_bt("drive", "nowhere").code == 2
    assert rocs_bt("drive", "exp1", "--wait", "-1").code == 2
    assert rocs_bt("drive", "exp1", "--view").code == 2
