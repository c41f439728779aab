"""Where two streams of events differ."""

import math

import msgspec
import numpy as np
import pytest

from rocs_bt.event import (
    ActuatorCommanded,
    BodyMoved,
    Change,
    FollowerStepped,
    KnowledgeChanged,
    SensorRead,
    TicketChanged,
    pack,
)
from rocs_bt.record.explanation.diverge import compare, describe, first_differences
from rocs_bt.record.fold.tracks import Tracks

from .. import synthetic


def test_a_recording_equals_what_was_emitted(recording):
    assert compare(recording.events(), synthetic.events()) is None


def test_wall_time_does_not_count():
    events = synthetic.events(3.0)
    later = [
        msgspec.structs.replace(e, solve_time=e.solve_time + 1.0) if isinstance(e, FollowerStepped) else e
        for e in events
    ]
    assert compare(events, later) is None
    off = [
        msgspec.structs.replace(e, cross_track=e.cross_track + 1e-12) if isinstance(e, FollowerStepped) else e
        for e in events
    ]
    assert compare(events, off).fields == ("cross_track",)


def test_the_first_difference_is_found_with_what_came_before():
    events = synthetic.events(3.0)
    at = next(i for i, e in enumerate(events) if isinstance(e, TicketChanged) and e.action == "AvoidCollision")
    changed = [*events]
    changed[at] = msgspec.structs.replace(events[at], state="FAILED")
    changed[-1] = events[0]
    found = compare(events, changed)
    assert found.index == at
    assert found.t == events[at].t
    assert found.fields == ("state",)
    assert found.before == tuple(events[at - 5 : at])
    text = str(found)
    assert f"t = {events[at].t:.3f} s, at event {at + 1}" in text
    assert "recorded" in text
    assert "state=FAILED" in text
    assert "differing fields: state" in text


def test_a_stream_that_ends_early_differs_there():
    events = synthetic.events(1.0)
    found = compare(events, events[:-1])
    assert found.index == len(events) - 1
    assert found.found is None
    assert found.fields == ()
    assert "(the end)" in str(found)
    assert compare(events[:-1], events).expected is None
    assert compare(events[:-1], events, cut_off=True) is None
    assert compare(events, events[:-1], cut_off=True).found is None


@pytest.mark.parametrize(
    ("a", "b", "same"), [(math.nan, math.nan, True), (0.0, -0.0, False), (math.inf, math.nan, False)]
)
def test_numbers_are_compared_bit_by_bit(a, b, same):
    def one(x):
        return [Change(t=0.0, source="s", kind="k", values={"x": x})]

    assert (compare(one(a), one(b)) is None) is same


def test_the_order_of_parameters_does_not_count():
    a = Change(t=0.0, source="s", kind="k", values={"x": 1.0, "y": 2.0})
    b = Change(t=0.0, source="s", kind="k", values={"y": 2.0, "x": 1.0})
    assert compare([a], [b]) is None


def test_packed_values_are_told_as_numbers():
    (event, *_) = (e for e in synthetic.events(0.1) if isinstance(e, SensorRead) and e.sensor == "position")
    assert describe(event) == "t=0.000 R2 SensorRead sensor=position stamp=0 data=[-1, 2, -0.6]"


def test_the_first_difference_of_long_scans_is_short_and_names_the_place():
    ranges = [0.1 * k for k in range(720)]
    other = [*ranges[:300], 7.5, *ranges[301:]]
    a, b = (SensorRead(t=1.0, agent="R2", sensor="scan", stamp=1.0, data=pack(values)) for values in (ranges, other))
    found = compare([a, a, a, a, a, a, a], [a, a, a, a, a, a, b])
    assert found is not None
    text = str(found)
    assert len(text) < 2000
    assert "differing fields: data (first at [300]: recorded 30, replayed 7.5)" in text
    assert len(found.text(everything=True)) > 20_000


def tracks_of(events):
    tracks = Tracks(synthetic.header())
    tracks.take(events)
    return tracks


def test_equal_runs_have_no_difference_and_wall_time_does_not_count():
    events = synthetic.events(3.0)
    later = [msgspec.structs.replace(e, solve_time=0.5) if isinstance(e, FollowerStepped) else e for e in events]
    assert first_differences(tracks_of(events), tracks_of(later)) == []


def test_the_first_difference_is_that_of_the_track_that_changed():
    events = synthetic.events(5.0)
    whole, seen = tracks_of(events), set()
    for i in np.random.default_rng(4).integers(0, len(events), 60):
        event = events[i]
        if isinstance(event, BodyMoved):
            key, changed = ("motion", event.body, "pose", ""), msgspec.structs.replace(event, x=event.x + 0.011)
        elif isinstance(event, TicketChanged):
            key = ("decisions", "R2", "ticket", str(event.ticket))
            changed = msgspec.structs.replace(event, reason="other")
        elif isinstance(event, ActuatorCommanded):
            key, changed = (
                ("commands", "R2", "command", "wheels"),
                msgspec.structs.replace(event, data=pack([0.7, 0.7])),
            )
        else:
            continue
        (found,) = first_differences(whole, tracks_of([*events[:i], changed, *events[i + 1 :]]))
        assert (found.t, (found.kind, *found[2:5])) == (event.t, key)
        assert found.a != found.b
        seen.add(type(event))
    assert len(seen) >= 2


def test_numbers_differ_from_a_hundredth_on_and_only_if_one_is_infinite():
    def moved(x):
        return tracks_of([BodyMoved(t=0.0, agent="R2", body="R2", x=x, y=0.0, yaw=0.0)])

    for x, same in ((0.009, True), (0.011, False), (-0.011, False), (math.inf, False), (math.nan, False)):
        assert (first_differences(moved(0.0), moved(x)) == []) is same
        assert first_differences(moved(x), moved(x)) == []


def test_of_each_kind_there_is_the_earliest_with_what_both_runs_have():
    events = synthetic.events(3.0)
    short = tracks_of([e for e in events if e.t <= 2.0])
    found = first_differences(short, tracks_of(events))
    assert found == sorted(found, key=lambda each: each.t)
    assert len({each.kind for each in found}) == len(found) > 0
    for each in found:
        assert each.t > 2.0
        assert msgspec.json.decode(msgspec.json.encode(each._asdict()))["topic"] == each.topic


def test_what_only_one_run_has_is_named_as_such_in_both_orders():
    one = tracks_of([])
    other = tracks_of(
        [KnowledgeChanged(t=0.5, agent="R2", what="attribute", subject="cone", name="state", value="hot")]
    )
    said = "First difference of knowledge at t = 0.50 s, R2 cone state: "
    assert [str(each) for each in first_differences(one, other)] == [f"{said}first run nothing, second run hot."]
    assert [str(each) for each in first_differences(other, one)] == [f"{said}first run hot, second run nothing."]
