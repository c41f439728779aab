"""What `check` calls an error is what `run` refuses, with the same words; `run` prints the warnings of `check`."""

from __future__ import annotations

import random
import re
from collections import Counter
from concurrent.futures import Executor
from contextlib import closing, suppress
from pathlib import Path

import pytest

from rocs_bt import run, sweep
from rocs_bt.base import files
from rocs_bt.base.errors import InputError, RocsError
from rocs_bt.catalog import Catalog
from rocs_bt.check import check_content, scenario, stub_agent
from rocs_bt.cli.main import call
from rocs_bt.compare import SweepOptions, load_family, scenes_of
from rocs_bt.reactive import include
from rocs_bt.record import SubtreeSwap
from rocs_bt.running import Run, build_agents
from rocs_bt.search.run_search import SearchOptions, search
from rocs_bt.search.space import SearchSpace

from ..messages.table import Row, rows, write_project

SOAK = pytest.mark.soak
GROUPS = {"robot", "robot_code", "rules", "mission_xml", "node", "scenario", "world"}
ERRORS = [row for row in rows() if row.group in GROUPS and row.file != "scenarios/late.toml"]  # another scenario
WARNINGS = [row for row in rows() if row.group == "warning"]


def named(table: list[Row], every: int) -> list[object]:
    """Cases of a table; all but every n-th one are tried by `make soak` only."""
    return [pytest.param(row, id=row.title, marks=() if i % every == 0 else SOAK) for i, row in enumerate(table)]


def judged(project: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, faults: list[Row]):
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
        with closing(Run(catalog.load_scenario("own"), catalog)) as prepared:
            prepared.prepare()
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
    faults = random.Random(seed).sample([*ERRORS, *WARNINGS], 1 + seed % 2)
    if len({fault.file for fault in faults}) < len(faults):
        del faults[1:]  # the second may be gone with the text that the first replaces
    findings = judged(tmp_path, capsys, monkeypatch, faults)
    assert findings.has_errors or not refused_by_the_engine(tmp_path)


PLANNER = 'format = "planner/1"\ndoc = "Own."\nmission = "own"\nrules = ["own"]\n\n[parameters]\ngoal = "goal"\n'
DOORS = {
    "run": lambda catalog: run("own", catalog, duration=0.05),
    "sweep": lambda catalog: sweep(["@rover", "mine"], ["own"], (1, 2), catalog=catalog, executor=Here()),
    "family": lambda catalog: sweep(["mine@rover"], scenes_of("barn_like", 2), catalog=catalog, executor=Here()),
    "search": lambda catalog: search(
        catalog.load_planner("mine@rover"),
        SearchSpace.of(load_family(catalog, "barn_like"), {}, {}),
        SearchOptions(budget=1),
        catalog=catalog,
        executor=Here(),
    ),
}


class Here(Executor):
    """Executor that must not get an episode."""

    def submit(self, fn, /, *args, **kwargs):
        raise AssertionError("an episode is played")


@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize("fault", named(ERRORS, 13))
def test_an_error_is_refused_at_every_door_before_an_episode_is_played(tmp_path, door, fault):
    scenario = write_project(tmp_path, [fault])
    (tmp_path / "planners/mine.toml").write_text(PLANNER)
    expected = [each for each in check_content([scenario]).faults if not each.warning]
    if door in ("family", "search"):
        expected = [
            each for each in expected if Path(str(each.file)).suffix != ".toml" or each.file.parent.name == "rules"
        ]
        if fault.file.startswith("scenarios/") or not expected:
            pytest.skip("a family makes worlds and goals of its own, in which this fault cannot be")
    with pytest.raises(InputError) as caught:
        DOORS[door](Catalog(tmp_path))
    assert {str(each) for each in expected} <= {str(each) for each in caught.value.faults}


@pytest.mark.parametrize("fault", named(WARNINGS, 3))
def test_a_sweep_gives_each_warning_once(tmp_path, fault):
    scenario, given = write_project(tmp_path, [fault]), []
    options = SweepOptions(warned=given.append, stop_when=lambda records: True)
    expected = [each for each in check_content([scenario]).warnings if each.file and each.file.parent.name != "rover"]
    with pytest.raises(AssertionError, match="played"):
        sweep(["@rover"], ["own"], (1, 2), catalog=Catalog(tmp_path), executor=Here(), options=options)
    (warnings,) = given
    assert len({*warnings}) == len(warnings)
    assert {*expected} <= {*warnings}


SHIPPED = [entry.name for entry in Catalog().list("scenario")]


@pytest.mark.parametrize("name", [pytest.param(n, marks=() if n in ("exp1", "exp3") else SOAK) for n in SHIPPED])
def test_a_run_reads_each_file_once_and_builds_each_agent_once_and_one_that_its_check_moves(monkeypatch, name):
    opened, built = Counter(), Counter()
    open_file, build = files.open_regular, build_agents.build_agent
    monkeypatch.setattr(files, "open_regular", lambda path, *most: opened.update([path]) or open_file(path, *most))
    monkeypatch.setattr(build_agents, "build_agent", lambda name, *a, **k: built.update([name]) or build(name, *a, **k))
    with suppress(InputError):  # robots of ROS 2 cannot be simulated
        run(name, Catalog(), duration=0.05)
    assert opened
    assert [path for path, count in opened.items() if count > 1] == []
    assert set(built.values()) <= {1, 2}


def test_a_rule_file_is_checked_with_one_agent_for_each_robot(monkeypatch):
    built, build = Counter(), stub_agent.build_agent

    def count(name, devices, *given, **more):
        built.update([devices.robot.name])
        return build(name, devices, *given, **more)

    monkeypatch.setattr(stub_agent, "build_agent", count)
    findings = check_content([Catalog().find("rules", "avoid_collision").path])
    assert not findings.has_errors
    assert built
    assert set(built.values()) == {1}


def test_a_rule_file_is_read_once_for_each_robot(tmp_path, monkeypatch):
    write_project(tmp_path)
    rules, parsed, parse = tmp_path / "rules/own.toml", list[Path](), include.read_toml
    monkeypatch.setattr(include, "read_toml", lambda file: parsed.append(file) or parse(file))
    assert not check_content([rules]).has_errors
    assert parsed == [rules]


def test_a_file_that_changes_after_its_check_does_not_change_the_run(tmp_path, monkeypatch):
    write_project(tmp_path)
    rules, analysed = tmp_path / "rules/own.toml", scenario.analyse_fit
    before = run("own", Catalog(tmp_path), duration=0.05).summary.content_hash
    monkeypatch.setattr(scenario, "analyse_fit", lambda *given: rules.write_text("no rules") and analysed(*given))
    assert run("own", Catalog(tmp_path), duration=0.05).summary.content_hash == before
    with pytest.raises(InputError):
        run("own", Catalog(tmp_path), duration=0.05)


def fail(*given):
    raise ZeroDivisionError("of the program")


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"missions": {"R1": fail}}, ZeroDivisionError, "of the program"),
        ({"prepare": fail}, ZeroDivisionError, "of the program"),
        ({"swaps": [SubtreeSwap.read("nowhere=own@0.02")]}, InputError, "no node is named 'nowhere'"),
        (
            {"swaps": [SubtreeSwap.read("nowhere=own@99")]},
            InputError,
            "the swap 'nowhere=own@99' is not within the run",
        ),
    ],
)
def test_what_the_program_gives_is_no_fault_of_the_scenario(tmp_path, options, error, message):
    write_project(tmp_path)
    with pytest.raises(error, match=re.escape(message)) as caught:
        run("own", Catalog(tmp_path), duration=0.05, **options)
    assert "scenarios/own.toml" not in str(caught.value)


def test_a_mission_that_a_program_gives_is_built_by_the_run_only(tmp_path):
    write_project(tmp_path)
    built = []
    result = run(
        "own", Catalog(tmp_path), duration=0.05, missions={"R1": lambda mission: built.append(1) or mission.wait(1.0)}
    )
    assert built == [1]
    assert result.warnings == ()


def test_an_exception_in_a_check_is_not_swallowed(tmp_path, monkeypatch):
    write_project(tmp_path)
    monkeypatch.setattr("rocs_bt.check.feasible._EASY", "a half")
    monkeypatch.chdir(tmp_path)
    assert isinstance(check_content([tmp_path]).defect, TypeError)
    assert call(["run", "own"]) == 3
