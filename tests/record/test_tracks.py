"""Tracks: what held at any time, against a reading of the events until then."""

import math
import random

import msgspec
import pytest

from rocs_bt.event import (
    ActuatorCommanded,
    BlackboardChanged,
    KnowledgeChanged,
    MotionHeld,
    MotionReleased,
    NodeTicked,
    PathPlanned,
    RuleChanged,
    SensorFailed,
    SensorRead,
    SignalsWritten,
    SubtreeSwapped,
    TicketChanged,
    TreeNode,
    pack,
)
from rocs_bt.knowledge.history import GraphState
from rocs_bt.record.file.header import BodyInfo, Fan, RunHeader
from rocs_bt.record.fold.states import TrackKey
from rocs_bt.record.fold.track import Curve, Steps
from rocs_bt.record.fold.tracks import TOPICS, Tracks

from .. import synthetic


@pytest.fixture(scope="module")
def tracks(recording):
    return Tracks.of_recording(recording)


def test_the_state_at_any_time_is_that_of_the_events_before(recording, tracks):
    for t in sorted(random.Random(3).uniform(0.0, tracks.end) for _ in range(30)):
        nodes, tickets, signals, commands, graph = {}, {}, {}, {}, GraphState("R2")
        for event in (e for e in recording.events() if e.t <= t and e.agent == "R2"):
            if isinstance(event, NodeTicked):
                nodes[event.node] = event.status
            elif isinstance(event, TicketChanged):
                tickets[str(event.ticket)] = event.state
            elif isinstance(event, SignalsWritten):
                signals.update(event.values)
            elif isinstance(event, ActuatorCommanded):
                commands[event.actuator] = event.values
            elif isinstance(event, KnowledgeChanged):
                graph.apply(event)
        assert nodes == tracks.state(t, "R2", "node")
        assert tickets == {n: e.state for n, e in tracks.state(t, "R2", "ticket").items()}
        for topic, values in (("signal", signals), ("command", commands)):
            curves = tracks.of("R2", topic).items()
            assert values == {name: curve.last(t)[1] for name, curve in curves if curve.last(t) is not None}
        facts = tracks.state(t, "R2", "fact")
        assert set(graph.nodes()) == {name for name in facts if "\n" not in name}
        for name, value in facts.items():
            node, _, attribute = name.partition("\n")
            if attribute and "\n" not in attribute:
                assert graph.attributes(node)[attribute] == value


@pytest.mark.parametrize(
    ("phases", "latched", "active", "waits", "fired"),
    [
        (["latched"], True, False, False, 0),
        (["latched", "waits"], True, False, True, 0),
        (["latched", "waits", "released"], False, False, False, 0),
        (["latched", "waits", "fired"], True, True, False, 1),
        (["latched", "fired"], True, True, False, 1),
        (["latched", "fired", "released"], False, True, False, 1),
        (["latched", "fired", "released", "ended"], False, False, False, 1),
        (["latched", "fired", "fired again"], True, True, False, 1),
        (["latched", "fired", "released", "latched"], True, True, False, 1),
    ],
)
def test_a_rules_latch_and_its_action_are_two_things(phases, latched, active, waits, fired):
    tracks = Tracks(synthetic.header())
    events = [RuleChanged(t=i, agent="R2", rule="a/B", phase=p, priority=1) for i, p in enumerate(phases)]
    tracks.take(events)
    state = tracks.get("R2", "rule", "a/B").at(99.0)
    assert (state.latched, state.active, state.waits, state.fired) == (latched, active, waits, fired)


def test_what_a_removed_node_had_is_gone_and_comes_back_with_it():
    tracks = Tracks(synthetic.header())
    for t, what, name, value in [
        (0.0, "node added", "object", None),
        (1.0, "attribute", "radius", 0.3),
        (1.0, "edge added", "near", "wall"),
        (2.0, "node removed", "", None),
        (3.0, "node added", "object", None),
    ]:
        tracks.emit(KnowledgeChanged(t=t, agent="R2", what=what, subject="box", name=name, value=value))
    assert tracks.state(1.5, "R2", "fact") == {"box": "object", "box\nradius": 0.3, "box\nnear\nwall": {}}
    assert tracks.state(2.5, "R2", "fact") == {}
    assert tracks.state(3.5, "R2", "fact") == {"box": "object"}


def test_after_a_swap_the_nodes_that_went_have_no_status(recording):
    tracks = Tracks(recording.header)
    tracks.take(e for e in recording.events() if e.t < 2.0)
    nodes = TreeNode(path="go to", type="Sequence", children=("go to/Stop",)), TreeNode(path="go to/Stop", type="Act")
    tracks.emit(SubtreeSwapped(t=2.0, agent="R2", node="go to/GoTo", by="go to/Stop", nodes=nodes))
    assert "go to/GoTo" in tracks.state(1.9, "R2", "node")
    assert set(tracks.state(2.0, "R2", "node")) <= {"go to", "go to/Stop"}
    assert [n.path for n in tracks.get("R2", "tree").at(2.0)] == ["go to", "go to/Stop"]
    assert len(tracks.get("R2", "tree").at(1.9)) == 3


def test_the_log_has_the_sentences_and_what_they_are_about():
    tracks = Tracks(synthetic.header())
    tracks.take(
        [
            SensorFailed(t=1.0, agent="R2", sensor="sonar", detail="no answer"),
            MotionHeld(t=2.0, agent="R2", actuator="wheels", reason="emergency stop"),
            MotionReleased(t=3.0, agent="R2", actuator="wheels", by="Ann"),
            BlackboardChanged(t=4.0, agent="R2", key="path", value="3 poses", subtree="top/S"),
        ]
    )
    assert [(line.text, line.about) for line in tracks.log] == [
        ("sensor sonar failed: no answer", TrackKey("R2", "sensor", "sonar")),
        ("wheels held in neutral: emergency stop", TrackKey("R2", "hold", "wheels")),
        ("wheels released by Ann", TrackKey("R2", "hold", "wheels")),
        ("path = 3 poses in top/S", TrackKey("R2", "board", "top/S\npath")),
    ]
    assert [tracks.get("R2", "hold", "wheels").at(t) for t in (1.0, 2.5, 3.5)] == [None, "emergency stop", ""]


def test_only_the_asked_topics_are_followed(recording):
    for topic in TOPICS:
        tracks = Tracks(recording.header, [topic])
        tracks.take(recording.events())
        whole = Tracks(recording.header)
        whole.take(recording.events())
        for key, track in tracks.items():
            assert track.t == whole.get(*key).t


def test_a_value_that_does_not_change_costs_nothing_and_a_late_one_is_found():
    steps = Steps()
    for t, value in [(0.0, "a"), (0.1, "a"), (0.2, "b"), (0.2, "c"), (0.3, "c")]:
        steps.put(t, value)
    assert (steps.t, steps.v) == ([0.0, 0.2], ["a", "c"])
    assert [steps.at(t) for t in (-1.0, 0.0, 0.19, 0.2, 9.0)] == [None, "a", "a", "c", "c"]
    assert [(s.begin, s.end, s.value) for s in steps.spans(1.0)] == [(0.0, 0.2, "a"), (0.2, 1.0, "c")]


def test_a_sample_is_no_longer_valid_after_its_age():
    curve = Curve(2, max_age=0.5)
    curve.add(1.0, pack([1.0, 2.0]))
    curve.add(1.1, pack([1.0]))  # of another width
    assert list(curve.at(1.5)) == [1.0, 2.0]
    assert all(map(math.isnan, [*curve.at(0.9), *curve.at(1.6)]))


def test_a_long_run_of_a_wide_scanner_is_thinned_and_its_newest_scan_stays():
    fan = Fan(x=0.0, y=0.0, yaw=-2.0, step=4.0 / 719, rays=720, reach=10.0)
    tracks = Tracks(RunHeader(scenario="s", seed=1, bodies=(BodyInfo(name="R2", hull=(), fans={"lidar": fan}),)))
    for k in range(5_000):
        values = [k + 0.001 * ray for ray in range(720)]
        tracks.emit(SensorRead(t=0.05 * k, agent="R2", sensor="lidar", stamp=0.05 * k, data=pack(values)))
        track = tracks.get("R2", "scan", "lidar")
        assert track.t[-1] == 0.05 * k
    assert (track.ray, track.width) == (6, 120)
    assert 1_000 < len(track.t) <= 2_401
    assert list(track.at(0.05 * 4_999)) == [4_999 + 0.001 * ray for ray in range(0, 720, 6)]
    assert track.t[:-1] == [0.05 * k for k in range(0, 5_000, track.every)][: len(track.t) - 1]


def test_the_path_is_that_of_the_running_action():
    tracks = Tracks(RunHeader(scenario="x", seed=1))

    def ticket(t, number, state, priority="NORMAL"):
        kind = "GoTo" if priority == "NORMAL" else "Flinch"
        tracks.emit(
            TicketChanged(t=t, agent="R2", ticket=number, action=kind, priority=priority, state=state, by="leaf")
        )

    ticket(0.0, 1, "RUNNING")
    tracks.emit(PathPlanned(t=0.0, agent="R2", points=((0.0, 0.0), (1.0, 0.0))))
    ticket(0.5, 2, "QUEUED")
    ticket(1.0, 2, "CANCELLED")  # the other one drives on
    tracks.emit(PathPlanned(t=1.5, agent="R2", points=((0.5, 0.0), (2.0, 0.0))))
    ticket(2.0, 1, "CANCELLED")
    ticket(2.0, 3, "RUNNING", "HIGH")
    ticket(3.0, 3, "SUCCEEDED", "HIGH")
    track = tracks.get("R2", "path")
    assert [track.at(t) and track.at(t)[-1][0] for t in (0.0, 1.2, 1.6, 2.0, 3.0)] == [1.0, 1.0, 2.0, None, None]


def test_events_of_threads_are_taken_in_the_order_of_their_times():
    random_order = random.Random(5)
    events = synthetic.events(3.0)
    nearly = sorted(events, key=lambda event: event.t + random_order.uniform(0.0, 0.2))
    header = msgspec.structs.replace(synthetic.header(), mode="threaded")
    ordered, taken = Tracks(synthetic.header()), Tracks(header)
    ordered.take(sorted(nearly, key=lambda event: event.t))
    taken.take(nearly)
    for key, track in taken.items():
        assert track.t == sorted(track.t), key
        assert track.t == ordered.get(*key).t
