"""The limit on exceptions of content: three within 10 s fail the mission, however many there are further apart."""

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.agent.exceptions import LIMIT, WINDOW, ContentExceptions
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.raised import Raised
from rocs_bt.event import ContentRaised, ListSink
from rocs_bt.interfaces.pipeline import Pipeline

STEP = 0.05  # [s]


class Asked:
    """A plan that notes how often it is asked again."""

    count = 0

    def replan(self, by):
        self.count += 1


def play(periods, kind="leaf"):
    """Content that raises in some control periods: whether the mission failed after each, and the events."""
    clock, sink, plan = SimulatedClock(STEP), ListSink(), Asked()
    exceptions = ContentExceptions("R", Pipeline(clock, sink, "R"), plan, clock, sink)
    failed = []
    for wait in (after - before for before, after in pairwise([0, *periods])):
        clock.advance(wait)
        exceptions.take(Raised(kind, "x", "ValueError: no"))
        failed.append(bool(exceptions.failure))
    return failed, sink.events, plan, exceptions


@given(st.lists(st.integers(0, 400), max_size=12).map(sorted))
def test_the_mission_fails_at_the_third_exception_within_ten_seconds(periods):
    failed, events, plan, exceptions = play(periods)
    window = round(WINDOW / STEP)
    crowded = [len([p for p in periods[: i + 1] if periods[i] - p <= window]) >= LIMIT for i in range(len(periods))]
    assert failed == [any(crowded[: i + 1]) for i in range(len(periods))]
    assert plan.count == failed.count(False)
    assert len([e for e in events if isinstance(e, ContentRaised)]) == len(periods)
    assert (exceptions.failure == "leaf 'x' raised ValueError: no; 3 exceptions within 10 s") == any(failed)


@given(st.lists(st.integers(0, 400), max_size=12).map(sorted))
def test_a_reflexs_actions_do_not_count(periods):
    failed, events, plan, _ = play(periods, "reflex action")
    assert not any(failed)
    assert plan.count == 0
    assert {e.effect for e in events} <= {"stops until the latch of the rule clears"}
