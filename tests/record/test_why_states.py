"""The answer of `--why` in states that shipped scenarios do not reach: waits, failures, holds, pushes, falls."""

import math

import pytest

from rocs_bt.event import (
    ActuatorCommanded,
    AgentStopped,
    BlockFailed,
    BodyMoved,
    MotionHeld,
    MotionReleased,
    NodeTicked,
    RobotPushed,
    RuleChanged,
    SignalsWritten,
    TicketChanged,
    pack,
)
from rocs_bt.record.explanation.why import explain
from rocs_bt.record.file.header import AgentInfo, RunHeader, TreeNode
from rocs_bt.record.file.recorder import Recorder
from rocs_bt.record.file.recording import Recording

NODES = (
    TreeNode(path="m", type="Sequence", children=("m/ready", "m/in time", "m/go")),
    TreeNode(path="m/ready", type="When"),
    TreeNode(path="m/in time", type="Timeout", children=("m/in time/retry",)),
    TreeNode(path="m/in time/retry", type="Retry", children=("m/in time/retry/full",)),
    TreeNode(path="m/in time/retry/full", type="When"),
    TreeNode(path="m/go", type="GoTo"),
)
READY = [("m/ready", "SUCCESS", ""), ("m", "RUNNING", "")]
WAITS = [
    ("m/in time/retry/full", "FAILURE", "battery > 0.9, battery = 0.41"),
    ("m/in time/retry", "RUNNING", ""),
    ("m/in time", "RUNNING", "until 60.00 s"),
]


@pytest.fixture
def answer(tmp_path):
    """Answer at a time of a run of one second per list of events; the first event of a list is at its second."""

    def at(t: float, *seconds: list) -> str:
        recorder = Recorder(tmp_path / "run.mcap", RunHeader(scenario="x", seed=1, agents=(AGENT,)))
        for second, events in enumerate(seconds):
            for kind, fields in events:
                agent = {} if kind in (BodyMoved,) else {"agent": "R"}
                recorder.emit(kind(t=float(second), **{**agent, **fields}))
        recorder.close()
        return explain(Recording.open(recorder.path), t).answer

    return at


AGENT = AgentInfo(name="R", robot="r", mission="m", nodes=NODES)


def ticks(*rows):
    return [(NodeTicked, {"node": node, "status": status, "feedback": text}) for node, status, text in rows]


def ticket(number, state, action="GoTo", priority="NORMAL", by="m/go"):
    return TicketChanged, {"ticket": number, "action": action, "priority": priority, "state": state, "by": by}


def speed(value, turn=0.0):
    data = {"monitor": "w", "signals": ("speed", "turn_rate"), "sizes": (1, 1), "data": pack([value, turn])}
    return SignalsWritten, data


def drive(*values, route="deliberative"):
    return ActuatorCommanded, {"actuator": "wheels", "route": route, "data": pack(values)}


def rule(name, phase, reading=""):
    return RuleChanged, {"rule": f"f/{name}", "phase": phase, "priority": 1, "reading": reading}


def test_a_wait_names_the_leaf_its_values_and_its_deadline(answer):
    text = answer(2.0, [*ticks(*READY, *WAITS), speed(0.0)], [speed(0.0)], [speed(0.0)])
    assert text == (
        "R was stationary because its mission waits in 'm/in time/retry/full' for 2.00 s: "
        "battery > 0.9, battery = 0.41; until 60.00 s."
    )


def test_the_values_of_a_wait_are_the_newest_and_its_time_goes_on(answer):
    newer = [("m/in time/retry/full", "FAILURE", "battery > 0.9, battery = 0.62")]
    text = answer(2.0, [*ticks(*READY, *WAITS)], ticks(*newer), [speed(0.0)])
    assert "for 2.00 s: battery > 0.9, battery = 0.62; until 60.00 s" in text


@pytest.mark.parametrize("status", ["SUCCESS", "FAILURE"])
@pytest.mark.parametrize("stopped", [True, False])
def test_the_end_of_a_mission_is_that_of_its_root(answer, status, stopped):
    done = ticks(("m/go", status, "NO_GOAL: dock"), ("m", status, ""))
    end = [(AgentStopped, {"by": "its outcome"})] if stopped else []
    text = answer(3.0, ticks(*READY), [*done, *end], [], [speed(0.0)])
    about = ": 'm/go' failed (NO_GOAL: dock)" if status == "FAILURE" else ""
    assert text == f"R was stationary because its mission had ended with {status}, 2.00 s ago{about}."


def test_the_attempts_and_deadlines_above_a_leaf_are_told(answer):
    above = [("m/in time/retry/full", "RUNNING", ""), ("m/in time/retry", "RUNNING", "attempt 2/3"), *WAITS[2:]]
    running = [(TicketChanged, {**ticket(1, "RUNNING", by="m/in time/retry/full")[1]})]
    text = answer(1.0, [*ticks(*READY, *above), *running], [speed(0.0)])
    assert text.endswith("of its mission runs GoTo() (attempt 2/3; until 60.00 s).")
    rows = [
        ("m/in time/retry/full", "NO_PATH"),
        ("m/in time/retry", "attempt 3/3 failed"),
        ("m/in time", ""),
        ("m", ""),
    ]
    ended = ticks(*((path, "FAILURE", said) for path, said in rows))
    text = answer(2.0, ticks(*READY), ended, [speed(0.0)])
    assert text.endswith("ago: 'm/in time/retry/full' failed (NO_PATH; attempt 3/3 failed).")


def test_a_motion_is_not_joined_with_the_command_of_another_action(answer):
    go = [ticket(1, "RUNNING"), drive(0.4, 0.4)]
    flinch = [rule("Flinch", "latched", "d = 0.1 m"), rule("Flinch", "fired", "d = 0.1 m"), ticket(1, "CANCELLED")]
    flinch += [ticket(2, "RUNNING", "Flinch", "HIGH", "f/Flinch"), drive(-0.2, -0.2), speed(0.4)]
    text = answer(1.0, [*ticks(*READY), *go, speed(0.0)], flinch)
    assert text == "R moved ahead by the last command of GoTo, 1.00 s ago; now the rule Flinch fired: d = 0.1 m."
    text = answer(1.0, [*ticks(*READY), *go], [ticket(1, "SUCCEEDED"), drive(0.0, 0.0), speed(0.4), *ticks(*WAITS)])
    assert text.startswith("R moved ahead by the last command of GoTo, 1.00 s ago; now its mission waits in 'm/in time")
    text = answer(1.0, [*ticks(*READY), *go], [speed(0.4)])
    assert text == "R moved ahead because 'm/go' runs GoTo()."
    assert "R moved back without a command, while" in answer(1.0, [*ticks(*READY, *WAITS)], [speed(-0.4)])


def test_of_two_actions_that_run_at_once_the_reflex_counts(answer):
    fired = [rule("A", "fired", "d = 0.1 m"), ticket(2, "RUNNING", "Flinch", "HIGH", "f/A"), ticket(1, "RUNNING")]
    assert answer(0.0, fired).endswith("because the rule A fired Flinch: d = 0.1 m.")


def test_a_robot_that_does_not_move_although_it_is_commanded_is_not_explained_by_the_command(answer):
    go = [ticket(1, "RUNNING"), drive(0.4, 0.4), speed(0.0)]
    assert "R was stationary while " in answer(1.0, [*ticks(*READY, ("m/go", "RUNNING", "")), *go], [speed(0.0)])


def test_a_rule_that_waited_and_fires_is_told_with_the_values_that_latched_it(answer):
    first = [rule("A", "latched", "front = 0.3 m"), rule("A", "fired", "front = 0.3 m")]
    first += [ticket(1, "RUNNING", "A", "HIGH", "f/A")]
    second = [rule("B", "latched", "rear = 0.1 m"), rule("B", "fired", "rear = 0.1 m"), rule("A", "ended")]
    second += [rule("A", "waits", "front = 0.35 m"), ticket(1, "CANCELLED", "A", "HIGH", "f/B")]
    second += [ticket(2, "RUNNING", "Flinch", "HIGH", "f/B")]
    third = [rule("B", "ended"), rule("A", "fired", "front = 0.45 m"), ticket(2, "SUCCEEDED", "Flinch", "HIGH", "f/B")]
    third += [ticket(3, "RUNNING", "A", "HIGH", "f/A"), speed(0.0)]
    text = answer(2.0, first, second, third)
    assert "the rule A resumed, after it waited for B: it is latched since t = 0.00 s, when front = 0.3 m" in text
    assert "0.45" not in text
    fourth = [rule("A", "fired again", "front = 0.48 m"), ticket(3, "SUCCEEDED", "A", "HIGH", "f/A")]
    fourth += [ticket(4, "RUNNING", "A", "HIGH", "f/A"), speed(0.0)]
    text = answer(3.0, first, second, third, fourth)
    assert "the rule A fired again" in text
    assert "since t = 0.00 s, when front = 0.3 m" in text
    text = answer(3.0, first, second, third, [rule("A", "released", "front = 0.6 m"), speed(0.0)])
    assert "its guard is clear since t = 3.00 s, and its action goes on" in text
    text = answer(3.0, first, second, third, [rule("A", "latched", "front = 0.2 m"), speed(0.0)])
    assert "resumed" in text  # a later latch is not what fired it


def test_what_holds_pushes_or_tilts_the_robot_is_told(answer):
    start = [*ticks(*READY, *WAITS), speed(0.0)]
    hold = (MotionHeld, {"actuator": "wheels", "reason": "emergency stop"})
    text = answer(1.0, [*start, hold], [speed(0.0)])
    assert (
        "because a safety gate holds 'wheels' in neutral, 1.00 s ago (emergency stop), while its mission waits" in text
    )
    text = answer(1.0, [*start, hold], [speed(0.2)])
    assert "moved ahead although a safety gate holds 'wheels' in neutral" in text
    text = answer(1.0, [*start, hold], [(MotionReleased, {"actuator": "wheels"}), speed(0.0)])
    assert "holds" not in text
    push = (RobotPushed, {"body": "R", "force": (0.0, 40.0, 0.0), "duration": 0.2})
    text = answer(1.0, start, [push, speed(0.0, 0.5)])
    assert text.startswith("R turned left and was pushed by 40 N for 0.2 s (scripted), while its mission waits")
    assert "pushed" not in answer(3.0, start, [push], [], [speed(0.0)])
    pose = {"body": "R", "x": 0.0, "y": 0.0, "yaw": 0.0, "pitch": 0.0}
    for degrees, words in ((0, "was stationary"), (45, "was tilted, with"), (90, "had fallen, with a tilt of 90 deg")):
        moved = (BodyMoved, {**pose, "roll": math.radians(degrees)})
        assert f"R {words}" in answer(1.0, start, [moved, speed(0.0)])


def test_a_failed_block_is_told(answer):
    failure = (BlockFailed, {"block": "plan", "kind": "raised", "detail": "KeyError: 3"})
    text = answer(1.0, ticks(*READY), [failure, (AgentStopped, {"by": "x"}), speed(0.0)])
    assert text == "R was stationary because block plan failed: KeyError: 3."
