"""What `check` calls an error is what `run` refuses, with the same words; `run` prints the warnings of `check`."""

from __future__ import annotations

from pathlib import Path

import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.check import check_content
from rocs_bt.cli.main import call
from rocs_bt.errors import RocsError
from rocs_bt.simulation import RunOptions
from rocs_bt.simulation.ready_run import set_up

from .faulty_projects import ERRORS, WARNINGS, two_faults, write_project

Fault = tuple[str, str, str]
SOAK = pytest.mark.soak


def named(table: tuple[Fault, ...], every: int) -> list[object]:
    """Cases of a table; all but every n-th one are tried by `make soak` only."""
    return [
        pytest.param(fault, id=f"{i}-{Path(fault[0]).name}", marks=() if i % every == 0 else SOAK)
        for i, fault in enumerate(table)
    ]


def judged(project: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, faults: list[Fault]):
    """Write a project with faults, compare the commands, and return the findings of the check."""
    scenario = write_project(project, faults)
    findings = check_content([scenario])
    assert findings.defect is None
    monkeypatch.chdir(project)
    code = call(["run", "own", "--for", "0.05", "--no-report", "--out", str(project / "out")])
    lines = capsys.readouterr().err.splitlines()
    errors = [fault for fault in findings.faults if not fault.warning]
    assert (code == 2) == bool(errors), (code, lines, errors)
    if errors:
        assert lines == str("\n".join(map(str, errors))).splitlines()
        assert not (project / "out").exists()
    else:
        assert lines[: len(findings.warnings)] == [str(fault) for fault in findings.warnings]
    return findings


def refused_by_the_engine(project: Path) -> bool:
    """Whether agents and world cannot be built, found without any check."""
    catalog = Catalog(project)
    try:
        set_up(catalog.load_scenario("own"), catalog, RunOptions())
    except RocsError:
        return True
    return False


def test_the_good_project_has_no_faults(tmp_path, capsys, monkeypatch):
    assert judged(tmp_path, capsys, monkeypatch, []).faults == ()
    assert not refused_by_the_engine(tmp_path)
    assert check_content([tmp_path]).faults == ()


@pytest.mark.parametrize("fault", named(ERRORS, 4))
def test_an_error_is_refused_by_run(tmp_path, capsys, monkeypatch, fault):
    findings = judged(tmp_path, capsys, monkeypatch, [fault])
    assert findings.has_errors
    of_project = {str(each) for each in check_content([tmp_path]).faults if not each.warning}
    assert {str(each) for each in findings.faults if not each.warning} <= of_project


@pytest.mark.parametrize("fault", named(WARNINGS, 3))
def test_a_warning_is_printed_by_run(tmp_path, capsys, monkeypatch, fault):
    findings = judged(tmp_path, capsys, monkeypatch, [fault])
    assert findings.warnings
    assert not findings.has_errors
    assert not refused_by_the_engine(tmp_path)


@pytest.mark.parametrize("seed", [*range(8), *(pytest.param(seed, marks=SOAK) for seed in range(8, 200))])
def test_check_finds_what_the_engine_refuses(tmp_path, capsys, monkeypatch, seed):
    findings = judged(tmp_path, capsys, monkeypatch, two_faults(seed))
    assert findings.has_errors or not refused_by_the_engine(tmp_path)


def test_an_exception_in_a_check_is_not_swallowed(tmp_path, monkeypatch):
    write_project(tmp_path)
    monkeypatch.setattr("rocs_bt.check.feasible._EASY", "a half")
    monkeypatch.chdir(tmp_path)
    assert isinstance(check_content([tmp_path]).defect, TypeError)
    assert call(["run", "own"]) == 3
