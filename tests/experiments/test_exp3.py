"""EXP3, whole: R2 visits four corners, R3 follows it by its robot sensor, R1 wanders about."""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path

import pytest

from rocs_bt import run
from rocs_bt.catalog import Catalog
from rocs_bt.devices.simulated import RobotSensor
from rocs_bt.event import BodyMoved, Change, ContactBegan, ListSink, TicketChanged
from rocs_bt.interfaces.device import Reading
from rocs_bt.record import Recording, Summary
from rocs_bt.running import replay
from rocs_bt.simulation import SimulatedWorld, build_world
from rocs_bt.testing.faults import FaultySensor, break_sensor

SEEDS = (1,)  # `make soak` plays a hundred
DISTANCE, SAFETY = 1.5, 0.8  # [m] between the centres, as the scenario asks of its follower
SAFE = (SAFETY, 2.0 * DISTANCE - SAFETY)  # the mission's band


@cache
def episode(seed: int) -> tuple[Summary, tuple[BodyMoved, ...], tuple[ContactBegan, ...]]:
    sink = ListSink()
    summary = run("exp3", Catalog(), seed=seed, sinks=[sink]).summary
    moves = tuple(e for e in sink.events if isinstance(e, BodyMoved))
    return summary, moves, tuple(e for e in sink.events if isinstance(e, ContactBegan))


def distances(moves: tuple[BodyMoved, ...]) -> list[tuple[float, float]]:
    """Time [s] and distance of R3 from R2 [m], from when R3 is first within its band on."""
    at, found = {}, []
    for move in moves:
        at[move.body] = move
        if move.body == "R3" and "R2" in at:
            found.append((move.t, math.hypot(at["R2"].x - move.x, at["R2"].y - move.y)))
    first = next(i for i, (_, d) in enumerate(found) if d <= SAFE[1])
    return found[first:]


@pytest.mark.parametrize("seed", SEEDS)
def test_the_corners_are_visited_and_nobody_hits_a_wall_or_the_other(seed: int) -> None:
    summary, _, touched = episode(seed)
    assert summary.agents["R2"].goals_reached == 4
    assert not [e for e in touched if e.agent and e.other != "R1"]


def test_the_follower_keeps_within_the_safe_band() -> None:
    shares, means = [], []
    for seed in SEEDS:
        summary, moves, _ = episode(seed)
        until = summary.agents["R2"].time_to_goal
        kept = [d for t, d in distances(moves) if t <= until]
        shares.append(sum(SAFE[0] <= d <= SAFE[1] for d in kept) / len(kept))
        means.append(sum(kept) / len(kept))
    # Where the walker pins R3 down, R3 has to stand still meanwhile.
    assert all(share > 0.9 for share in shares)
    assert min(shares) > 0.5
    assert all(1.1 < mean < 1.8 for mean in means)


@pytest.mark.usefixtures("awake")
def test_on_wall_time_each_agent_drives_in_threads_of_its_own() -> None:
    found = run("exp3", Catalog(), seed=1, mode="threaded", duration=8.0).summary.agents
    assert list(found) == ["R2", "R3"]
    for agent in found.values():
        assert not agent.faults
        assert agent.outcome in ("timeout", "success")  # R3 may be at its goal already
        assert agent.path_length > 1.0
        assert agent.collisions == 0


def test_a_replay_decides_the_same(tmp_path: Path) -> None:
    run("exp3", Catalog(), seed=1, out=tmp_path, report=False, duration=12.0)
    assert replay(Recording.open(tmp_path / "run.mcap"), Catalog()) is None


def test_the_tags_that_minds_are_told_are_those_that_the_sensor_reads() -> None:
    spec = Catalog().load_scenario("exp3")
    stage = build_world(spec, Catalog(), 1, ListSink())
    tags = {tag: name for name, tag in spec.tags.items()}
    values = stage.sensors["R3"]["robots"].read().values
    here = stage.world.pose("R3")
    seen = {tags[int(tag)]: distance for tag, distance, _ in zip(*[iter(values)] * 3, strict=True) if tag}
    for name, distance in seen.items():
        assert distance == pytest.approx(here.distance(stage.world.pose(name)), abs=0.2)
    assert "R2" in seen


class Blind(FaultySensor):
    """A robot sensor that sees nobody."""

    def broken(self) -> Reading:
        reading = self.sensor.read()
        return Reading(reading.stamp, [0.0, math.inf, 0.0] * (len(reading.values) // 3))


def blinded(stage: SimulatedWorld) -> None:
    break_sensor(stage, "robots", Blind, "R3", at=2.0)


def test_a_follower_that_cannot_see_its_leader_any_more_gives_up_with_the_reason() -> None:
    sink = ListSink()
    run("exp3", Catalog(), seed=2, sinks=[sink], prepare=blinded, duration=30.0)
    told = [e.kind for e in sink.events if isinstance(e, Change) and e.agent == "R3" and e.subject == "R2"]
    assert told == ["seen", "lost", "given up"]
    failed = [e for e in sink.events if isinstance(e, TicketChanged) and e.state == "FAILED"]
    reasons = [e.reason for e in failed if e.action == "FollowRobot"]
    # Not its outcome: whom it does not see, it may run into as it looks round.
    assert reasons
    assert reasons[0].startswith("LOST_LEADER: 'R2' was not found")


def test_a_leader_that_never_moves_is_driven_up_to() -> None:
    def parked(mission: object) -> object:
        return mission.wait("60 s")

    sink = ListSink()
    summary = run("exp3", Catalog(), seed=1, sinks=[sink], missions={"R2": parked}, duration=25.0).summary
    moves = tuple(e for e in sink.events if isinstance(e, BodyMoved))
    assert distances(moves)[-1][1] == pytest.approx(DISTANCE, abs=0.2)
    assert summary.agents["R3"].outcome in ("success", "timeout")


@pytest.mark.parametrize("name", ["R2", "R3"])
def test_only_who_carries_a_robot_sensor_has_one(name: str) -> None:
    stage = build_world(Catalog().load_scenario("exp3"), Catalog(), 1, ListSink())
    assert any(isinstance(s, RobotSensor) for s in stage.sensors[name].values()) is (name == "R3")
