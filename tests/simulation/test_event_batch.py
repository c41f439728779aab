"""Events that are handed on together reach the same sinks, in the same order, as those that go one by one."""

import pytest

from rocs_bt.event import BodyMoved, ListSink, Said
from rocs_bt.record.header import AgentInfo, RunHeader
from rocs_bt.record.recorder import Recorder
from rocs_bt.running.metrics import Metrics
from rocs_bt.running.run_record import EventBatch

R2 = AgentInfo(name="R2", robot="pioneer_p3dx", mission="go_to")
HEADER = RunHeader(scenario="one", seed=1, agents=(R2,))


class Batches(ListSink):
    def __init__(self):
        super().__init__()
        self.sizes = []

    def take(self, events):
        self.events += events
        self.sizes.append(len(events))


def events(periods=40):
    for k in range(periods):
        t = 0.05 * k
        yield BodyMoved(t=t, agent="R2", body="R2", x=0.1 * k, y=0.0, yaw=0.0)
        yield BodyMoved(t=t, body="box", x=0.0, y=1.0, yaw=0.0)
        yield Said(t=t, agent="R2", node="say", text=f"{k}")


def test_all_come_in_their_order_and_once():
    one, other = Batches(), Batches()
    batch, told = EventBatch(one, other), list(events(2))
    for event in told:
        batch.emit(event)
    assert not one.events
    batch.flush()
    batch.flush()
    assert one.events == other.events == told
    assert one.sizes == [len(told)]


def test_what_a_sink_refuses_is_not_handed_on_again():
    class Broken(Batches):
        def take(self, events):
            raise OSError("no space left")

    before, batch = Batches(), None
    batch = EventBatch(before, Broken())
    batch.emit(next(events()))
    with pytest.raises(OSError, match="no space"):
        batch.flush()
    batch.flush()
    assert before.sizes == [1]


def test_a_recording_and_its_metrics_are_the_same(tmp_path):
    recorded, counted = [], []
    for together in (1, 3, 7, 1000):
        recorder, metrics = Recorder(tmp_path / f"{together}.mcap", HEADER), Metrics(HEADER)
        batch, told = EventBatch(metrics, recorder), list(events())
        for k, event in enumerate(told, 1):
            batch.emit(event)
            if k % together == 0:
                batch.flush()
        batch.flush()
        recorder.close()
        recorded.append((tmp_path / f"{together}.mcap").read_bytes())
        counted.append(metrics.of(R2, 9.0))
    plain, metrics = Recorder(tmp_path / "plain.mcap", HEADER), Metrics(HEADER)
    for event in events():
        plain.emit(event)
        metrics.emit(event)
    plain.close()
    assert recorded == [(tmp_path / "plain.mcap").read_bytes()] * 4
    assert counted == [metrics.of(R2, 9.0)] * 4
    assert counted[0].path_length > 3.0
