"""Publishers, inboxes and the wires that the architecture allows."""

import threading

import pytest

from rocs_bt.base.errors import WiringError
from rocs_bt.interfaces.channel import AnalyzeSubscriber, Inbox, MonitorSubscriber, Publisher, Stamped, check_wire


def test_samples_arrive_in_order_stamped_and_signed():
    inbox, publisher = Inbox(), Publisher("sonar")
    publisher.connect(inbox)
    publisher.connect(inbox)
    publisher.publish(0.05, "a")
    publisher.publish(0.10, "b")
    assert inbox.drain() == [Stamped(0.05, "sonar", "a"), Stamped(0.10, "sonar", "b")]
    assert inbox.drain() == []


def test_a_full_inbox_drops_the_oldest_and_counts():
    inbox = Inbox(capacity=3)
    for k in range(5):
        inbox.put(Stamped(float(k), "s", k))
    assert [s.value for s in inbox.drain()] == [2, 3, 4]
    assert inbox.overflows == 2


def test_two_publishers_may_feed_one_inbox_from_two_threads():
    # The published C++ code dies here: an observer with two publishers locks itself out.
    inbox = Inbox(capacity=10_000)
    publishers = [Publisher("a"), Publisher("b")]
    for publisher in publishers:
        publisher.connect(inbox)

    def publish(publisher):
        for k in range(2000):
            publisher.publish(float(k), k)

    threads = [threading.Thread(target=publish, args=(p,)) for p in publishers]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    samples = inbox.drain()
    for name in ("a", "b"):
        assert [s.value for s in samples if s.source == name] == list(range(2000))


def test_waiting_ends_with_a_sample_or_a_stop():
    inbox = Inbox()
    assert inbox.wait(0.001, lambda: False) is False
    threading.Timer(0.02, lambda: inbox.put(Stamped(0.0, "s", 1))).start()
    assert inbox.wait(30.0, lambda: False) is True
    inbox.drain()
    stop = threading.Event()
    threading.Timer(0.02, lambda: (stop.set(), inbox.wake())).start()
    assert inbox.wait(30.0, stop.is_set) is False


def test_a_wire_that_the_architecture_does_not_have_is_refused():
    check_wire("Monitor 'm'", MonitorSubscriber(), MonitorSubscriber)
    with pytest.raises(WiringError, match=r"Monitor 'm' can be attached to an Analyze only, found AnalyzeSubscriber"):
        check_wire("Monitor 'm'", AnalyzeSubscriber(), MonitorSubscriber)
