"""A quadrotor finds out which of three doors is open, and a wheeled robot that waits for this drives through it."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from rocs_bt import Catalog, Summary, run
from rocs_bt.event import BodyMoved, Event, KnowledgeChanged, ListSink
from rocs_bt.record import Recording
from rocs_bt.running import replay

SHIPPED = Path(__file__).resolve().parents[2] / "scenarios"
DOORS = {"door_1": -2.4, "door_2": 0.0, "door_3": 2.4}  # [m] y of their middle; the wall is at x = 0
OPEN = {5: "door_1", 2: "door_2", 1: "door_3"}
"""A seed for each door."""

SEEDS = [1, *(pytest.param(seed, marks=pytest.mark.soak) for seed in (2, 5))]
"""Of OPEN; before the third door, the other two are found closed."""


def play(catalog: Catalog, seed: int, out: Path | None = None) -> tuple[Summary, list[Event]]:
    sink = ListSink()
    result = run("team", catalog, seed=seed, sinks=[sink], out=out, report=False)
    return result.summary, sink.events


@pytest.fixture(scope="module")
def shipped(tmp_path_factory: pytest.TempPathFactory) -> Callable[[int], tuple[Summary, list[Event]]]:
    """Plays the shipped scenario, once for each seed, and records it in a folder with the seed's name."""
    return cache(lambda seed: play(Catalog(), seed, tmp_path_factory.getbasetemp() / f"team-{seed}"))


def changed(folder: Path, old: str, new: str, world: tuple[str, str] = ("", "")) -> Catalog:
    """A project with a changed copy of the scenario, of the same name, as the names seed the random streams."""
    text = (SHIPPED / "team.toml").read_text("utf-8")
    assert old in text
    (folder / "scenarios" / "worlds").mkdir(parents=True)
    (folder / "scenarios" / "team.toml").write_text(text.replace(old, new), "utf-8")
    arena = (SHIPPED / "worlds" / "doors.xml").read_text("utf-8").replace(*world)
    (folder / "scenarios" / "worlds" / "doors.xml").write_text(arena, "utf-8")
    return Catalog(folder)


def poses(events: list[Event], body: str) -> list[BodyMoved]:
    return [e for e in events if isinstance(e, BodyMoved) and e.body == body]


def learnt(events: list[Event], agent: str, subject: str, name: str) -> list[tuple[float, object]]:
    """Times [s] and values of an attribute in an agent's Knowledge, or times and targets of a relation."""
    changes = [e for e in events if isinstance(e, KnowledgeChanged) and e.agent == agent]
    return [(e.t, e.value) for e in changes if (e.subject, e.name) == (subject, name)]


def assert_p_stays(summary: Summary, events: list[Event]) -> None:
    start, *rest = poses(events, "P")
    assert max(math.dist((start.x, start.y), (e.x, e.y)) for e in rest) < 0.01
    assert summary.agents["P"].outcome == "failed"
    assert {name: agent.contacts for name, agent in summary.agents.items()} == {"Q": {}, "P": {}}


@pytest.mark.parametrize("seed", [*SEEDS, *(pytest.param(s, marks=pytest.mark.soak) for s in range(6, 20))])
def test_both_robots_succeed_without_a_contact(shipped, seed: int) -> None:
    summary, events = shipped(seed)
    assert {name: (a.outcome, a.contacts, a.fell) for name, a in summary.agents.items()} == {
        "Q": ("success", {}, False),
        "P": ("success", {}, False),
    }
    landed = poses(events, "Q")[-1]
    assert math.dist((landed.x, landed.y), (-3.0, -3.0)) < 0.25
    assert landed.height == pytest.approx(0.1, abs=0.02)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_wheeled_robot_waits_and_then_passes_the_open_door(shipped, seed: int) -> None:
    door = OPEN[seed]
    _, events = shipped(seed)
    (known, is_open), *_ = learnt(events, "P", door, "open")
    assert is_open is True
    moved = poses(events, "P")
    before = [e for e in moved if e.t <= known]
    assert max(math.dist((before[0].x, before[0].y), (e.x, e.y)) for e in before) < 0.01
    passing = next(e for e in moved if e.x > 0.0)
    assert passing.y == pytest.approx(DOORS[door], abs=0.3)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_finding_is_an_observation_made_in_front_of_the_door(shipped, seed: int) -> None:
    door = OPEN[seed]
    _, events = shipped(seed)
    node = f"{door} seen by Q"
    (found, is_open), *_ = learnt(events, "Q", door, "open")
    (time, _), *_ = learnt(events, "P", door, "open")
    assert is_open is True
    assert found < time < found + 1.0
    assert [target for _, target in learnt(events, "P", node, "observes")] == [door]
    assert [target for _, target in learnt(events, "P", node, "made_by")] == ["Q"]
    (_, confidence), *_ = learnt(events, "P", node, "confidence")
    assert 0.9 < confidence < 1.0
    there = next(e for e in poses(events, "Q") if e.t >= found)
    assert there.x == pytest.approx(-1.2, abs=0.5)
    assert there.y == pytest.approx(DOORS[door], abs=1.0)
    assert 0.5 < there.height < 1.2  # above that, the beams pass over the wall


@pytest.mark.parametrize("seed", SEEDS)
def test_every_door_before_the_open_one_was_found_closed(shipped, seed: int) -> None:
    _, events = shipped(seed)
    last = {name: found[-1][1] for name in DOORS if (found := learnt(events, "P", name, "open"))}
    closed = sorted(DOORS)[: sorted(DOORS).index(OPEN[seed])]
    assert last == {**dict.fromkeys(closed, False), OPEN[seed]: True}


def test_all_doors_closed_both_fail_with_the_reason_and_the_quadrotor_lands(tmp_path: Path) -> None:
    summary, events = play(changed(tmp_path, 'depart_at = "0 s"', 'depart_at = "1000 s"'), 1)
    assert_p_stays(summary, events)
    for name in ("Q", "P"):
        assert "closed: door_1, door_2, door_3" in summary.agents[name].reason
    landed = poses(events, "Q")[-1]
    assert (summary.agents["Q"].outcome, summary.agents["Q"].fell) == ("failed", False)
    assert math.dist((landed.x, landed.y), (-3.0, -3.0)) < 0.25
    assert landed.height == pytest.approx(0.1, abs=0.02)


def test_what_the_beams_hit_counts_not_what_is_open(tmp_path: Path) -> None:
    """A curtain behind the open door ends the beams, so the door is not found, and the other robot does not move."""
    curtain = '<geom name="curtain" type="box" size="0.01 3.8 0.6" pos="0.15 0 0.6"/><body name="stack"'
    catalog = changed(tmp_path, 'depart_at = "0 s"', 'depart_at = "0.0 s"', ('<body name="stack"', curtain))
    summary, events = play(catalog, 2)
    assert_p_stays(summary, events)
    assert not any(is_open for name in DOORS for _, is_open in learnt(events, "P", name, "open"))


def test_a_door_that_is_only_said_to_be_open_is_not_driven_to(tmp_path: Path) -> None:
    said = 'node = "door_2"\nkind = "door"\n'
    summary, events = play(changed(tmp_path, said, said + "open = true\n"), 1)
    assert {name: a.outcome for name, a in summary.agents.items()} == {"Q": "success", "P": "success"}
    assert [is_open for _, is_open in learnt(events, "P", "door_2", "open")] == [True, False]
    assert next(e for e in poses(events, "P") if e.x > 0.0).y == pytest.approx(DOORS["door_3"], abs=0.3)


@pytest.mark.soak  # tests/experiments/test_exp3_shared.py has a robot without shared knowledge
def test_without_shared_knowledge_the_wheeled_robot_waits_in_vain(tmp_path: Path) -> None:
    catalog = changed(tmp_path, '"observation", "peer"]', '"peer"]')
    summary, events = play(catalog, 5)
    assert summary.agents["Q"].outcome == "success"
    start, *rest = poses(events, "P")
    assert max(math.dist((start.x, start.y), (e.x, e.y)) for e in rest) < 0.01
    assert summary.agents["P"].outcome != "success"


def test_the_run_replays(shipped, tmp_path_factory: pytest.TempPathFactory) -> None:
    """The golden runs and tests/contracts play it again."""
    shipped(1)
    assert replay(Recording.open(tmp_path_factory.getbasetemp() / "team-1")) is None
