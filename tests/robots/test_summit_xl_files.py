"""Python files of the SUMMIT-XL's folder belong to each run of the robot, and to those of robots based on it."""

import re
import shutil

import pytest

from rocs_bt import Recording, replay, run
from rocs_bt.base.errors import InputError, RecordingError
from rocs_bt.catalog import Catalog
from rocs_bt.check import check_content
from rocs_bt.check.stub_agent import stub_agent
from rocs_bt.declare import fields_of
from rocs_bt.monitor import RangeMonitor

from .summit_xl import FOLDER, surround_monitor

ROBOTS = ("summit_xl", "summit_xl_localised", "summit_xl_shortsighted")


@pytest.fixture
def project(tmp_path):
    """A project with the robot in a folder of its own."""
    shutil.copytree(FOLDER, tmp_path / "robots" / FOLDER.name, ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path


def changed(project, name="encounter.py", text="\nNEAR = 0.21\n"):
    file = project / "robots" / FOLDER.name / name
    file.write_text(file.read_text("utf-8") + text, "utf-8")


@pytest.mark.parametrize("robot", ROBOTS)
def test_a_robot_and_those_based_on_it_have_one_class_of_monitor(robot):
    agent = stub_agent(Catalog().load_robot(robot), Catalog().load_class)
    assert type(next(m for m in agent.monitors if m.name == "range")) is surround_monitor.SurroundMonitor


@pytest.mark.parametrize("scenario", ["exp2", "exp3", "exp2_localised", "exp3_shortsighted"])
@pytest.mark.parametrize("file", ["surround_monitor.py", "encounter.py", "free_ground.py"])
def test_a_changed_file_changes_the_content_of_a_run(project, scenario, file):
    catalog = Catalog(project)
    before = catalog.digest(catalog.load_scenario(scenario))
    assert before == Catalog().digest(Catalog().load_scenario(scenario))
    changed(project, file)
    assert catalog.digest(catalog.load_scenario(scenario)) != before


def test_a_run_is_executed_again_from_its_recording_until_a_file_changes(project):
    result = run("exp2", Catalog(project), out=project / "run", duration=3.0, report=False)
    assert result.summary.trajectory_hash == run("exp2", Catalog(), duration=3.0).summary.trajectory_hash
    recording = Recording.open(result.recording)
    assert replay(recording, Catalog(project)) is None
    changed(project)
    with pytest.raises(RecordingError, match="content of 'exp2' has changed"):
        replay(recording, Catalog(project))


def test_a_check_reports_a_fault_at_the_file_and_line_of_a_sibling(project):
    changed(project, text="NEAR = 1 / 0\n")
    place = project / "robots" / FOLDER.name / "encounter.py"
    lines = len(place.read_text("utf-8").splitlines())
    faults = check_content([project / "robots"]).faults
    assert [(fault.file, fault.line) for fault in faults] == [(place, lines)]
    assert "ZeroDivisionError" in faults[0].message
    assert not check_content([project / "robots"], code=False).has_errors


def test_the_readme_lists_the_monitors_parameters_and_signals(rig):
    text = FOLDER.with_name("README.md").read_text("utf-8").split("## Three-beam sensing")[1].split("\n## ")[0]
    listed = {name for row in re.findall(r"^\| (`.*?) \|", text, re.MULTILINE) for name in re.findall(r"`(\w+)`", row)}
    own, base = ({f.name for f in fields_of(cls)} for cls in (surround_monitor.SurroundMonitor, RangeMonitor))
    signals = {signal.name for signal in rig.monitor.signals()} - {"ranges", *surround_monitor.GROUPS}
    assert listed == (own - base) | signals


def test_without_code_the_robot_is_refused():
    with pytest.raises(InputError, match=r"surround_monitor\.py: this Python content may not run"):
        Catalog(code=False).load_scenario("exp2")
