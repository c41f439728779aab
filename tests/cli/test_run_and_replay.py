"""`run` and `replay` through the front door: what a refused or a cut-off run leaves behind, and what is told of it."""

import json
import shutil

import pytest

from ..direct_project import drive_straight
from ..pages import data_of


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A short run of exp1, as `rocs-bt run` leaves it."""
    from rocs_bt import run
    from rocs_bt.catalog import Catalog

    out = tmp_path_factory.mktemp("finished")
    run("exp1", Catalog(), seed=1, out=out, duration=6.0)
    return out


@pytest.fixture
def recorded(finished, tmp_path):
    return shutil.copytree(finished, tmp_path / "run")


@pytest.mark.parametrize("option", [("--view",), ("--video", "no/such/folder/x.gif"), ("--video", "x.doc")])
def test_a_run_that_is_refused_leaves_an_earlier_one_alone(rocs_bt, recorded, monkeypatch, option):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    before = {f.name: f.read_bytes() for f in recorded.iterdir()}
    told = rocs_bt("run", "exp1", "--out", recorded, *option)
    assert told.code == 2
    assert told.err.strip()
    assert {f.name: f.read_bytes() for f in recorded.iterdir()} == before


def test_a_new_run_takes_the_place_of_an_earlier_one(rocs_bt, recorded):
    (recorded / "report.html").write_text("a stranger's")
    assert rocs_bt("run", "exp1", "--seed", "2", "--for", "0.5", "--out", recorded, "--no-report").code == 1
    assert not (recorded / "report.html").exists()
    assert '"seed": 2' in (recorded / "summary.json").read_text()


def test_a_replay_reaches_the_same_decisions(rocs_bt, recorded):
    told = rocs_bt("replay", recorded)
    assert (told.code, told.out) == (0, "All events are equal.\n")


def test_a_replay_of_nobody_is_refused(rocs_bt, recorded):
    told = rocs_bt("replay", recorded, "--agent", "R9")
    assert told.code == 2
    assert "no agent is named 'R9'. The run has: R2." in told.err


def test_a_cut_off_recording_is_compared_as_far_as_it_goes(rocs_bt, recorded):
    file = recorded / "run.mcap"
    file.write_bytes(file.read_bytes()[:60_000])
    told = rocs_bt("replay", recorded)
    assert told.code == 0
    assert "was cut off; it is read up to t = " in told.err


def test_a_replay_away_from_its_project_says_where_to_go(rocs_bt, tmp_path, monkeypatch):
    assert rocs_bt("new", tmp_path / "yard").code == 0
    drive_straight(tmp_path / "yard")
    monkeypatch.chdir(tmp_path / "yard")
    assert rocs_bt("run", "first", "--for", "0.5", "--out", tmp_path / "r", "--no-report").code == 1
    monkeypatch.chdir(tmp_path)
    told = rocs_bt("replay", tmp_path / "r")
    assert told.code == 2
    assert "no scenario is named 'first'" in told.err
    assert "in the project folder in which it was recorded" in told.err


def test_why_calls_a_reflex_active_until_its_action_has_ended(rocs_bt, recorded):
    told = rocs_bt("replay", recorded, "--why", "2")
    assert told.code == 0
    assert "RUNNING AvoidCollision" in told.out
    assert "no active rule" not in told.out
    assert "avoid_collision/AvoidCollision" in told.out.partition("\nfired ")[2].partition("\n")[0]


def test_why_asks_for_a_time_that_the_run_has(rocs_bt, recorded):
    told = rocs_bt("replay", recorded, "--why", "99")
    assert told.code == 2
    assert "the time 99 s is outside the run. The run is from 0 s to 6 s" in told.err


def test_a_follower_that_localises_itself_is_told_of_as_one(rocs_bt, tmp_path):
    told = rocs_bt("run", "exp3_localised", "--for", "8", "--out", tmp_path / "run")
    found = json.loads((tmp_path / "run" / "summary.json").read_text("utf-8"))["agents"]
    leash, lost = found["R3"]["following"], found["R2"]["localisation"]
    assert f"followed R2 at a mean distance of {leash['mean_distance']:.2f} m" in told.out
    assert f"{100.0 * leash['in_band']:.0f} % of the time within the follow band" in told.out
    assert f"error of the pose estimate: {100.0 * lost['position_rms']:.1f} cm" in told.out
    assert (told.out.count("followed R2"), told.out.count("error of the pose estimate")) == (1, 2)
    numbers = dict(data_of(tmp_path / "run" / "report.html")["results"]["R3"]["numbers"])
    assert numbers["error of the follow distance, mean"] == f"{leash['distance_error']:.2f} m"
    assert {"distance to R2, mean", "time within the follow band"} <= numbers.keys()


def test_dollar_signs_in_names_are_no_mathematics(rocs_bt, project):
    name = r"$$ $x$ $\frac{ a $ b_c ^"
    scenario = project / "scenarios" / "first.toml"
    scenario.write_text(scenario.read_text().replace('"gate"', f"'{name}'"))
    told = rocs_bt("run", "first")
    assert (told.code, told.err) == (0, "")
    places = data_of(project / "runs/first-1/report.html")["header"]["places"]
    assert name in [place["name"] for place in places]
    assert rocs_bt("plot", "runs/first-1").code == 0  # as pixels, too
