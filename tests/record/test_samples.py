"""Samples of a recording are what the reflexes saw; nothing is made up."""

import math

import numpy as np
import pytest

from rocs_bt import run
from rocs_bt.agent import Agent
from rocs_bt.base.errors import RecordingError
from rocs_bt.base.signal import Signal
from rocs_bt.base.units import ANGLE, LENGTH, SPEED
from rocs_bt.catalog import Catalog
from rocs_bt.event import (
    AgentStopped,
    BodyMoved,
    ContactBegan,
    KnowledgeChanged,
    MinClearanceLowered,
    SignalsWritten,
    pack,
)
from rocs_bt.record import AgentInfo, Recording, RunHeader, SignalInfo, environment_of, samples
from rocs_bt.record.fold.samples import Newest, modes, stopped
from rocs_bt.record.fold.tracks import Tracks

SIGNALS = (
    SignalInfo.of(Signal("front", 2, (LENGTH,), (0.0, math.inf), max_age=0.15)),
    SignalInfo.of(Signal("estimate", 1, (SPEED,), max_age=1.0), late=True),
)
R1 = AgentInfo(name="R1", robot="rover", mission="m", signals=SIGNALS)


def wrote(t, **signals):
    data = pack(v for values in signals.values() for v in values)
    sizes = tuple(map(len, signals.values()))
    return SignalsWritten(t=t, agent="R1", monitor="m", signals=tuple(signals), sizes=sizes, data=data)


def moved(t, x=0.0):
    return BodyMoved(t=t, agent="R1", body="R1", x=x, y=0.0, yaw=0.0)


def tracks_of(*events):
    tracks = Tracks(RunHeader(scenario="s", seed=1, agents=(R1,)))
    tracks.take(events)
    return tracks


def values(*events):
    return samples(tracks_of(*events), R1)[1]


@pytest.mark.parametrize("scenario", ["exp1", "exp3_localised"])
def test_they_are_the_live_snapshots_to_the_bit(scenario, monkeypatch, tmp_path):
    seen, react = [], Agent.react

    def watched(self, t):
        table = self.knowledge.signals
        seen.append((self.name, t, table.snapshot(t, np.empty(table.size)).tobytes()))
        react(self, t)

    monkeypatch.setattr(Agent, "react", watched)
    result = run(scenario, Catalog(), seed=3, out=tmp_path, duration=3.0, report=False)
    recording = Recording.open(result.recording)
    for info in recording.header.agents:
        tracks = Tracks.of_recording(recording)
        rows = zip(*samples(tracks, info), strict=True)
        found = [(info.name, t, x.tobytes()) for t, x in rows if t < stopped(tracks, info.name)]
        assert found == [each for each in seen if each[0] == info.name]
        assert len(found) == 60


@pytest.mark.parametrize("scenario", ["exp1", "exp3_localised"])
def test_the_newest_sample_is_that_of_the_whole_run(scenario, tmp_path):
    result = run(scenario, Catalog(), seed=3, out=tmp_path, duration=2.0, report=False)
    recording = Recording.open(result.recording)
    for info in recording.header.agents:
        times, rows = samples(Tracks.of_recording(recording), info)
        tracks, size = Tracks(recording.header), environment_of(info).size
        newest, events = Newest(tracks, info, environment_of(info).names), list(recording.events())
        for t, after, row in zip(times, [*times[1:], 99.0], rows, strict=True):
            while events and not (events[0].agent == info.name and events[0].t >= after):
                tracks.emit(events.pop(0))
            np.testing.assert_array_equal(newest.at(t)[:size], row)


def test_a_value_holds_until_it_is_too_old_and_out_of_bounds_is_invalid():
    found = values(wrote(0.0, front=[1.0, -1.0]), moved(0.0), moved(0.1), moved(0.2))
    np.testing.assert_array_equal(found[:, :2], [[1.0, math.nan]] * 2 + [[math.nan] * 2])


def test_an_older_stamp_counts():
    event = wrote(0.1, front=[1.0, 1.0])
    late = SignalsWritten(**{f: getattr(event, f) for f in event.__struct_fields__ if f != "stamp"}, stamp=0.0)
    assert math.isnan(values(late, moved(0.16))[-1, 0])
    assert values(event, moved(0.16))[-1, 0] == 1.0
    both = tracks_of(event, wrote(0.15, front=[2.0, 2.0]), late)
    assert both.get("R1", "signal", "front").stamps == [0.1, 0.15, 0.0]


def test_what_an_analyser_writes_and_a_new_mode_are_seen_one_period_later():
    mode = KnowledgeChanged(t=0.0, agent="R1", what="attribute", subject="R1", name="mode", value="dock")
    tracks = tracks_of(wrote(0.0, front=[1.0, 1.0]), wrote(0.0, estimate=[0.5]), mode, moved(0.05))
    times, found = samples(tracks, R1)
    assert modes(tracks, "R1", times) == ["", "dock"]
    np.testing.assert_array_equal(found[:, 2], [math.nan, 0.5])


def test_the_truth_is_behind_the_signals():
    near = MinClearanceLowered(t=0.05, agent="R1", other="box", distance=0.3)
    touch = ContactBegan(t=0.04, agent="R1", other="box", kind="collision")
    strange = ContactBegan(t=0.04, agent="R2", other="box", kind="collision")
    first = Newest(tracks_of(moved(0.0)), R1, ()).at(0.0)
    stop = AgentStopped(t=0.05, agent="R1", by="x")
    tracks = tracks_of(moved(0.0), moved(0.05, x=2.0), near, touch, strange, stop, moved(1.0))
    second = Newest(tracks_of(moved(0.0), moved(0.05, x=2.0), near, touch, strange), R1, ()).at(0.05)
    no_height = [math.nan, math.nan]  # of a robot on wheels
    assert first[3:].tolist() == pytest.approx([math.inf, 0.0, 0.0, 0.0, *no_height, 0.0, 0.0], nan_ok=True, abs=0.0)
    assert second[3:].tolist() == pytest.approx([0.3, 2.0, 0.0, 0.0, *no_height, 1.0, 0.0], nan_ok=True, abs=0.0)
    assert samples(tracks, R1)[0] == [0.0, 0.05]
    assert stopped(tracks, "R1") == 0.05


def test_a_header_keeps_a_declaration():
    signal = Signal("pose", 3, (LENGTH, LENGTH, ANGLE), (-5.0, math.inf), 0.2)
    assert SignalInfo.of(signal).signal() == signal


def test_a_recording_without_signals_says_what_to_do():
    with pytest.raises(RecordingError, match=r"declare the signals of 'R1'.*Run the scenario again"):
        environment_of(AgentInfo(name="R1", robot="r", mission="m"))
