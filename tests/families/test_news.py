"""Facts with a time: what agents are told during the run."""

from __future__ import annotations

from pathlib import Path

from rocs_bt import Catalog, run
from rocs_bt.base.toml_text import as_toml
from rocs_bt.check import check_content
from rocs_bt.compare import Floor

ROOT = {"format": "scenario/2", "doc": "A test.", "world": "field", "duration": "12 s", "end_on_collision": True}
AGENT = {
    "name": "R",
    "robot": "jackal",
    "mission": "go_to",
    "x": "0 m",
    "y": "0 m",
    "success": {"goal": "goal"},
    "parameters": {"goal": "goal", "cruise": "0.8 m/s"},
}
GOAL = {"name": "goal", "x": "3 m", "y": "0 m", "tolerance": "0.2 m"}


def field(tmp_path: Path, *facts: dict[str, object]) -> Catalog:
    folder = tmp_path / "scenarios"
    (folder / "worlds").mkdir(parents=True)
    (folder / "worlds" / "field.xml").write_text(Floor((-5.0, -5.0), (5.0, 5.0)).world("field", "An empty field."))
    (folder / "field.toml").write_text(as_toml(ROOT | {"place": [GOAL], "agent": [AGENT], "fact": [*facts]}))
    return Catalog(tmp_path)


MOVES = {"node": "goal", "at": "2 s", "pose": {"x": "3 m", "y": "1 m"}}


def test_a_goal_that_moves_is_where_it_is_told_to_be(tmp_path: Path) -> None:
    catalog = field(tmp_path, MOVES)
    assert not check_content([tmp_path]).has_errors
    summary = run("field", catalog, seed=1, report=False).summary.agents["R"]
    assert summary.outcome == "success"
    assert summary.goals_reached >= 1
    assert summary.path_length > 3.05  # not straight to where it was


def test_who_stops_where_the_goal_was_has_not_succeeded(tmp_path: Path) -> None:
    """The first goal is reached before the news; the mission's SUCCESS at the old place ends the run all the same."""
    late = {**MOVES, "at": "11 s"}
    summary = run("field", field(tmp_path, late), seed=1, report=False).summary.agents["R"]
    assert summary.outcome == "success"
    early = {**MOVES, "at": "0.1 s", "pose": {"x": "-3 m", "y": "0 m"}}
    other = run("field", field(tmp_path / "other", early), seed=1, report=False).summary.agents["R"]
    assert other.outcome == "success"
    assert other.time_to_goal > summary.time_to_goal  # it had to turn round


def test_facts_come_in_the_order_of_their_times_and_repeat(tmp_path: Path) -> None:
    back = {"node": "goal", "at": "3 s", "pose": {"x": "3 m", "y": "-1 m"}}
    catalog = field(tmp_path, back, MOVES)
    first, same = (run("field", catalog, seed=1, report=False).summary for _ in range(2))
    assert first.trajectory_hash == same.trajectory_hash
    assert first.agents["R"].outcome == "success"
