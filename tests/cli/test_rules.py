"""`rocs-bt rules`, `requirements` and `show` of rule files; rule files that change while a run goes on."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from rocs_bt import run
from rocs_bt.agent import RuleWatch
from rocs_bt.catalog import Catalog
from rocs_bt.cli.main import call
from rocs_bt.event import ListSink, RuleChanged, RulesReplaced
from rocs_bt.record import Recording

from ..pages import data_of

RULES = "rules/keep_clear.toml"


LATCHED = """format = "reflex/1"
[rule.Halt]
when = "goal_distance < 2.5 m"
until = "goal_distance > 2.7 m"
priority = 10
[rule.Halt.action]
name = "Stop"
"""


def test_refirings_while_latched_are_counted_apart_from_activations(project, rocs_bt):
    (project / RULES).write_text(LATCHED)
    told = rocs_bt("run", "first", "--for", "4", "--out", "out")
    assert told.code == 1
    summary = json.loads((project / "out/summary.json").read_text())
    agent = summary["agents"]["R1"]
    events = [e for e in Recording.open(project / "out").events() if isinstance(e, RuleChanged)]
    again = [e.refirings for e in events if e.phase == "fired again"]
    assert again == list(range(1, agent["reflex_refirings"] + 1))
    assert len(again) > 20  # a period each
    assert agent["reflex_activations"] == 1
    assert re.search(rf"  1 reflex activation \(\d+ % of the time\), {len(again)} re-firings while latched", told.out)
    numbers = dict(data_of(project / "out/report.html")["results"]["R1"]["numbers"])
    assert (numbers["reflex activations"], numbers["fired again while latched"]) == ("1", str(len(again)))


def test_check_warns_of_a_rule_that_can_hold_the_robot_for_ever(project, rocs_bt):
    (project / RULES).write_text(LATCHED)
    told = rocs_bt("check", "rules")
    assert told.code == 0
    found = told.out + told.err
    assert re.search(r"rules/keep_clear.toml:6:1: warning: Halt can hold the robot for ever: Stop does not move", found)
    assert rocs_bt("check", "rules", "--strict").code == 2


def move_tests(project: Path) -> Path:
    """Move the tests of the project's rule file to a file of their own."""
    rules, apart = project / RULES, project / "rules/tests/keep_clear.toml"
    text, tests = rules.read_text().split("# Run by", 1)
    rules.write_text(text)
    apart.parent.mkdir()
    apart.write_text('format = "reflex-tests/1"\n# Run by' + tests)
    return apart


class TestTests:
    def test_all_shipped_rule_files_carry_tests_that_pass(self, rocs_bt):
        told = rocs_bt("rules", "test")
        assert (told.code, told.err) == (0, "")
        *inactive, last = told.out.splitlines()
        assert re.fullmatch(r"\d+ tests: (\d+) passed, 0 failed\.", last)
        among, avoid = inactive
        assert re.search(r"among_people.toml: rule YieldSideways is inactive: robot 'jackal' has no", among)
        assert re.search(r"avoid_collision.toml: rule AvoidCourse is inactive: robots .*, .* have no", avoid)

    def test_one_that_fails_says_where_and_what_was_seen(self, project, rocs_bt):
        file = project / RULES
        file.write_text(file.read_text().replace('turn = "60 deg" }', 'turn = "30 deg" }'))
        told = rocs_bt("rules", "test")
        assert told.code == 1
        assert told.out == "1 test: 0 passed, 1 failed.\n"
        assert re.search(
            r"rules/keep_clear.toml:\d+:\d+: failed: keep_clear/TurnAway, 'turns toward the freer", told.err
        )
        assert "on rover: at t = 0 s turn is 1.047" in told.err

    def test_a_file_without_tests_and_one_that_is_wrong(self, project, rocs_bt):
        file = project / RULES
        text = file.read_text()
        file.write_text(text[: text.index("# Run by")])
        told = rocs_bt("rules", "test", RULES)
        assert (told.code, told.out) == (0, "0 tests: 0 passed, 0 failed.\n")
        assert "has no test. Add one as [[rule.NAME.test]], here or in " in told.err
        file.write_text(text.replace("0.39 m", "0.39 s"))
        told = rocs_bt("rules", "test", "keep_clear")
        assert told.code == 2
        assert "keep_clear.toml:26" in told.err
        assert "'front' must be in m" in told.err

    def test_tests_in_a_file_of_their_own(self, project, rocs_bt):
        apart = move_tests(project)
        for named in ([], [RULES], ["keep_clear"], [str(apart.relative_to(project))]):
            assert rocs_bt("rules", "test", *named).out == "1 test: 1 passed, 0 failed.\n"
        assert [entry["name"] for entry in json.loads(rocs_bt("list", "rules", "--json").out)].count("keep_clear") == 1
        apart.write_text(apart.read_text().replace('turn = "60 deg" }', 'turn = "30 deg" }'))
        told = rocs_bt("rules", "test")
        assert (told.code, told.out) == (1, "1 test: 0 passed, 1 failed.\n")
        assert re.search(
            r"rules/tests/keep_clear.toml:\d+:\d+: failed: keep_clear/TurnAway, 'turns toward the freer", told.err
        )

    @pytest.mark.parametrize(
        ("written", "instead", "told"),
        [
            ("rule.TurnAway", "rule.TurnAwy", "no rule is named 'TurnAwy'. Did you mean 'TurnAway'?"),
        ],
    )
    def test_faults_in_a_file_of_tests(self, project, rocs_bt, written, instead, told):
        apart = move_tests(project)
        apart.write_text(apart.read_text().replace(written, instead, 1))
        for command in (["check", "."], ["check", "rules"], ["check", str(apart)], ["rules", "test"]):
            found = rocs_bt(*command)
            assert found.code == 2
            assert re.search(r"rules/tests/keep_clear.toml:\d+:\d+: ", found.out + found.err)
            assert told in found.out + found.err

    def test_tests_of_a_rule_file_that_does_not_exist(self, project, rocs_bt):
        move_tests(project).rename(project / "rules/tests/keep_clean.toml")
        for folder in (".", "rules", "rules/tests"):
            found = rocs_bt("check", folder)
            assert found.code == 2
            told = found.out + found.err
            assert re.search(r"keep_clean.toml: there is no rule file .*rules/keep_clean.toml for these tests", told)

    def test_for_a_robot_of_ones_choice(self, rocs_bt):
        told = rocs_bt("rules", "test", "braitenberg", "--robot", "summit_xl")
        assert told.code == 2
        assert "left_gap has 3 values" in told.err

    def test_pytest_runs_them_too(self, project):
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "rules"]
        assert "1 passed" in subprocess.run(command, cwd=project, capture_output=True, text=True).stdout
        file = project / RULES
        file.write_text(file.read_text().replace('turn = "60 deg" }', 'turn = "30 deg" }'))
        done = subprocess.run(command, cwd=project, capture_output=True, text=True)
        assert done.returncode == 1
        assert "keep_clear.toml:28:1: at t = 0 s turn is" in done.stdout


SIDEWAYS = """
[rule.AvoidSideways]
require = ["lateral_speed"]
when = "abs(lateral_speed) > 0.1 m/s"
until = "abs(lateral_speed) < 0.05 m/s"
priority = 99
action = { name = "Stop" }
[[rule.AvoidSideways.test]]
given = { lateral_speed = "0.2 m/s" }
at = [{ t = "0 s" }]
expect = [{ t = "0 s", fires = true }]
"""
INACTIVE = "rule AvoidSideways is inactive: robot 'rover' has no signal 'lateral_speed'."


class TestInactiveRules:
    """A rule that requires a signal that the robot of the project lacks."""

    def test_every_command_names_it(self, project, rocs_bt):
        file = project / RULES
        file.write_text(file.read_text() + SIDEWAYS)
        told = rocs_bt("check", "--strict")
        assert told.code == 0
        assert re.search(r"keep_clear.toml:31:1: note: " + re.escape(INACTIVE), told.out)
        told = rocs_bt("rules", "test")
        assert told.code == 0
        assert told.out.endswith(f"keep_clear.toml: {INACTIVE}\n1 test: 1 passed, 0 failed.\n")
        assert rocs_bt("show", "keep_clear", "--robot", "rover").out.endswith(INACTIVE + "\n")
        assert "inactive" not in rocs_bt("run", "first", "--for", "1", "--out", "out").out  # said by check and report
        summary = json.loads((project / "out/summary.json").read_text())
        assert summary["agents"]["R1"]["inactive_rules"] == {"keep_clear/AvoidSideways": ["lateral_speed"]}
        assert data_of(project / "out/report.html")["inactive"] == {"R1": {"keep_clear/AvoidSideways": INACTIVE}}
        (project / "out/summary.json").unlink()
        assert rocs_bt("report", "out").code == 0
        assert INACTIVE in rocs_bt("replay", "out", "--why", "0.5", "--all").out
        assert rocs_bt("replay", "out").code == 0
        told = rocs_bt("rules", "replay", "keep_clear", "out")
        assert (told.code, told.err) == (0, INACTIVE + "\n")
        assert "AvoidSideways" not in told.out
        for command in ("replay", "tune"):
            more = ["--threshold", "near"] if command == "tune" else []
            told = rocs_bt("rules", command, "keep_clear", "out", "--rule", "AvoidSideways", *more)
            assert told.code == 2
            assert "rule AvoidSideways is inactive: the recorded robot has no signal 'lateral_speed'." in told.err

    def test_a_required_signal_that_no_robot_has(self, project, rocs_bt):
        file = project / RULES
        file.write_text(file.read_text() + SIDEWAYS.replace('["lateral_speed"]', '["latteral_speed"]'))
        for command in (["check"], ["check", "scenarios/first.toml"], ["run", "first"]):
            told = rocs_bt(*command)
            assert told.code == 2
            text = "keep_clear.toml:31:1: no robot has a signal 'latteral_speed'. Did you mean 'lateral_speed'?"
            assert text in told.out + told.err

    def test_a_file_of_which_all_rules_are_inactive(self, project, rocs_bt):
        (project / RULES).write_text('format = "reflex/1"' + SIDEWAYS)
        told = rocs_bt("check", RULES, "--strict")
        assert told.code == 2
        text = "warning: all rules of 'keep_clear' are inactive: robot 'rover' has no signal 'lateral_speed'."
        assert text in told.out
        assert text in rocs_bt("run", "first", "--for", "0.1").err

    def test_a_file_that_no_scenario_uses_is_checked_for_a_robot_with_the_signals(self, project, rocs_bt):
        bearing = SIDEWAYS.replace('["lateral_speed"]', '["peer_bearing"]')
        bearing = bearing[: bearing.index("[[")].replace("lateral_speed", "peer_bearing[0]")
        (project / "rules/own.toml").write_text('format = "reflex/1"' + bearing)
        told = rocs_bt("check", "rules/own.toml")
        assert told.code == 2
        assert "own.toml:4:9: 'abs(peer_bearing[0]) > 0.1 m/s': '>' needs one unit" in told.out
        assert "is inactive" not in told.out

    def test_a_change_during_a_run_names_it(self, project):
        file, sink = project / RULES, ListSink()
        before = file.read_text()

        def progress(t):
            if t >= 0.5 and file.read_text() == before:
                file.write_text(before + SIDEWAYS)

        run(
            "first",
            Catalog(project),
            out=project / "out",
            duration=1.0,
            report=False,
            sinks=[sink],
            progress=progress,
            watch_rules=True,
        )
        (replaced,) = [event for event in sink.events if isinstance(event, RulesReplaced)]
        assert replaced.accepted
        assert replaced.detail == "active rules (1): keep_clear/TurnAway; " + INACTIVE.rstrip(".")


class TestShow:
    def test_the_rules_and_the_program_that_they_become(self, rocs_bt):
        told = rocs_bt("show", "avoid_collision").out
        assert told.index("Blind: ") < told.index("Flinch: ") < told.index("AvoidCollision: ")
        assert "near = 0.4" in told
        source = rocs_bt("show", "avoid_collision", "--compiled").out
        assert "= min r0..5" in source
        assert "avoid_collision/Flinch: when r" in source

    def test_neither_a_mission_nor_rules(self, rocs_bt):
        assert "no mission is named 'nosuch'" in rocs_bt("show", "nosuch").err
        assert "no rule file is named 'nosuch'" in rocs_bt("show", "nosuch", "--compiled").err


class TestWatching:
    """A run of the project in lockstep, whose rule file somebody edits meanwhile."""

    @pytest.fixture
    def played(self, project):
        file, catalog = project / RULES, Catalog(project)
        before = file.read_text()

        def play(edits, **options):
            sink = ListSink()

            def progress(t):
                for at in list(edits):
                    if t >= at - 1e-9:
                        file.write_text(edits.pop(at))

            result = run(
                "first",
                catalog,
                out=project / "out",
                duration=2.0,
                report=False,
                sinks=[sink],
                progress=progress,
                **options,
            )
            return result, [e for e in sink.events if isinstance(e, RulesReplaced)], before

        return play, before

    def test_a_broken_file_leaves_the_old_rules_in_force_and_says_so(self, played):
        play, before = played
        broken = before.replace("0.40 m", "0.40 s")
        result, told, _ = play({0.5: broken, 1.0: before}, watch_rules=True)
        assert [(round(e.t, 2), e.accepted, e.rules, e.agent) for e in told] == [
            (0.55, False, "keep_clear", "R1"),
            (1.05, True, "keep_clear", "R1"),
        ]
        assert "the old rules stay active: " in told[0].detail
        assert re.search(r"keep_clear.toml:5:\d+: .*'<' needs one unit|needs one unit", told[0].detail)
        recorded = [e for e in Recording.open(result.recording).events() if isinstance(e, RulesReplaced)]
        assert recorded == told

    def test_new_rules_are_in_force_at_once(self, played, rocs_bt, project):
        play, before = played
        far = before.replace("min(front) < min(0.40 m, max(goal_distance - 0.07 m, 0.05 m))", "goal_distance > 0.2 m")
        far = far[: far.index("# Run by")].replace("min(front) > 0.50 m", "goal_distance < 0.1 m")
        result, told, _ = play({1.0: far}, watch_rules=True)
        assert [e.accepted for e in told] == [True]
        fired = [
            e.t for e in Recording.open(result.recording).events() if isinstance(e, RuleChanged) and e.phase == "fired"
        ]
        assert fired
        assert fired[0] == pytest.approx(told[0].t)
        answer = rocs_bt("replay", project / "out")
        assert answer.code == 0, answer.err

    def test_nobody_looks_unless_asked_to(self, played):
        play, before = played
        same, told, _ = play({})
        other, more, _ = play({0.5: before.replace("0.40 m", "0.40 s")})
        assert told == more == []
        assert same.summary.trajectory_hash == other.summary.trajectory_hash

    def test_looking_changes_nothing_where_nothing_changes(self, played):
        play, _ = played
        assert play({})[0].summary.trajectory_hash == play({}, watch_rules=True)[0].summary.trajectory_hash

    @pytest.mark.usefixtures("awake")
    def test_in_threads_it_is_said_on_the_terminal(self, project, rocs_bt, monkeypatch):
        file, sound = project / RULES, RuleWatch.__enter__

        def begin(watch):
            file.write_text(file.read_text().replace("0.40 m", "0.40 s"))
            return sound(watch)

        monkeypatch.setattr(RuleWatch, "__enter__", begin)
        told = rocs_bt("run", "first", "--mode", "threaded", "--for", "3", "--no-report", "--watch-rules")
        assert re.search(r"\d\.\d\d s, R1: keep_clear: the old rules stay active", told.err)


def test_help_tells_of_all_three():
    for command in ("test", "replay", "tune"):
        assert call(["rules", command, "--help"]) == 0


def test_a_wrong_file_is_reported_and_the_others_are_tested(project, rocs_bt):
    (project / "rules" / "wrong.toml").write_text('format = "reflex/1"\n[rule.A]\nwhen = "frnt < 1 m"\npriority = 1\n')
    told = rocs_bt("rules", "test")
    assert told.code == 2
    assert told.out == "1 test: 1 passed, 0 failed. 1 file could not be read.\n"
    assert "wrong.toml:3:" in told.err


def test_a_requirement_that_cannot_be_read_says_where_and_what_it_may_have(project, rocs_bt):
    assert rocs_bt("run", "first", "--for", "1").code in (0, 1)
    told = rocs_bt("requirements", "runs/first-1", "--require", "allways min(front) > 0.1 m")
    assert told.code == 2
    assert "in 'allways min(front) > 0.1 m', column 9: not an expression" in told.err
    assert "may begin with 'always'" in told.err
