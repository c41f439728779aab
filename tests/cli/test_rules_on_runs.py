"""`rocs-bt rules replay`, `rules tune` and `requirements` on recordings."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from rocs_bt import run
from rocs_bt.catalog import Catalog
from rocs_bt.event import RuleChanged
from rocs_bt.record import Recording
from rocs_bt.record.figures.rules import spans
from rocs_bt.running.rule_replay import reflex_input, replay_rules, rules_for

from ..pages import data_of

RULES = "rules/keep_clear.toml"


@pytest.fixture(scope="module")
def runs(tmp_path_factory) -> list[Path]:
    folder = tmp_path_factory.mktemp("runs")
    for seed in (3, 4):
        run("exp1", Catalog(), seed=seed, out=folder / f"exp1-{seed}", duration=10.0, report=False)
    return [folder / "exp1-3", folder / "exp1-4"]


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
            ([*ARGUMENTS, "--from", "1 s"], "--from must be a quantity in m, found '1 s'"),
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
        first = r"first at \d.\d+ s, when speed = [-\d.e]+ m/s; minimum"
        assert re.search(rf"  R1 violated: hardly moves \(always speed < 0.1 m/s\), {first}", told.out)
        (shown,) = data_of(project / "out" / "report.html")["results"]["R1"]["requirements"]
        assert (shown["name"], shown["require"]) == ("hardly moves", "always speed < 0.1 m/s")
        assert re.fullmatch(r"violated at \d.\d+ s: speed = [\d.]+ m/s, minimum margin -0.\d+ m/s", shown["text"])
        assert f"first at {shown['t']:.2f} s" in told.out
        file.write_text(file.read_text().replace("speed < 0.1 m/s", "sped < 0.1 m/s"))
        told = rocs_bt("check", file)
        assert told.code == 2
        assert "no signal or alias is named 'sped'. Did you mean 'speed'?" in told.out
