"""The quadrotor's analyser of doors: open, closed or unknown, from the ranges of its ring alone."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.declare import fields_of, read_fields
from rocs_bt.event import ListSink
from rocs_bt.interfaces.channel import AnalyzeSubscriber, Publisher
from rocs_bt.knowledge import Knowledge

CATALOG = Catalog()
ROBOT = CATALOG.load_robot("quadrotor")
SPEC = next(spec for spec in ROBOT.analyzers if spec.name == "doors")
FILE = ROBOT.file.with_name("doors.py"), "ObserveDoors"
PARAMETERS = read_fields(fields_of(CATALOG.load_class(*FILE)), SPEC.parameters, "doors")
BEAMS, RADIUS, WIDTH = 16, 0.338, 1.1
Wall = Callable[[float], bool]
"""Whether something solid is in the plane of the door, by the position along it from the middle of the door [m]."""


class Planner(AnalyzeSubscriber):
    """Receiver of the changes."""


class Watcher:
    """The analyser in front of a door in the plane x = 0, seen from negative x."""

    def __init__(self, **door: float) -> None:
        self.clock, self.planner = SimulatedClock(0.05), Planner()
        self.knowledge = Knowledge("Q", self.clock, ListSink())
        cls = CATALOG.load_class(*FILE)
        self.analyze = cls(SPEC.name, self.knowledge, ListSink(), **PARAMETERS)
        self.analyze.attach(self.planner)
        self.publisher = Publisher("monitor")
        self.publisher.connect(self.analyze.inbox)
        door = {"width": WIDTH, "height": 1.2} | door
        self.knowledge.world.place("door", Pose2(0.0, 0.0, 0.0), kind="door", **door)

    def watch(
        self,
        wall: Wall,
        *,
        x: float = -1.2,
        y: float = 0.0,
        yaw: float = 0.0,
        height: float = 0.8,
        tilt: float = 0.0,
        sweep: float = 0.25,
    ) -> bool | None:
        """Turn within a second, by `sweep` to both sides, with true ranges to a wall; returns `open` of the door."""
        for turn in np.linspace(yaw - sweep, yaw + sweep, 21).tolist():
            self.publisher.publish(
                self.clock.now(),
                {
                    "ring": [self._range(wall, x, y, turn + 2.0 * math.pi * i / BEAMS) for i in range(BEAMS)],
                    "pose": [x, y, turn],
                    "height": [height],
                    "tilt": [tilt],
                },
            )
            self.analyze.run(self.clock.now())
            self.clock.advance()
        return self.knowledge.graph.get("door", "open")

    def _range(self, wall: Wall, x: float, y: float, bearing: float) -> float:
        x, y, found = x + RADIUS * math.cos(bearing), y + RADIUS * math.sin(bearing), math.inf
        for angle in (bearing - math.radians(13.5), bearing, bearing + math.radians(13.5)):
            if x * math.cos(angle) < 0.0 and wall(y - x * math.tan(angle)):
                found = min(found, -x / math.cos(angle))
        return found if found <= 2.0 else math.inf


def closed(along: float) -> bool:
    return True


def opened(along: float) -> bool:
    return abs(along) > 0.5 * WIDTH


@pytest.mark.parametrize("yaw", [0.0, 0.3, math.pi / 2, math.pi])
def test_a_door_that_beams_pass_is_open_and_one_with_echoes_is_closed(yaw: float) -> None:
    assert Watcher().watch(opened, yaw=yaw) is True
    assert Watcher().watch(closed, yaw=yaw) is False


def test_the_change_and_the_observation_name_door_robot_and_confidence() -> None:
    watcher = Watcher()
    watcher.watch(opened)
    graph = watcher.knowledge.graph
    node = "door seen by Q"
    assert (graph.related(node, "observes"), graph.related(node, "made_by")) == (["door"], ["Q"])
    seen = graph.attributes(node)
    assert seen["pose"][:2] == (-1.2, 0.0)
    assert 0.95 < seen["confidence"] < 1.0
    assert 0.0 < seen["time"] < 1.0
    sample = watcher.planner.inbox.drain()[0]
    assert (sample.value.kind, sample.value.subject, sample.value.values["open"]) == ("door", "door", True)


@pytest.mark.parametrize("wall", [opened, closed])
def test_the_confidence_of_the_observation_rises_with_the_evidence(wall: Wall) -> None:
    watcher = Watcher()
    for _ in range(3):
        watcher.watch(wall)
    assert watcher.knowledge.graph.get("door seen by Q", "confidence") > 0.985
    found = [sample.value.values["confidence"] for sample in watcher.planner.inbox.drain()]
    assert found == sorted(found)
    assert 2 <= len(found) <= 4, "each doubles the odds"


def test_a_door_that_closes_is_noticed() -> None:
    watcher = Watcher()
    assert watcher.watch(opened) is True
    watcher.watch(closed)
    assert watcher.watch(closed) is False


def test_what_was_only_said_gets_an_observation_too() -> None:
    watcher = Watcher(open=False)
    assert watcher.watch(closed) is False
    assert watcher.knowledge.graph.has("door seen by Q")


@pytest.mark.parametrize(
    "where",
    [
        {"height": 1.25},  # the ring is over the top of the doorway
        {"height": 0.05},  # or as low as the floor
        {"tilt": 0.6},
        {"x": -2.2},  # out of range
        {"x": -1.0, "y": 1.6},  # beside the doorway
        {"height": math.nan},
        {"tilt": math.nan},
    ],
)
def test_a_door_out_of_view_stays_unknown(where: dict[str, float]) -> None:
    for wall in (opened, closed):
        assert Watcher().watch(wall, **where) is None


def test_a_gap_that_is_too_narrow_is_not_open() -> None:
    assert Watcher().watch(lambda along: abs(along) > 0.25, x=-0.9) is not True


def test_a_look_through_a_part_of_the_doorway_is_not_enough() -> None:
    assert Watcher().watch(opened, sweep=0.0) is None


@pytest.mark.parametrize("unknown", [{"width": None}, {"height": None}, {"pose": None}])
def test_a_door_without_its_size_or_place_stays_unknown(unknown: dict[str, None]) -> None:
    watcher = Watcher()
    watcher.knowledge.graph.set("door", **unknown)
    assert watcher.watch(opened) is None
