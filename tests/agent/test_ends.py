"""However an agent ends: every ticket, every action and every node of the tree comes to its end, and that is told."""

from collections import Counter
from collections.abc import Iterator

import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel

from rocs_bt import run
from rocs_bt.analyze import PassRange
from rocs_bt.base.errors import DeviceError
from rocs_bt.catalog import Catalog
from rocs_bt.event import AgentStopped, BlockFailed, ContentRaised, ListSink, NodeTicked, OutcomeDecided, TicketChanged
from rocs_bt.interfaces.action import Action, AtomicAction, Body, MacroAction, Progress
from rocs_bt.record import Recording
from rocs_bt.running import replay

pytestmark = pytest.mark.usefixtures("awake")

AT = 0.5  # [s]
LOG: list[str] = []


@pytest.fixture(autouse=True)
def _empty_log():
    LOG.clear()


class Creep(AtomicAction):
    """Drives, and notes that it is stopped."""

    raises_at: float = 1e9
    refuses_to_stop: bool = False
    periods = 0

    def act(self, body: Body) -> Progress:
        if body.clock.now() >= self.raises_at:
            raise ZeroDivisionError("a worm")
        body.motion.command([0.05, 0.05])
        return Progress.RUNNING

    def stop(self, body: Body) -> None:
        LOG.append("creep stopped")
        if self.refuses_to_stop:
            raise DeviceError("it does not stop")


class Crawl(MacroAction):
    """Creeps, and notes that it is stopped and closed."""

    raises_at: float = 1e9
    refuses_to_stop: bool = False

    def decompose(self, body: Body) -> Iterator[Action]:
        try:
            yield Creep(raises_at=self.raises_at, refuses_to_stop=self.refuses_to_stop)
        finally:
            LOG.append("crawl closed")

    def stop(self, body: Body) -> None:
        LOG.append("crawl stopped")


class Watch(Behaviour):
    """Runs on; may raise, now or when it is shut down."""

    def __init__(self, mission, *, raises_at: float = 1e9, keeps: bool = False) -> None:
        super().__init__("watch")
        self.mission, self.raises_at, self.keeps = mission, raises_at, keeps

    def update(self) -> Status:
        if self.mission.clock.now() >= self.raises_at:
            raise ZeroDivisionError("a worm")
        return Status.RUNNING

    def shutdown(self) -> None:
        LOG.append("watch shut down")
        if self.keeps:
            raise OSError("it does not let go")


def mission(*, crawl=None, watch=None):
    """Two actions, of which one waits for the other, beside a leaf that watches."""

    def build(mission):
        leaves = [
            mission.act("Crawl", name="crawl", **(crawl or {})),
            mission.act("Stop", name="then stop"),
            Watch(mission, **(watch or {})),
        ]
        return Parallel("all", ParallelPolicy.SuccessOnAll(synchronise=False), leaves)

    return build


def play(build, sink=None, **more):
    sink = sink or ListSink()
    kwargs = {"duration": 1.0, "report": False, "missions": {"R2": build}, "sinks": [sink]} | more
    return run("exp1", Catalog(), **kwargs).summary.agents["R2"], sink.events


def check_ends(events):
    """Each ticket ended once, after it began; no node is left RUNNING; nothing comes after the verdict."""
    ended = Counter(e.ticket for e in events if isinstance(e, TicketChanged) and e.state not in ("QUEUED", "RUNNING"))
    begun = {e.ticket for e in events if isinstance(e, TicketChanged)}
    assert begun
    assert ended == Counter(begun)
    statuses = {e.node: e.status for e in events if isinstance(e, NodeTicked)}
    assert "RUNNING" not in statuses.values()
    verdict = next(i for i, e in enumerate(events) if isinstance(e, OutcomeDecided))
    assert not [e for e in events[verdict:] if isinstance(e, (NodeTicked, TicketChanged))]
    return statuses


@pytest.mark.parametrize("mode", ["lockstep", "threaded"])
def test_at_the_end_of_a_run(mode):
    _, events = play(mission(), mode=mode)
    statuses = check_ends(events)
    assert statuses == dict.fromkeys(("all", "all/crawl", "all/then stop", "all/watch"), "INVALID")
    by = {e.action: e.by for e in events if isinstance(e, TicketChanged) and e.state == "CANCELLED"}
    assert by == {"Crawl": "all/crawl", "Stop": "all/then stop"}
    assert [e for e in LOG if "shut" not in e] == ["creep stopped", "crawl stopped", "crawl closed"]
    assert LOG.count("watch shut down") == 1
    stopped = next(i for i, e in enumerate(events) if isinstance(e, AgentStopped))
    assert [e.status for e in events[stopped:] if isinstance(e, NodeTicked)] == ["INVALID"] * 4


@pytest.mark.parametrize("mode", ["lockstep", "threaded"])
def test_after_the_failure_of_a_block(mode, monkeypatch):
    sound = PassRange.process

    def process(self, samples):
        if samples[-1].t >= AT:
            raise ZeroDivisionError("a worm")
        return sound(self, samples)

    monkeypatch.setattr(PassRange, "process", process)
    told, events = play(mission(), mode=mode)
    assert told.outcome == "error"
    assert "R2/analyze obstacle" in told.reason
    assert len([e for e in events if isinstance(e, BlockFailed)]) == 1
    check_ends(events)
    states = {e.action: (e.state, e.by) for e in events if isinstance(e, TicketChanged)}
    assert states == dict.fromkeys(("Stop", "Crawl"), ("CANCELLED", "the failure of block analyze obstacle"))
    assert Counter(LOG) == Counter(["watch shut down", "creep stopped", "crawl stopped", "crawl closed"])


@pytest.mark.parametrize("mode", ["lockstep", "threaded"])
@pytest.mark.parametrize("content", ["leaf", "action"])
def test_after_content_raised_beyond_its_limit(content, mode):
    broken = {"leaf": {"watch": {"raises_at": AT}}, "action": {"crawl": {"raises_at": AT}}}[content]
    told, events = play(mission(**broken), mode=mode)
    assert told.outcome == "failed"
    assert sum(told.exceptions.values()) == 3
    assert not [e for e in events if isinstance(e, BlockFailed)]
    check_ends(events)
    assert LOG.count("watch shut down") == 1
    assert LOG.count("creep stopped") == LOG.count("crawl stopped")
    if content == "action":
        assert [e.state for e in events if isinstance(e, TicketChanged) and e.action == "Crawl"].count("FAILED") == 3
        assert LOG.count("crawl closed") == 3


@pytest.mark.parametrize("fault", [{}, {"crawl": {"raises_at": AT}}, {"watch": {"raises_at": AT}}])
def test_a_replay_agrees_on_the_ends(fault, tmp_path):
    play(mission(**fault), out=tmp_path)
    recording = Recording.open(tmp_path)
    check_ends(list(recording.events()))
    assert replay(recording, Catalog(), missions={"R2": mission(**fault)}) is None


@pytest.mark.parametrize(
    ("fault", "content", "detail"),
    [
        ({"watch": {"keeps": True}}, "leaf all/watch", "OSError: it does not let go"),
        ({"crawl": {"refuses_to_stop": True}}, "action Creep", "DeviceError: it does not stop"),
    ],
)
def test_what_does_not_let_go_at_the_end_is_told_and_keeps_nothing_else_from_ending(fault, content, detail):
    told, events = play(mission(**fault))
    check_ends(events)
    (raised,) = [e for e in events if isinstance(e, ContentRaised)]
    assert (raised.detail, raised.effect) == (detail, "none: the run is over")
    assert told.exceptions == {content: 1}
    assert told.outcome == "timeout"
    assert not [e for e in events if isinstance(e, BlockFailed)]
    assert LOG == ["watch shut down", "creep stopped", "crawl stopped", "crawl closed"]
