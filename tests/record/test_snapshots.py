"""Samples of a recording are what the reflexes saw; nothing is made up."""

import math

import numpy as np
import pytest

from rocs_bt import run
from rocs_bt.agent import Agent
from rocs_bt.catalog import Catalog
from rocs_bt.errors import RecordingError
from rocs_bt.event import (
    AgentStopped,
    BodyMoved,
    ContactBegan,
    KnowledgeChanged,
    MinClearanceLowered,
    SignalsWritten,
    pack,
)
from rocs_bt.record import AgentInfo, Recording, SignalInfo, Snapshots, environment_of, samples_of
from rocs_bt.record.snapshots import samples_in
from rocs_bt.signal import Signal
from rocs_bt.units import ANGLE, LENGTH, SPEED

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


def samples(*events):
    return list(samples_in(events, Snapshots(R1)))


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
        size = environment_of(info).size
        found = [(info.name, s.t, s.x[:size].tobytes()) for s in samples_of(recording, info) if s.felt]
        assert found == [each for each in seen if each[0] == info.name]
        assert len(found) == 60


def test_a_value_stands_until_it_is_too_old_and_out_of_bounds_is_invalid():
    found = samples(wrote(0.0, front=[1.0, -1.0]), moved(0.0), moved(0.1), moved(0.2))
    np.testing.assert_array_equal([s.x[:2] for s in found], [[1.0, math.nan]] * 2 + [[math.nan] * 2])


def test_an_older_stamp_counts():
    event = wrote(0.1, front=[1.0, 1.0])
    late = SignalsWritten(**{f: getattr(event, f) for f in event.__struct_fields__ if f != "stamp"}, stamp=0.0)
    assert math.isnan(samples(late, moved(0.16))[-1].x[0])
    assert samples(event, moved(0.16))[-1].x[0] == 1.0


def test_what_an_analyze_writes_and_a_new_mode_are_seen_one_period_later():
    mode = KnowledgeChanged(t=0.0, agent="R1", what="attribute", subject="R1", name="mode", value="dock")
    found = samples(wrote(0.0, front=[1.0, 1.0]), wrote(0.0, estimate=[0.5]), mode, moved(0.05))
    assert [(s.mode, s.x[2]) for s in found[1:]] == [("dock", 0.5)]
    assert (found[0].mode, math.isnan(found[0].x[2])) == ("", True)


def test_the_truth_stands_behind_the_signals():
    near = MinClearanceLowered(t=0.05, agent="R1", other="box", distance=0.3)
    touch = ContactBegan(t=0.04, agent="R1", other="box", kind="collision")
    strange = ContactBegan(t=0.04, agent="R2", other="box", kind="collision")
    found = samples(
        moved(0.0), moved(0.05, x=2.0), near, touch, strange, AgentStopped(t=0.05, agent="R1", by="x"), moved(1.0)
    )
    assert [s.felt for s in found] == [True, False]
    no_height = [math.nan, math.nan]  # of a robot on wheels
    first, second = (s.x[3:].tolist() for s in found)
    assert first == pytest.approx([math.inf, 0.0, 0.0, 0.0, *no_height, 0.0, 0.0], nan_ok=True, abs=0.0)
    assert second == pytest.approx([0.3, 2.0, 0.0, 0.0, *no_height, 1.0, 0.0], nan_ok=True, abs=0.0)


def test_a_header_keeps_a_declaration():
    signal = Signal("pose", 3, (LENGTH, LENGTH, ANGLE), (-5.0, math.inf), 0.2)
    assert SignalInfo.of(signal).signal() == signal


def test_a_recording_without_signals_says_what_to_do():
    with pytest.raises(RecordingError, match=r"declare the signals of 'R1'.*Run the scenario again"):
        Snapshots(AgentInfo(name="R1", robot="r", mission="m"))
