"""SendMessage travels the network of sharing, arrives as a sensor's reading, and is acknowledged or fails."""

from __future__ import annotations

import json

import pytest

from rocs_bt import run
from rocs_bt.catalog import Catalog
from rocs_bt.event import Change, ListSink, SensorRead, TicketChanged
from rocs_bt.interfaces.action import Reason
from rocs_bt.record import Recording
from rocs_bt.running import replay

SCENARIO = """
format = "scenario/2"
doc = "Two robots talk."
world = "arena"
duration = "6 s"
{share}
[[agent]]
name = "R2"
robot = "{sender}"
mission = "talk"
x = "-1 m"
y = "0 m"
[[agent]]
name = "R3"
robot = "{receiver}"
mission = "listen"
x = "1 m"
y = "0 m"
"""
TALK = """
def build(mission):
    \"\"\"Says something.\"\"\"
    return mission.act("SendMessage", {arguments})
"""
LISTEN = """
def build(mission):
    \"\"\"Stands about.\"\"\"
    return mission.act("SetWheelSpeed", speeds=[0.0, 0.0, 0.0, 0.0], duration=3.0)
"""


@pytest.fixture
def play(tmp_path):
    """Runs the scenario; all its events."""

    def play(arguments, share="[share]", receiver="summit_xl_shortsighted", out=None):
        missions = tmp_path / "planners" / "missions"
        missions.mkdir(parents=True, exist_ok=True)
        (tmp_path / "scenarios").mkdir(exist_ok=True)
        (missions / "talk.py").write_text(TALK.format(arguments=arguments), "utf-8")
        (missions / "listen.py").write_text(LISTEN, "utf-8")
        text = SCENARIO.format(share=share, sender="pioneer_p3dx", receiver=receiver)
        (tmp_path / "scenarios" / "talk.toml").write_text(text, "utf-8")
        catalog, sink = Catalog(tmp_path), ListSink()
        result = run("talk", catalog, sinks=[sink], out=out, report=False)
        return result, sink.events, catalog

    return play


def ends(events):
    return [e for e in events if isinstance(e, TicketChanged) and e.action == "SendMessage" and e.state != "QUEUED"]


def test_a_message_arrives_as_a_reading_becomes_a_node_and_is_told_to_the_plan(play, tmp_path):
    _, events, catalog = play('text="the door is open", to="R3"', out=tmp_path / "run")
    assert [e.state for e in ends(events)] == ["RUNNING", "SUCCEEDED"]
    assert ends(events)[1].t <= 0.3
    readings = [e for e in events if isinstance(e, SensorRead) and e.sensor == "mailbox" and e.data]
    assert len(readings) == 1
    (change,) = [e for e in events if isinstance(e, Change) and e.kind == "message"]
    assert (change.agent, change.subject, change.values["text"]) == ("R3", "R2", "the door is open")
    assert change.t == readings[0].t
    assert replay(Recording.open(tmp_path / "run" / "run.mcap"), catalog) is None
    assert json.loads((tmp_path / "run" / "summary.json").read_text())["agents"]["R2"]["outcome"] == "success"


def test_the_network_may_lose_and_delay_it_all_the_same(play):
    share = '[share]\nlatency = "50 ms"\njitter = "200 ms"\nloss = 0.5'
    _, events, _ = play('text="hello", patience=5.0', share)
    assert ends(events)[-1].state == "SUCCEEDED"
    assert len([e for e in events if isinstance(e, Change) and e.kind == "message"]) == 1


@pytest.mark.parametrize(
    ("arguments", "share", "receiver", "reason", "why"),
    [
        (
            'text="x", to="R9", patience=0.5',
            "[share]",
            "summit_xl",
            Reason.UNHEARD,
            "R9 did not acknowledge (no answer)",
        ),
        ('text="x", to="R3", patience=0.5', "[share]", "summit_xl", Reason.UNHEARD, "('R3' has no mailbox)"),
        ('text="x"', '[share]\nagents = ["R2"]', "summit_xl", Reason.UNHEARD, "no other robot was present in 2.0 s"),
        ('text="x"', "", "summit_xl", Reason.CANNOT, "the robot cannot send messages"),
        ('text="x" * 2000', "[share]", "summit_xl", Reason.CANNOT, "at most 1024 bytes, found 2000"),
    ],
)
def test_what_cannot_be_said_fails_with_a_reason(play, arguments, share, receiver, reason, why):
    result, events, _ = play(arguments, share, receiver)
    assert ends(events)[-1].state == "FAILED"
    assert ends(events)[-1].reason.startswith(reason.name)
    assert why in ends(events)[-1].reason
    assert result.outcomes["R2"] != "success"
