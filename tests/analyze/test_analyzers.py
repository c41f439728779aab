"""Analysers: only what changed is told, and stands in the graph."""

import math

import pytest

from rocs_bt.analyze import Analyze, PassOrientation, PassPosition, PassRange
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import WiringError
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import Change, ListSink
from rocs_bt.interfaces.channel import AnalyzeSubscriber, Publisher
from rocs_bt.knowledge import Knowledge


class Planner(AnalyzeSubscriber):
    """The far end of the wire."""

    def told(self):
        return [(s.value.kind, s.value.subject) for s in self.inbox.drain()]


class Bench:
    def __init__(self, cls, **parameters):
        self.clock, self.sink = SimulatedClock(0.05), ListSink()
        self.knowledge = Knowledge("R2", self.clock, self.sink)
        self.planner = Planner()
        self.analyze = cls("analyser", self.knowledge, self.sink, **parameters)
        self.analyze.attach(self.planner)
        self.publisher = Publisher("monitor")
        self.publisher.connect(self.analyze.inbox)

    def say(self, **signals):
        self.publisher.publish(self.clock.now(), signals)
        self.analyze.run(self.clock.now())
        return self.planner.told()


def test_arriving_and_leaving_are_told_once():
    bench = Bench(PassPosition)
    bench.knowledge.world.place("dock", Pose2(0.0, 0.0), kind="goal", tolerance=0.1)
    assert bench.say(pose=[1.0, 0.0, 0.0]) == []
    assert bench.say(pose=[0.05, 0.0, 0.0]) == [("arrived", "dock")]
    assert bench.say(pose=[0.04, 0.0, 0.0]) == []
    assert bench.knowledge.graph.related("R2", "at") == ["dock"]
    assert bench.say(pose=[math.nan] * 3) == [], "a lost pose is no departure"
    assert bench.say(pose=[0.3, 0.0, 0.0]) == [("left", "dock")]
    assert bench.knowledge.graph.related("R2", "at") == []


def test_turning_is_told_by_steps():
    bench = Bench(PassOrientation, step=0.5)
    told = [bench.say(pose=[0.0, 0.0, yaw]) for yaw in (3.0, 3.1, -3.1, -2.7, -2.6, -2.3)]
    assert told == [[], [], [], [("turned", "R2")], [], []]


def test_what_is_near_stands_in_the_graph_and_vanishes_again():
    bench = Bench(PassRange, groups=["front"], near=0.6, clear=0.8)
    assert bench.say(front=[math.inf, 0.7]) == []
    assert bench.say(front=[math.inf, 0.5]) == [("obstacle", "something front")]
    assert bench.knowledge.graph.related("R2", "near") == ["something front"]
    assert bench.say(front=[0.7, 0.7]) == [], "between near and clear nothing changes"
    assert bench.say(front=[math.inf, math.inf]) == [("clear", "something front")]
    assert bench.knowledge.world.objects() == []


def test_nothing_that_arrived_is_nothing_to_do():
    bench = Bench(PassRange)
    bench.analyze.run(0.0)
    assert [e for e in bench.sink.events if isinstance(e, Change)] == []


def test_an_analyser_may_listen_to_several_monitors_and_fuse_them():
    # In the published C++ code an observer with a second publisher dies of a deadlock.
    class Both(Analyze):
        def process(self, samples):
            merged = {}
            for sample in samples:
                merged.update(sample.value)
            if set(merged) >= {"left", "right"}:
                yield self.change(samples[-1].t, "gap", width=merged["left"][0] + merged["right"][0])

    bench = Bench(Both)
    other = Publisher("other monitor")
    other.connect(bench.analyze.inbox)
    other.publish(0.0, {"left": [0.4]})
    assert bench.say(right=[0.3]) == [("gap", "")]
    (change,) = [e for e in bench.sink.events if isinstance(e, Change)]
    assert change.values == {"width": 0.7}
    assert change.source == "analyser"


def test_an_analyser_attaches_to_a_plan_only():
    bench = Bench(PassRange)
    with pytest.raises(WiringError, match="can be attached to a Plan only, found PassRange"):
        bench.analyze.attach(bench.analyze)


def test_an_analyser_that_has_nothing_to_tell_may_return_nothing():
    class Silent(Analyze):
        def process(self, samples):
            self.knowledge.world.place("seen", Pose2(0.0, 0.0))

    bench = Bench(Silent)
    assert bench.say(pose=[0.0, 0.0, 0.0]) == []
    assert bench.knowledge.graph.has("seen")
