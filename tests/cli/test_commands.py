"""What the commands do when all is well."""

from __future__ import annotations

import json
import operator
import os
import subprocess
import sys
from pathlib import Path

import pytest

from rocs_bt.check import check as checking


def test_list_as_json_has_what_a_script_needs(rocs_bt):
    entries = json.loads(rocs_bt("list", "--json").out)
    assert ("robot", "pioneer_p3dx") in {(e["kind"], e["name"]) for e in entries}
    for entry in entries:
        assert set(entry) == {"name", "kind", "path", "doc", "origin"}
        assert Path(entry["path"]).is_file()
        assert entry["doc"]


@pytest.mark.parametrize("kind", ["robot", "robots"])
def test_list_can_be_of_one_kind(rocs_bt, kind):
    assert {e["kind"] for e in json.loads(rocs_bt("list", kind, "--json").out)} == {"robot"}


def test_list_for_people_tells_what_is_theirs(project, rocs_bt):
    told = rocs_bt("list").out
    assert "patrol" in told
    (line,) = (line for line in told.splitlines() if line.split()[:1] == ["patrol"])
    assert line.endswith("(project)")


def test_show_draws_the_tree_and_the_parameters(project, rocs_bt):
    told = rocs_bt("show", "patrol").out
    assert "cruise = 0.4 m/s" in told
    nodes = [line for line in told.splitlines() if line.startswith(("patrol  ", "├─", "└─"))]
    assert nodes == [
        "patrol  [Sequence]",
        "├─ GoTo gate",
        "├─ wait 1 s  [Wait]",
        "├─ GoTo dock",
        "└─ wait 1 s  [Wait]",
    ]
    assert "goal = gate" in told


def test_a_goal_inside_of_something_is_told(project, rocs_bt):
    world = project / "scenarios" / "worlds" / "yard.xml"
    world.write_text(world.read_text().replace('pos="0 -1.6 0.25"', 'pos="1.5 1.5 0.25"'))
    told = rocs_bt("check", "scenarios/first.toml")
    assert told.code == 0
    assert "warning: the goal 'dock' of R1 cannot be reached: rover has no free pose within 0.1 m of it" in told.out
    assert "inside 'crate'" in told.out


def test_a_goal_at_which_a_reflex_always_fires_is_told(project, rocs_bt):
    world, rules = project / "scenarios" / "worlds" / "yard.xml", project / "rules" / "keep_clear.toml"
    world.write_text(world.read_text().replace('pos="0 -1.6 0.25"', 'pos="1.5 2.05 0.25"'))
    # Without the cap by goal_distance, and on all sides.
    rules.write_text(rules.read_text().replace("min(front) < min(0.40 m,", "min(sonar) < max(0.60 m,"))
    told = rocs_bt("check", "scenarios/first.toml")
    assert "at every free pose within 0.1 m of it a reflex fires" in told.out
    assert "keep_clear/TurnAway" in told.out


def test_check_prints_faults_and_summary_on_one_stream(project, rocs_bt):
    scenario = project / "scenarios" / "first.toml"
    scenario.write_text(scenario.read_text().replace('x = "1.5 m"', 'x = "1.5 s"'))
    told = rocs_bt("check", scenario)
    fault, summary = told.out.splitlines()[0], told.out.splitlines()[-1]
    assert fault.startswith(f"{scenario}:8:1: x must be in m")
    assert summary == "1 file checked: 2 errors, 0 warnings."
    assert told.err == ""


def test_check_looks_at_every_goal(project, rocs_bt):
    scenario = project / "scenarios" / "first.toml"
    text = scenario.read_text()
    assert text.count('x = "1.5 m"\ny = "0 m"') == 1  # the gate, where the robot goes first
    scenario.write_text(text.replace('x = "1.5 m"\ny = "0 m"', 'x = "0 m"\ny = "-1.6 m"'))
    told = rocs_bt("check", scenario)
    assert f"{scenario}:6: warning: the goal 'gate' of R1 cannot be reached" in told.out
    assert "inside 'crate'" in told.out


def test_check_of_a_defect_tells_the_faults_and_exits_with_3(project, rocs_bt, monkeypatch):
    monkeypatch.setitem(checking._CHECKERS, "rules", operator.truediv)  # which takes no such things
    scenario = project / "scenarios" / "first.toml"
    scenario.write_text(scenario.read_text().replace('x = "1.5 m"', 'x = "1.5 s"'))
    told = rocs_bt("check")
    assert told.code == 3
    assert "x must be in m" in told.out
    assert "keep_clear.toml: checking this file raised TypeError: unsupported" in told.out
    assert "Traceback" in told.err


def test_new_does_not_nest_projects(project, rocs_bt):
    told = rocs_bt("new", "inner")
    assert told.code == 2
    assert f"'inner' is inside the project '{project}'. Projects cannot be nested." in told.err
    assert "rocs-bt new NAME --kind mission|rules|robot|scenario|planner" in told.err
    assert not (project / "inner").exists()
    assert rocs_bt("new", "robots/deep/inner").code == 2
    assert rocs_bt("new", "../beside").code == 0


def test_check_as_json_has_every_place(project, rocs_bt):
    scenario = project / "scenarios" / "first.toml"
    scenario.write_text(scenario.read_text().replace('x = "1.5 m"', 'x = "1.5 s"'))
    told = rocs_bt("check", scenario, "--json")
    (first, *_) = json.loads(told.out)["faults"]
    assert told.code == 2
    assert (first["file"], first["line"], first["column"], first["warning"]) == (str(scenario), 8, 1, False)


def test_check_runs_no_code_where_it_is_told_so(project, rocs_bt):
    (project / "planners" / "missions" / "bomb.py").write_text(
        '"""Bang."""\nopen("ran", "w")\n\n\ndef build(mission):\n    pass\n'
    )
    assert rocs_bt("check", "--no-code").code == 0
    assert not (project / "ran").exists()


def test_run_writes_everything_and_tells_the_outcome(project, rocs_bt):
    told = rocs_bt("run", "first")
    assert told.code == 0, told.out + told.err
    assert told.out.startswith("R1 success in ")
    assert "Report: runs/first-1/report.html" in told.out
    assert "Try next: rocs-bt replay runs/first-1" in told.out
    assert {"summary.json", "run.mcap", "report.html"} <= {p.name for p in (project / "runs" / "first-1").iterdir()}
    assert rocs_bt("replay", "runs/first-1").code == 0
    assert "R1" in rocs_bt("replay", "runs/first-1", "--why", "3").out
    plotted = rocs_bt("plot", "runs/first-1").out.split()
    assert {Path(p).suffix for p in plotted} == {".png", ".svg"}
    assert all(Path(p).stat().st_size > 1000 for p in plotted)


def test_a_run_that_ends_too_soon_is_exit_1(project, rocs_bt):
    told = rocs_bt("run", "first", "--for", "1", "--no-report", "--json", "--out", "short")
    summary = json.loads(told.out)
    assert told.code == 1
    assert summary["agents"]["R1"]["outcome"] == "timeout"
    assert summary["sim_time"] == pytest.approx(1.0)
    assert not (project / "short" / "report.html").exists()


def test_the_same_seed_is_the_same_run_and_another_is_not(project, rocs_bt):
    def trajectory(seed):
        out = rocs_bt("run", "first", "--for", "2", "--no-report", "--json", "--seed", seed).out
        return json.loads(out)["trajectory_hash"]

    assert trajectory(1) == trajectory(1) != trajectory(2)


def test_a_new_project_passes_its_own_tests_unedited(project):
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
    done = subprocess.run(command, cwd=project, capture_output=True, text=True, env={**os.environ, "COLUMNS": "100"})
    assert done.returncode == 0, done.stdout + done.stderr
    assert "3 passed" in done.stdout


def test_doctor_tells_of_everything(rocs_bt):
    told = rocs_bt("doctor")
    assert told.code == 0, told.out
    for what in (
        "python",
        "packages",
        "content",
        "GL egl",
        "GL osmesa",
        "display",
        "browser",
        "C compiler",
        "kernel",
        "manual",
    ):
        assert what in told.out


def test_doctor_says_when_something_needed_is_missing(rocs_bt, monkeypatch):
    monkeypatch.setattr("importlib.metadata.requires", lambda name: ["numpy>=2", "warpdrive>=1"])
    told = rocs_bt("doctor")
    assert told.code == 3
    assert "missing: warpdrive" in told.out


def test_help_names_every_command(rocs_bt):
    told = rocs_bt("--help").out
    for command in ("run", "replay", "plot", "list", "show", "check", "identify", "new", "doctor"):
        assert f"  {command} " in told
