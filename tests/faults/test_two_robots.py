"""EXP3 with something wrong: a leader that vanishes, stands or drives at its follower, and a mind that dies."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Sequence

from rocs_bt import AgentResult, run
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.event import BodyMoved, Change, ContactBegan, Event
from rocs_bt.simulation import SimulatedWorld
from rocs_bt.testing.faults import DeadSensor, break_sensor

DISTANCE, SAFETY = 1.5, 0.8  # [m] of the scenario's follower
DRIVES = 0.02  # [m/s] of a rim


@dataclass
class Pair:
    """What came of R2, who leads, and R3, who follows; calls `at` once its time has come."""

    at: float = math.inf
    act: Callable[[SimulatedWorld], None] = lambda stage: None
    stage: SimulatedWorld | None = None
    poses: dict[str, Pose2] = field(default_factory=dict)
    rows: list[tuple[float, float, bool]] = field(default_factory=list)  # [s], distance [m], whether R3 drives
    told: list[Event] = field(default_factory=list)
    summary: dict[str, AgentResult] = field(default_factory=dict)

    def emit(self, event: Event) -> None:
        if isinstance(event, BodyMoved):
            self.poses[event.body] = Pose2(event.x, event.y, event.yaw)
            if event.body == "R3" and "R2" in self.poses:
                drives = bool(np.abs(np.frombuffer(event.wheels)).max(initial=0.0) > DRIVES)
                self.rows.append((event.t, self.poses["R3"].distance(self.poses["R2"]), drives))
            if event.t >= self.at and self.stage is not None:
                self.at = math.inf
                self.act(self.stage)
        elif isinstance(event, Change | ContactBegan) and event.agent == "R3":
            self.told.append(event)

    def prepare(self, stage: SimulatedWorld) -> None:
        self.stage = stage

    def run(self, duration: float, **given: Any) -> AgentResult:
        """R3's part of the summary."""
        prepare = given.pop("prepare", lambda stage: None)

        def both(stage: SimulatedWorld) -> None:
            self.prepare(stage)
            prepare(stage)

        found = run("exp3", Catalog(), seed=1, sinks=[self], prepare=both, duration=duration, **given)
        self.summary = dict(found.summary.agents)
        return self.summary["R3"]

    def touched(self) -> list[ContactBegan]:
        return [e for e in self.told if isinstance(e, ContactBegan) and e.kind == "collision"]

    def below(self) -> list[float]:
        """Distances at which R3 drove though it was too near [m]."""
        return [d for _, d, drives in self.rows if drives and d < SAFETY]


class Dies(Behaviour):
    """A leaf that raises after three seconds."""

    ticks = 0

    def update(self) -> Status:
        self.ticks += 1
        if self.ticks > 30:
            raise RuntimeError("its time has come")
        return Status.RUNNING


def test_a_leader_that_vanishes_is_given_up_with_the_reason_and_the_robot_stands() -> None:
    pair = Pair(at=6.0, act=lambda stage: stage.world.place("R2", Pose2(40.0, 40.0, 0.0)))
    summary = pair.run(30.0)
    changes = [e.kind for e in pair.told if isinstance(e, Change) and e.subject == "R2"]
    assert changes == ["seen", "lost", "given up"]
    assert summary.outcome == "failed"
    assert "LOST_LEADER: 'R2' was not found" in summary.reason
    assert not pair.rows[-1][2]
    assert not pair.touched()


def test_a_leader_that_stands_is_driven_up_to_and_no_nearer() -> None:
    pair = Pair()
    summary = pair.run(25.0, missions={"R2": lambda mission: mission.wait("60 s")})
    assert pair.rows[-1][1] == pytest.approx(DISTANCE, abs=0.2)
    assert summary.outcome in ("success", "timeout")
    assert not pair.below()
    assert not pair.touched()


def test_for_a_leader_that_drives_at_it_the_follower_makes_room() -> None:
    def there_and_back(mission: Any) -> Any:
        for name, at in (("there", 1.4), ("back", -1.2)):
            mission.knowledge.world.place(name, Pose2(at, at), kind="goal")
        legs = [mission.act("GoTo", goal=goal, cruise=0.3) for goal in ("there", "back")]
        return Sequence("there and back", memory=True, children=legs)

    pair = Pair()
    pair.run(40.0, missions={"R2": there_and_back})
    gone = [t for t, d, _ in pair.rows if d < 1.3]
    assert gone, "the leader never came near"
    assert not [e for e in pair.touched() if e.other == "R2"]
    assert not pair.below()


def test_with_a_dead_robot_sensor_the_follower_stands() -> None:
    pair = Pair()
    pair.run(15.0, prepare=lambda stage: break_sensor(stage, "robots", DeadSensor, "R3", at=4.0))
    assert not [t for t, _, drives in pair.rows if drives and t > 5.5]
    assert not pair.touched()


@pytest.mark.parametrize(("dead", "other"), [("R2", "R3"), ("R3", "R2")])
def test_when_one_mind_dies_the_other_lives_on(dead: str, other: str) -> None:
    pair = Pair()
    pair.run(20.0, missions={dead: lambda mission: Dies("dies")})
    assert pair.summary[dead].outcome == "failed"
    assert "its time has come" in pair.summary[dead].reason
    assert pair.summary[other].outcome != "error"
    if other == "R3":
        assert pair.summary["R3"].outcome == "success"  # it has driven up to who stands for good
        assert pair.rows[-1][1] == pytest.approx(DISTANCE, abs=0.2)
    else:
        assert pair.summary["R2"].path_length > 2.0


@pytest.mark.usefixtures("awake")
def test_on_wall_time_too_an_agent_drives_on_without_the_other() -> None:
    dead, other, pair = "R3", "R2", Pair()
    pair.run(7.0, mode="threaded", missions={dead: lambda mission: Dies("dies")})
    assert "its time has come" in pair.summary[dead].reason
    assert pair.summary[other].outcome != "error"
    assert not pair.summary[other].faults
    assert pair.summary[other].path_length > 1.0
    assert not pair.below()
