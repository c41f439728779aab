"""Cost of the fold: what is repeated thousands of times costs the same for each event, and clues are few."""

import math
import sys

import pytest

from rocs_bt.base.geometry import Pose2
from rocs_bt.event import (
    BodyMoved,
    KnowledgeChanged,
    NodeTicked,
    RuleChanged,
    SensorFailed,
    SensorRead,
    SignalsWritten,
    TicketChanged,
    pack,
)
from rocs_bt.record.file.header import AgentInfo, BodyInfo, GuardInfo, Outline, RunHeader, SensorInfo, SignalInfo
from rocs_bt.record.fold.clue import Clues
from rocs_bt.record.fold.tracks import Tracks

HULL = ((0.3, 0.2), (-0.3, 0.2), (-0.3, -0.2), (0.3, -0.2))
GUARD = GuardInfo(rule="f/A", when="min(front) < 1 m", sources=("min(front) < 1 m",))
AGENT = AgentInfo(
    name="R",
    robot="r",
    mission="m",
    signals=(SignalInfo(name="front", units=("m",)),),
    guards=(GUARD, *(GuardInfo(rule=f"f/B{k}", when="", sources=("",)) for k in range(40))),
    sensors=(SensorInfo(name="sonar", signals=("front",)),),
)
HEADER = RunHeader(
    scenario="x",
    seed=1,
    agents=(AGENT,),
    bodies=(BodyInfo(name="R", hull=HULL),),
    outlines=(Outline.box("wall", Pose2(1.0, 0.0, 0.0), (0.2, 2.0)),),
)
R = {"agent": "R"}


def moved(t):
    return BodyMoved(t=t, agent="R", body="R", x=1e-3 * math.sin(t), y=0.0, yaw=0.0)


def ticket(t, i, state, by, priority="NORMAL"):
    return TicketChanged(t=t, ticket=i, state=state, action="GoTo", priority=priority, by=by, **R)


def rule(t, phase, name="f/A"):
    return RuleChanged(t=t, rule=name, phase=phase, priority=1, reading="front 0.3 m", **R)


def signal(t, value):
    return SignalsWritten(t=t, monitor="m", signals=("front",), sizes=(1,), data=pack([value]), **R)


def tickets(by, priority):
    return lambda i, t: [moved(t), ticket(t, i, "RUNNING", by, priority), ticket(t, i, "FAILED", by, priority)]


def fires_again(i, t):
    first = [rule(t, "latched")] if i == 0 else []
    return [moved(t), signal(t, 0.3), *first, rule(t, "fired again")]


def latches(i, t):
    return [moved(t), signal(t, 0.3), *(rule(t, phase) for phase in ("latched", "fired", "released", "ended"))]


def latches_blind(i, t):
    failed = [SensorFailed(t=t, sensor="sonar", detail="cable", **R)] if i == 0 else []
    return [signal(t, math.nan if i else 0.3), *failed, rule(t, "latched"), rule(t, "released")]


def of_many(i, t):
    return [rule(t, phase, f"f/B{i % 40}") for phase in ("latched", "released")]


def sensor(i, t):
    read = SensorRead(t=t + 0.02, sensor="sonar", stamp=t, data=pack([1.0]), **R)
    return [SensorFailed(t=t, sensor="sonar", detail="cable", **R), read]


def node(i, t):
    return [NodeTicked(t=t, node="a/b", status=status, feedback=status, **R) for status in ("RUNNING", "FAILURE")]


def knowledge(i, t):
    changes = [
        ("node added", "object", None),
        ("attribute", "x", 0.5),
        ("edge added", "at", "dock"),
        ("node removed", "", None),
    ]
    return [KnowledgeChanged(t=t, what=w, subject=f"cone{i}", name=n, value=v, **R) for w, n, v in changes]


REPEATED = {
    "an action of the plan fails": tickets("root/GoTo", "NORMAL"),
    "an action of a reflex fails": tickets("f/A", "HIGH"),
    "a rule fires again": fires_again,
    "a rule latches and releases": latches,
    "a rule latches without its sensor": latches_blind,
    "one of many rules changes": of_many,
    "a sensor fails and answers": sensor,
    "a node fails and runs": node,
    "an object comes and goes": knowledge,
}


@pytest.mark.parametrize("repeated", REPEATED.values(), ids=REPEATED)
def test_each_repetition_costs_the_same(repeated):
    """Counted in calls, so that no other process disturbs it."""
    tracks, calls = Tracks(HEADER), [0]

    def count(frame, event, argument):
        calls[0] += event in ("call", "c_call")

    def cost(first, last):
        events = [event for i in range(first, last) for event in repeated(i, 0.05 * i)]
        calls[0] = 0
        sys.setprofile(count)
        try:
            tracks.take(events)
        finally:
            sys.setprofile(None)
        return calls[0] / len(events)

    early = cost(0, 100)
    cost(100, 1900)
    late = cost(1900, 2000)
    assert late < 1.2 * early
    assert late < 200


@pytest.mark.parametrize("name", ["an action of the plan fails", "an action of a reflex fails", "a rule fires again"])
def test_what_fails_again_and_again_has_one_clue_a_second(name, monkeypatch):
    nearest, times = Clues.nearest, []
    monkeypatch.setattr(
        Clues, "nearest", lambda self, agent, t, *rest: times.append(t) or nearest(self, agent, t, *rest)
    )
    tracks = Tracks(HEADER)
    tracks.take(event for i in range(3000) for event in REPEATED[name](i, 0.02 * i))
    assert times[0] == 0.0
    assert 60 <= len(times) <= 61
    clues = [text for key, track in tracks.items() if key.topic == "clue" for text in track.v if text]
    assert clues[0] == "in the recorded world 'wall' is nearest, 0.60 m away"


def test_failures_of_several_leaves_at_once_have_a_clue_each():
    tracks = Tracks(HEADER)
    tracks.take([moved(0.0), *(ticket(0.0, i, "FAILED", f"root/leaf{i}") for i in range(5))])
    assert len(tracks.of("R", "clue")) == 5
