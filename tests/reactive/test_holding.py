"""Rules that can hold the robot for ever, since their action cannot change what holds them."""

import re

import pytest

from rocs_bt.actions import ACTIONS
from rocs_bt.base.signal import Signal
from rocs_bt.base.units import ANGLE, LENGTH, SPEED, TIME, TURN_RATE
from rocs_bt.expression import Environment
from rocs_bt.reactive.analysis import examine_rules

SIGNALS = Environment.packed(
    [
        Signal("front", 4, (LENGTH,), bounds=(0.0, float("inf"))),
        Signal("speed", 1, (SPEED,), bounds=(-1.0, 1.5)),
        Signal("turn_rate", 1, (TURN_RATE,), bounds=(-2.0, 2.0)),
        Signal("stop_distance", 1, (LENGTH,), bounds=(0.0, 2.0)),
        Signal("tilt", 1, (ANGLE,), bounds=(0.0, 3.15)),
        Signal("contact_time", 1, (TIME,), bounds=(0.0, float("inf"))),
        Signal("bumper", 1, bounds=(0.0, 1.0)),
        Signal("wheel_speeds", 2, (SPEED,), bounds=(-1.5, 1.5)),
    ]
)
STOP = 'name = "Stop"'
NEAR = 'when = "min(front) < 0.4 m"'


def rule(*lines, action=STOP):
    return "\n".join(['format = "reflex/1"', "[rule.Halt]", "priority = 5", *lines, "[rule.Halt.action]", action, ""])


def findings(tmp_path, text):
    file = tmp_path / "rules.toml"
    file.write_text(text, encoding="utf-8")
    return [
        fault for fault in examine_rules(file, SIGNALS, ACTIONS).faults if "hold the robot for ever" in fault.message
    ]


HOLDS = {
    "a range": rule(NEAR),
    "hysteresis": rule(NEAR, 'until = "min(front) > 0.5 m"'),
    "a level rule": rule(NEAR, 'until = "min(front) > 0.5 m"', 'trigger = "level"'),
    "a bumper": rule('when = "bumper > 0.5"'),
    "a window": rule(NEAR, 'until = "held(min(front) > 0.5 m, 1 s)"'),
    "a speed that does not matter at rest": rule('when = "min(front) < 0.4 m and speed >= 0 m/s"'),
    "an until that rest prevents": rule(NEAR, 'until = "min(front) > 0.5 m and speed > 0.1 m/s"'),
    "speeds of wheels": rule(NEAR, 'until = "max(wheel_speeds) > 0.1 m/s or min(front) > 0.5 m"'),
    "also what is invalid trips it": rule(NEAR, 'on_invalid = "trip"'),
    "wheels at 0": rule(NEAR, action='name = "SetWheelSpeed"\nspeeds = ["0 m/s", "0 m/s"]'),
    "a message": rule(NEAR, action='name = "SendMessage"\ntext = "help"'),
}

RELEASES = {
    "something that it says it waits for": rule(NEAR, 'waits_for = "a person"'),
    "the speed": rule('when = "min(front) < 0.4 m and speed > 0.1 m/s"'),
    "until it is at rest": rule(NEAR, 'until = "abs(speed) < 0.02 m/s and abs(turn_rate) < 0.02 rad/s"'),
    "wheels at rest": rule(NEAR, 'until = "max(wheel_speeds) < 0.1 m/s"'),
    "the distance to stop": rule('when = "min(front) < stop_distance + 0.1 m"'),
    "the tilt": rule('when = "tilt > 20 deg"', 'until = "tilt < 12 deg"'),
    "the time to a contact": rule('when = "contact_time < 0.5 s"'),
    "a time": rule(NEAR, 'until = "time_since(min(front) > 0.5 m) > 2 s"'),
    "a rate": rule(NEAR, 'until = "rate(front[0], 0.2 s) > -0.1 m/s"'),
    "only what is invalid": rule('when = "min(front) < 0 m"', 'on_invalid = "trip"'),
    "an until that never holds is told by itself": rule(NEAR, 'until = "speed > 2 m/s"'),
    "an action that moves": rule(NEAR, action='name = "TurnAngle"\nangle = "60 deg"'),
    "wheels that turn": rule(NEAR, action='name = "SetWheelSpeed"\nspeeds = ["0 m/s", "0.1 m/s"]'),
    "wheels that follow what is sensed": rule(
        NEAR,
        action='name = "SetWheelSpeed"\nspeeds = ["-speed", "0 m/s"]\non_invalid = { speeds = ["0 m/s", "0 m/s"] }',
    ),
}


@pytest.mark.parametrize("text", HOLDS.values(), ids=HOLDS)
def test_an_action_that_cannot_change_what_holds_its_rule_is_a_warning(text, tmp_path):
    (fault,) = findings(tmp_path, text)
    assert fault.warning
    assert not fault.note
    assert text.splitlines()[fault.line - 1] == "[rule.Halt.action]"
    words = r"Halt can hold the robot for ever: \w+ does not move it, .* with (each )?(front|bumper)"
    assert re.search(words, str(fault))


@pytest.mark.parametrize("text", RELEASES.values(), ids=RELEASES)
def test_what_rest_or_the_action_can_change_is_no_finding(text, tmp_path):
    assert findings(tmp_path, text) == []


class Broken(ACTIONS["Stop"]):
    """Stops, and cannot be asked whether it does."""

    @classmethod
    def can_move(cls, parameters):
        raise KeyError("missing")


def test_an_action_whose_can_move_raises_is_reported_at_its_rule(tmp_path):
    file = tmp_path / "rules.toml"
    file.write_text(rule(NEAR), encoding="utf-8")
    (fault,) = examine_rules(file, SIGNALS, {**ACTIONS, "Stop": Broken}).faults
    assert (fault.line, fault.message) == (5, "can_move of Stop raised KeyError: 'missing'.")
