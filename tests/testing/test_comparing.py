"""Comparisons of planners as tests of a project: marks, options, results, commands that work."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys

import pytest

from rocs_bt.cli.main import call

TESTS = """
import pytest

pytestmark = [pytest.mark.planners("brisk", "careful"), pytest.mark.scenarios("first", seeds=6)]


def test_better(comparison):
    comparison.assert_better("careful", "brisk", "time")


def test_rate(comparison):
    comparison.assert_rate("brisk", lower=0.99)


def test_always(comparison):
    comparison.assert_always("brisk", "min_clearance > 0.05 m")
    comparison.assert_always("brisk", "speed < 0.3 m/s")


@pytest.mark.scenarios("first")
@pytest.mark.planners("none_such")
def test_unknown(comparison):
    pass
"""


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    folder = tmp_path_factory.mktemp("project") / "yard"
    assert call(["new", str(folder)]) == 0
    return folder


def run_tests(project, *arguments):
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "--color=no", "-p", "no:cacheprovider", *arguments],
        cwd=project,
        capture_output=True,
        text=True,
    )
    return done.returncode, done.stdout + done.stderr


@pytest.fixture(scope="module")
def shipped(project):
    """The test that a new project has."""
    return run_tests(project, "tests/test_planners.py")


def test_a_new_project_has_a_comparison_that_passes_and_keeps_its_episodes(project, shipped):
    assert shipped[0] == 0, shipped[1]
    assert "1 passed" in shipped[1]
    assert (project / "runs" / "compare" / "episodes.sqlite").is_file()


def test_all_results_are_told_apart_and_the_commands_work(project, shipped, monkeypatch, capsys):
    (project / "tests" / "test_more.py").write_text(TESTS)
    code, told = run_tests(project, "tests/test_more.py", "--compare-jobs=1")
    assert code == 1
    assert re.search(r"^F\?FE", told)
    assert "careful is not better than brisk in time" in told
    assert "brisk is better in 6 of 6 episodes:" in told
    assert re.search(r"inconclusive =+\ntests/test_more.py::test_rate\ninconclusive whether it is at least 0.99", told)
    assert "1 inconclusive: neither confirmed nor refuted, so the run fails" in told
    assert "brisk violates 'speed < 0.3 m/s' in 6 of 6 episodes" in told
    assert re.search(r"no planner .*'none_such'.*brisk, careful", told)
    assert re.search(r"2 failed, 1 inconclusive, 1 error|2 failed, 1 error, 1 inconclusive", told)

    command = re.search(r"rocs-bt (run first --planner brisk --seed \d+)", told)[1]
    monkeypatch.chdir(project)
    assert call(shlex.split(command)) == 0
    assert "R1 success" in capsys.readouterr().out


def test_inconclusive_passes_where_that_is_wanted(project, shipped):
    (project / "tests" / "test_more.py").write_text(TESTS)
    code, told = run_tests(project, "tests/test_more.py", "-k", "rate", "--inconclusive=pass")
    assert code == 0
    assert "and the run passes" in told


def test_without_its_marks_the_fixture_says_which_it_needs(project):
    (project / "tests" / "test_bare.py").write_text("def test_bare(comparison):\n    pass\n")
    code, told = run_tests(project, "tests/test_bare.py")
    assert code != 0
    assert '@pytest.mark.planners("tree") and @pytest.mark.scenarios("exp1", seeds=20)' in told
