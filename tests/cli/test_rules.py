"""`rocs-bt rules`, `requirements` and `show` of rule files; rule files that change while a run goes on."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

from rocs_bt import run
from rocs_bt.agent import RuleWatch
from rocs_bt.catalog import Catalog
from rocs_bt.cli.main import call
from rocs_bt.event import ListSink, RuleChanged, RulesReplaced
from rocs_bt.record import Recording
from rocs_bt.record.figures.rules import spans
from rocs_bt.simulation.rule_replay import reflex_input, replay_rules, rules_for

RULES = "rules/keep_clear.toml"


@pytest.fixture(scope="module")
def runs(tmp_path_factory) -> list[Path]:
    folder = tmp_path_factory.mktemp("runs")
    for seed in (3, 4):
        run("exp1", Catalog(), seed=seed, out=folder / f"exp1-{seed}", duration=10.0, report=False)
    return [folder / "exp1-3", folder / "exp1-4"]


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
    report = (project / "out/report.html").read_text()
    row = re.search(r'<table class="firings">.*?<tbody>(.*?)</tbody>', report, re.S)[1]
    assert row.count("<tr>") == 1
    assert re.findall(r"<td[^>]*>([^<>]+)</td>", row)[-1] == str(len(again))


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
        (line,) = inactive
        assert re.search(r"avoid_collision.toml: rule AvoidCourse is inactive: robots 'pioneer_p3dx', .* have no", line)

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
            ("turn = ", "trn = ", "no parameter of AvoidCollision is named 'trn'. Did you mean 'turn'?"),
            ("0.39 m", "0.39 s", "'front' must be in m"),
            ("reflex-tests/1", "reflex/1", "invalid value 'reflex/1' for 'format'. Did you mean 'reflex-tests/1'?"),
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
        shown = INACTIVE.replace("'", "&#39;")[1:]
        assert shown in (project / "out/report.html").read_text()
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


class TestReplay:
    def test_the_same_rules_fire_when_they_did(self, runs):
        recording = Recording.open(runs[0])
        (info,) = recording.header.agents
        catalog = Catalog()
        found = replay_rules(
            rules_for(catalog.find("rules", "avoid_collision").path, info, catalog), reflex_input(recording, info)
        )
        events = [e for e in recording.events() if isinstance(e, RuleChanged)]
        latched = [(e.rule, e.t) for e in events if e.phase == "latched"]
        released = [(e.rule, e.t) for e in events if e.phase == "released"]
        assert len(latched) == 3
        assert [(f.rule, f.begin) for f in found.firings] == latched
        assert [(f.rule, f.end) for f in found.firings][: len(released)] == released
        readings = [e.reading for e in events if e.phase == "latched"]
        assert [f.reading for f in found.firings] == readings

    def test_as_a_table_and_a_picture(self, runs, rocs_bt, tmp_path):
        told = rocs_bt("rules", "replay", "avoid_collision", runs[0], "--out", tmp_path)
        assert told.code == 0, told.err
        assert "avoid_collision on exp1-3, R2: 200 samples, not interpolated" in told.out
        assert len(re.findall(r"avoid_collision/AvoidCollision  min\(front\) = 0\.\d+ m", told.out)) == 3
        assert "avoid_collision/AvoidCollision: 3 times, 3 in the run itself" in told.out
        svg = (tmp_path / "avoid_collision-R2.svg").read_text()
        ids = {e.get("id", "") for e in ElementTree.fromstring(svg).iter()}
        assert {"wins-0", "latched-2", "rules-0-latched"} <= ids
        assert "until min(clear" in svg
        assert (tmp_path / "avoid_collision-R2.png").read_bytes().startswith(b"\x89PNG")

    def test_other_rules_than_the_runs_and_a_rule_by_name(self, runs, rocs_bt, tmp_path):
        told = rocs_bt("rules", "replay", "avoid_collision", runs[0], "--rule", "Blind", "--out", tmp_path)
        assert told.code == 0
        assert "goal_distance" in (tmp_path / "avoid_collision-R2.svg").read_text()
        told = rocs_bt("rules", "replay", "braitenberg", runs[0], "--out", tmp_path)
        assert "braitenberg/Braitenberg: " in told.out
        assert "in the run itself" not in told.out

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            (["--agent", "R9"], "no agent is named 'R9'. The run has: R2."),
            (["--rule", "Flich"], "no rule is named 'Flich'. Did you mean 'Flinch'?"),
        ],
    )
    def test_mistakes(self, runs, rocs_bt, arguments, message):
        told = rocs_bt("rules", "replay", "avoid_collision", runs[0], *arguments)
        assert (told.code, message in told.err) == (2, True)

    def test_spans_are_from_the_first_sample_to_the_first_after(self):
        import numpy as np

        t = np.array([0.0, 0.1, 0.2, 0.3])
        assert spans(t, np.array([True, True, False, True])) == [(0.0, 0.2), (0.3, 0.3)]


class TestTune:
    ARGUMENTS = ("--rule", "AvoidCollision", "--threshold", "near")

    def test_firings_by_threshold(self, runs, rocs_bt, tmp_path):
        told = rocs_bt("rules", "tune", "avoid_collision", *runs, *self.ARGUMENTS, "--steps", 4, "--out", tmp_path)
        assert told.code == 0, told.err
        rows = [line.split() for line in told.out.splitlines() if re.match(r"\s+0\.\d", line)]
        assert [row[0] for row in rows] == ["0.2", "0.4", "0.6", "0.8"]
        assert rows[1][-2:] == ["<-", "now"]
        counts = [[int(cell) for cell in row[1:4]] for row in rows]
        assert all(a + b == both for a, b, both in counts)
        in_the_runs = [
            sum(isinstance(e, RuleChanged) and e.phase == "latched" for e in Recording.open(r).events()) for r in runs
        ]
        assert counts[1][:2] == in_the_runs
        assert counts[0][2] < counts[1][2] < counts[3][2]
        svg = (tmp_path / "avoid_collision-AvoidCollision-near.svg").read_text()
        assert {"tune-now", "tune-0", "tune-1", "tune-all"} <= {e.get("id") for e in ElementTree.fromstring(svg).iter()}

    @pytest.mark.parametrize(
        ("steps", "shown"),
        [
            (3, ["0.3", "0.4 <- now", "0.45", "0.6"]),  # between two values of the grid
            (4, ["0.3", "0.4 <- now", "0.5", "0.6"]),  # one of them
        ],
    )
    def test_the_present_value_is_a_row_of_its_own_with_its_own_counts(self, steps, shown, runs, rocs_bt, tmp_path):
        arguments = [*self.ARGUMENTS, "--from", "0.3 m", "--to", "0.6 m", "--steps", steps, "--out", tmp_path]
        told = rocs_bt("rules", "tune", "avoid_collision", runs[0], *arguments)
        rows = [line.split() for line in told.out.splitlines() if re.match(r"\s+0\.\d", line)]
        assert [" ".join([row[0], *row[2:]]) for row in rows] == shown
        events = Recording.open(runs[0]).events()
        assert int(rows[1][1]) == sum(
            isinstance(e, RuleChanged) and e.phase == "latched" and e.rule.endswith("/AvoidCollision") for e in events
        )

    def test_a_present_value_beyond_the_grid_is_shown_as_well(self, runs, rocs_bt, tmp_path):
        arguments = [*self.ARGUMENTS, "--from", "0.6 m", "--to", "0.8 m", "--steps", 2, "--out", tmp_path]
        told = rocs_bt("rules", "tune", "avoid_collision", runs[0], *arguments)
        rows = [line.split() for line in told.out.splitlines() if re.match(r"\s+0\.\d", line)]
        assert [" ".join([row[0], *row[2:]]) for row in rows] == ["0.4 <- now", "0.6", "0.8"]

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            (["--rule", "AvoidCollision", "--threshold", "nea"], "no threshold is named 'nea'. Did you mean 'near'?"),
            (["--rule", "Avoid", "--threshold", "near"], "no rule is named 'Avoid'"),
            ([*ARGUMENTS, "--from", "1 s"], "--from must be in m, found '1 s'"),
            ([*ARGUMENTS, "--from", "1 m", "--to", "1 m"], "--from must be less than --to"),
        ],
    )
    def test_mistakes(self, runs, rocs_bt, arguments, message):
        told = rocs_bt("rules", "tune", "avoid_collision", runs[0], *arguments)
        assert told.code == 2
        assert message in told.err


class TestRequirements:
    def test_others_than_the_scenarios_on_a_recording(self, runs, rocs_bt):
        told = rocs_bt("requirements", runs[0])
        assert told.code == 2
        assert "the run's scenario has no requirement" in told.err
        told = rocs_bt("requirements", runs[0], "--require", "always speed < 2 m/s")
        assert (told.code, told.out.startswith("R2 satisfied: always speed < 2 m/s; minimum margin ")) == (0, True)
        told = rocs_bt("requirements", runs[0], "--require", "always speed < 0.1 m/s", "--agent", "R2", "--json")
        assert told.code == 1
        assert '"verdict": "violated"' in told.out
        assert rocs_bt("requirements", runs[0], "--require", "always sped < 1 m/s").code == 2

    def test_a_scenarios_are_told_by_run_and_shown_in_the_report(self, project, rocs_bt):
        file = project / "scenarios" / "first.toml"
        file.write_text(
            file.read_text() + '\n[[requirement]]\nname = "hardly moves"\nrequire = "always speed < 0.1 m/s"\n'
        )
        assert rocs_bt("check", file).code == 0
        told = rocs_bt("run", "first", "--for", "3", "--out", "out")
        assert re.search(
            r"  R1 violated: hardly moves \(always speed < 0.1 m/s\), first at \d.\d+ s; minimum", told.out
        )
        page = (project / "out" / "report.html").read_text()
        assert "Requirements of R1" in page
        assert 'class="status violated"' in page
        ids = re.findall(r'id="((?:arena|coordinates)-[^"]*-worst-0)"', page)
        assert sorted(ids) == ["arena-0-R1-worst-0", "coordinates-x-R1-worst-0", "coordinates-y-R1-worst-0"]
        file.write_text(file.read_text().replace("speed < 0.1 m/s", "sped < 0.1 m/s"))
        told = rocs_bt("check", file)
        assert told.code == 2
        assert "no signal or alias is named 'sped'. Did you mean 'speed'?" in told.out


class TestShow:
    def test_the_rules_and_the_python_that_they_become(self, rocs_bt):
        told = rocs_bt("show", "avoid_collision").out
        assert told.index("Blind: ") < told.index("Flinch: ") < told.index("AvoidCollision: ")
        assert "near = 0.4" in told
        source = rocs_bt("show", "avoid_collision", "--compiled").out
        compile(source, "rules", "exec")
        assert "def step(x, t, cells):" in source

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
        assert answer.code == 2
        assert "the rules 'keep_clear' were replaced at" in answer.err

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
