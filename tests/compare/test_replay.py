"""An episode of a sweep again, by the command that a report or a failed test prints."""

from __future__ import annotations

import json
import shlex

import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.cli.main import call
from rocs_bt.compare import Bench, Comparison, FamilyScene, ScenarioScene, Trial, place_named, replay_command
from rocs_bt.errors import InputError

PLACES = [
    ScenarioScene("exp1"),
    ScenarioScene("exp3", "R3"),
    FamilyScene("barn_like", 3),
    FamilyScene("barn_like", 17, (("robot", "jackal"), ("rules", "avoid_collision"))),
]


@pytest.mark.parametrize("place", PLACES, ids=lambda place: place.name)
def test_a_scene_is_found_by_the_name_that_results_have_for_it(place):
    assert place_named(place.name, Catalog()) == place


def test_a_name_of_nothing_is_told():
    with pytest.raises(InputError, match=r"no scenario 'mars', and it is no scene of a family.*barn_like-17"):
        place_named("mars", Catalog())
    with pytest.raises(InputError, match="'mars_like'"):
        place_named("mars_like-3", Catalog())


@pytest.mark.parametrize("place", [PLACES[0], PLACES[2]], ids=lambda place: place.name)
def test_its_command_plays_the_same_episode_and_shows_it(place, tmp_path, monkeypatch, capsys):
    bench = Bench()
    planner = bench.catalog.load_planner("tree_no_reflexes")
    record = bench.play(Trial("key", planner, place, 2))
    bench.close()
    monkeypatch.chdir(tmp_path)
    command = shlex.split(replay_command(record))
    assert command[0] == "rocs-bt"
    call([*command[1:], "--out", "again"])
    summary = json.loads((tmp_path / "again" / "summary.json").read_text())
    assert summary["trajectory_hash"] == record.trajectory_hash
    assert (tmp_path / "again" / "report.html").is_file()
    assert record.outcome in capsys.readouterr().out
    assert Comparison([record]).outcomes("tree_no_reflexes") == {record.outcome: 1}
