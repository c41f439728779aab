"""Events that are handed on together reach the same sinks, in the same order, as those that go one by one."""

import pytest

from rocs_bt.event import BodyMoved, ListSink, Said
from rocs_bt.running.run_record import EventBatch


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
