"""Many episodes in several processes."""

from __future__ import annotations

import json
import pickle

import pytest

from benchmarks.paper.campaign import Job, play, play_all
from rocs_bt import run
from rocs_bt.base.errors import BlockError, InputError
from rocs_bt.catalog import Catalog


@pytest.fixture
def project(tmp_path):
    """EXP1 that ends after two seconds, named 'short'."""
    text = Catalog().find("scenario", "exp1").path.read_text("utf-8")
    (tmp_path / "scenarios").mkdir()
    (tmp_path / "scenarios" / "short.toml").write_text(text.replace('"60 s"', '"2 s"'), "utf-8")
    return tmp_path


def test_summaries_come_in_the_order_of_the_jobs_and_are_those_of_a_run_in_this_process(project):
    told: list[float] = []
    found = play_all([Job("short", seed, project=project) for seed in (3, 1, 2)], progress=told.append)
    assert [summary.seed for summary in found] == [3, 1, 2]
    assert told == [1, 2, 3]
    here = [run("short", Catalog(project), seed=seed).summary.trajectory_hash for seed in (3, 1, 2)]
    assert [summary.trajectory_hash for summary in found] == here


def test_what_it_writes_is_what_it_gives_and_nothing_old_stays_beside_it(project, tmp_path):
    job = Job("short", 1, tmp_path / "out", project=project)
    play(Job("short", 2, tmp_path / "out", record=True, project=project))
    assert (tmp_path / "out" / "run.mcap").exists()
    found = play(job)
    assert json.loads((tmp_path / "out" / "summary.json").read_text()) == json.loads(found.to_json())
    assert not (tmp_path / "out" / "run.mcap").exists()


def test_other_rules_and_parameters_are_played_on_the_same_starts(project):
    same = play(Job("short", 1, project=project))
    other = play(Job("short", 1, rules=("braitenberg",), parameters=(("cruise", "0.1 m/s"),), project=project))
    assert other.agents["R2"].rules == ("braitenberg",)
    assert other.agents["R2"].path_length < 0.21 < same.agents["R2"].path_length


def test_what_is_wrong_in_a_worker_is_told_here(project):
    with pytest.raises(InputError, match="no rule file is named 'nonsense'"):
        play_all([Job("short", 1, rules=("nonsense",), project=project)])


def test_a_block_that_failed_in_a_worker_can_be_told_here():
    failed = pickle.loads(pickle.dumps(BlockError("R2/plan", "raised", "ZeroDivisionError")))
    assert (failed.block, failed.kind, str(failed)) == (
        "R2/plan",
        "raised",
        "block 'R2/plan' raised: ZeroDivisionError",
    )
