"""Whatever a person gets wrong: exit 2, a message that says what to do, never a traceback, and nothing written."""

from __future__ import annotations

import shutil

import pytest

from .conftest import refused

SCENARIO, ROBOT, RULES = "scenarios/first.toml", "robots/rover/robot.toml", "rules/keep_clear.toml"
WORLD, MISSION = "scenarios/worlds/yard.xml", "planners/missions/patrol.py"


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        (SCENARIO, 'world = "yard"', 'world = "{}.xml"'),
        (SCENARIO, 'robot = "rover"', 'robot = "{}"'),
        (SCENARIO, 'mission = "patrol"', 'mission = "{}.xml"'),
        (SCENARIO, '["keep_clear"]', '["{}.toml"]'),
        (ROBOT, 'model = "robot.xml"', 'model = "{}"'),
    ],
)
def test_paths_too_long_for_the_machine_are_names_that_do_not_exist(project, rocs_bt, file, old, new):
    path = project / file
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new.format("a/" + "x" * 5000)))
    refused(rocs_bt("check"), rf"{path.name}:\d+:1: .*xxx")


@pytest.mark.parametrize("gone", ["robots/rover/robot.xml", WORLD, MISSION, RULES])
def test_a_file_that_is_gone_is_told(project, rocs_bt, gone):
    (project / gone).unlink()
    refused(rocs_bt("run", "first"), r"no .*(is named|there is no)|there is no")


def test_all_faults_of_a_project_are_told_at_once(project, rocs_bt):
    for file, old, new in [
        (SCENARIO, 'x = "1.5 m"', 'x = "1.5 s"'),
        (RULES, "> 0.50 m", "> 0.50 s"),
        (ROBOT, 'rate = "20 Hz"', 'rate = "20 m"'),
        (WORLD, "</worldbody>", ""),
    ]:
        path = project / file
        path.write_text(path.read_text().replace(old, new))
    refused(rocs_bt("check"), r"first\.toml:8:1", r"keep_clear\.toml:6", r"robot\.toml:\d+:1: rate must", r"yard\.xml")


def test_new_does_not_write_over_anything(rocs_bt, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("years of work")
    refused(rocs_bt("new", "mine"), r"'mine' exists and is not empty\. Choose")
    assert [p.name for p in (tmp_path / "mine").iterdir()] == ["thesis.txt"]


def test_a_place_that_cannot_be_written_is_told(rocs_bt, tmp_path):
    (tmp_path / "occupied").write_text("a file, no folder")
    refused(rocs_bt("run", "exp1", "--for", "1", "--out", "occupied"), r"cannot use 'occupied': .*Choose another")


def test_two_files_of_one_name_are_told(project, rocs_bt):
    shutil.copy(project / MISSION, project / "planners" / "missions" / "patrol.xml")
    refused(rocs_bt("run", "first"), r"two mission files are named 'patrol'")


def test_a_defect_of_ours_is_exit_3(rocs_bt, monkeypatch):
    def broken(self, kind=None):
        raise ZeroDivisionError

    monkeypatch.setattr("rocs_bt.catalog.Catalog.list", broken)
    told = rocs_bt("list")
    assert told.code == 3
    assert "defect of rocs_bt" in told.text
