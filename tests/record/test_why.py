"""What was known, planned, fired and sent at a time."""

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.event import KnowledgeChanged, ListSink, NodeTicked, RuleChanged, SignalsWritten, pack
from rocs_bt.record.explanation.evidence import graph_at
from rocs_bt.record.explanation.why import Why, explain
from rocs_bt.record.file.recorder import Recorder
from rocs_bt.record.file.recording import Recording
from rocs_bt.record.fold.tracks import Tracks

from .. import synthetic

FIRED = next(e for e in synthetic.events() if isinstance(e, RuleChanged))


def with_signals(**signals):
    data = pack(value for values in signals.values() for value in values)
    sizes = tuple(map(len, signals.values()))
    tracks = Tracks(synthetic.header())
    tracks.emit(SignalsWritten(t=1.0, agent="R2", monitor="m", signals=tuple(signals), sizes=sizes, data=data))
    return Why(tracks, 1.0)


def test_in_a_reflex_everything_is_there(recording):
    why = explain(recording, FIRED.t + 0.1)
    assert why.agent == "R2"
    assert why.mission.status("go to") == "RUNNING"
    assert {name: rule.firing for name, rule in why.rules.items()} == {FIRED.rule: (FIRED.t, "fired", FIRED.reading)}
    assert [(k.action, k.state, k.priority) for k in why.tickets.values()] == [("AvoidCollision", "RUNNING", "HIGH")]
    assert why.value("route", "wheels") == "reactive"
    assert why.value("atomic").action == "TurnAngle"
    assert graph_at(why).kind("origin") == "goal"
    text = why.text(everything=True)
    for part in [
        *["known", "planned", "fired", "sent", "true pose"],
        FIRED.reading,
        "0.10 s ago",
        "AvoidCollision(turn=1.05)",
        *["R1 at (", "R2 at (", "front = ", "rear = ", "pose = ", "wheel_speeds = "],
    ]:
        assert part in text


def test_the_answer_is_the_first_line(recording):
    first = str(explain(recording, FIRED.t + 0.1)).splitlines()[0]
    assert first == f"R2 acted because the rule AvoidCollision fired, 0.10 s ago: {FIRED.reading}."
    assert "because the leaf 'go to/GoTo' of its mission runs GoTo(" in explain(recording, FIRED.t - 0.1).answer
    end = next(
        e.t for e in synthetic.events() if isinstance(e, NodeTicked) and e.status == "SUCCESS" and e.node == "go to"
    )
    age = 19.0 - end
    assert explain(recording, 19.0).answer == f"R2 acted because its mission had ended with SUCCESS, {age:.2f} s ago."


@pytest.mark.parametrize(
    ("speed", "turn", "says"),
    [
        (0.0, 0.0, "was stationary"),
        (0.3, 0.0, "moved ahead"),
        (0.3, -1.0, "moved ahead turning right"),
        (-0.3, 0.0, "moved back"),
        (0.0, 1.0, "turned left"),
    ],
)
def test_the_motion_is_that_of_speed_and_turn_rate(speed, turn, says):
    why = with_signals(speed=[speed], turn_rate=[turn])
    link = "because" if says == "was stationary" else "without a command, while"
    assert why.answer == f"R2 {says} {link} no action was active."


@pytest.mark.parametrize(
    ("signals", "says"),
    [
        ({"speed": -0.03, "climb": 0.511}, "climbed"),
        ({"speed": 0.0, "climb": -0.4, "turn_rate": 1.0}, "descended turning left"),
        ({"speed": 0.0, "lateral_speed": 0.29}, "moved left"),
        ({"speed": 0.1, "lateral_speed": -0.29, "turn_rate": -1.0}, "moved right turning right"),
        ({"speed": -0.3, "lateral_speed": 0.2, "climb": 0.1}, "moved back"),
        ({"speed": 0.0, "lateral_speed": 0.01, "climb": float("nan")}, "was stationary"),
    ],
)
def test_the_motion_is_that_of_the_fastest_axis(signals, says):
    why = with_signals(**{name: [value] for name, value in signals.items()})
    link = "because" if says == "was stationary" else "without a command, while"
    assert why.answer == f"R2 {says} {link} no action was active."


def test_of_many_values_the_least_is_shown():
    why = with_signals(scan=[3.0, 0.5, *[float("inf")] * 30])
    assert "scan = 32 values, 2 finite, minimum 0.5 at [1]" in why.text(everything=True)


def test_before_and_after_it_no_rule_is_active(recording):
    before, after = explain(recording, FIRED.t - 0.05), explain(recording, 19.0)
    assert before.rules == after.rules == {}
    assert (before.fired, after.fired) == ("", FIRED.rule)
    assert after.value("rule", FIRED.rule).fired == 2
    assert "no active rule" in before.text(everything=True)
    assert "no open ticket" in after.text(everything=True)
    assert after.mission.status("go to") == "SUCCESS"


def test_a_time_as_typed_includes_its_period(recording):
    assert explain(recording, round(FIRED.t, 3)).rules


def test_the_graph_is_as_it_was(tmp_path):
    sink = ListSink()
    for t, what, subject, name, value in [
        (0.0, "node added", "R2", "robot", None),
        (0.0, "node added", "box", "object", None),
        (0.1, "attribute", "box", "width", 0.5),
        (0.2, "edge added", "R2", "near", "box"),
        (0.3, "edge removed", "R2", "near", "box"),
        (0.4, "node removed", "box", "object", None),
    ]:
        sink.emit(KnowledgeChanged(t=t, agent="R2", what=what, subject=subject, name=name, value=value))
    recorder = Recorder(tmp_path / "run.mcap", synthetic.header())
    for event in sink.events:
        recorder.emit(event)
    recorder.close()
    run = Recording.open(recorder.path)
    lines = explain(run, 0.25).text(everything=True).splitlines()
    assert [line.strip() for line in lines if "kind=" in line] == [
        "R2: kind=robot, near -> box",
        "box: kind=object, width=0.5",
    ]
    assert graph_at(explain(run, 0.35)).related("R2", "near") == []
    assert graph_at(explain(run, 0.4)).nodes() == ["R2"]


def test_a_wrong_time_or_agent_is_told(recording):
    with pytest.raises(InputError, match=r"the time 21 s is outside the run\. The run is from 0 s to 20 s"):
        explain(recording, 21.0)
    with pytest.raises(InputError, match=r"no agent is named 'R3'.*R2"):
        explain(recording, 1.0, agent="R3")
