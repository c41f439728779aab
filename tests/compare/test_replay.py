"""An episode of a sweep again, by the command that a report or a failed test prints."""

from __future__ import annotations

import json
import shlex

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.catalog import Catalog
from rocs_bt.cli.main import call
from rocs_bt.compare import Comparison, FamilyScene, ScenarioScene
from rocs_bt.compare.episode import Episode
from rocs_bt.compare.replay import replay_command, scene_by_name
from rocs_bt.compare.runner import EpisodeRunner

from ..pages import data_of

PLACES = [
    ScenarioScene("exp1"),
    ScenarioScene("exp3", "R3"),
    FamilyScene("barn_like", 3),
    FamilyScene("barn_like", 17, (("robot", "jackal"), ("rules", "avoid_collision"))),
]


def trajectory(run):
    return json.loads((run / "summary.json").read_text())["trajectory_hash"]


def command_on(page):
    """What a report says makes its run again."""
    return data_of(page)["header"]["command"]


def test_a_run_of_the_first_moments_says_so(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call(["run", "exp1", "--for", "1.5", "--out", "a"])
    shown = command_on(tmp_path / "a" / "report.html")
    assert shown == "rocs-bt run exp1 --seed 1 --for 1.5"
    call([*shlex.split(shown)[1:], "--out", "b"])
    assert trajectory(tmp_path / "a") == trajectory(tmp_path / "b")


@pytest.mark.parametrize("place", PLACES, ids=lambda place: place.name)
def test_a_scene_is_found_by_the_name_that_results_have_for_it(place):
    assert scene_by_name(place.name, Catalog()) == place


def test_a_name_of_nothing_is_told():
    with pytest.raises(InputError, match=r"'mars' is neither a scenario nor a scene of a family.*barn_like-17"):
        scene_by_name("mars", Catalog())
    with pytest.raises(InputError, match="'mars_like'"):
        scene_by_name("mars_like-3", Catalog())


@pytest.mark.parametrize("place", [PLACES[0], PLACES[2]], ids=lambda place: place.name)
def test_its_command_plays_the_same_episode_and_shows_it(place, tmp_path, monkeypatch, capsys):
    runner = EpisodeRunner()
    planner = runner.catalog.load_planner("tree_no_reflexes")
    record = runner.play(Episode("key", planner, place, 2))
    monkeypatch.chdir(tmp_path)
    command = shlex.split(replay_command(record))
    assert command[0] == "rocs-bt"
    call([*command[1:], "--out", "again"])
    assert trajectory(tmp_path / "again") == record.trajectory_hash
    assert record.outcome in capsys.readouterr().out
    shown = command_on(tmp_path / "again" / "report.html")
    assert shown == replay_command(record)
    call([*shlex.split(shown)[1:], "--out", "and_again"])
    assert trajectory(tmp_path / "and_again") == record.trajectory_hash
    assert Comparison([record]).outcomes("tree_no_reflexes") == {record.outcome: 1}
