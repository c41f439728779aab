"""The life of a rule: random rule sets on random traces beside the numpy back end, and each law by example."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.signal import Signal
from rocs_bt.base.toml_table import read_toml
from rocs_bt.base.units import LENGTH, SPEED, MetresPerSecond
from rocs_bt.expression import Environment
from rocs_bt.interfaces.action import AtomicAction, Progress
from rocs_bt.reactive import OnInvalid, RuleModel, choose_backend, load_rules, lower_rules

from .. import needs

ENVIRONMENT = Environment.packed(
    [Signal("front", 3, (LENGTH,)), Signal("rear", 1, (LENGTH,)), Signal("speed", 1, (SPEED,))]
)


class Move(AtomicAction):
    """Moves."""

    speed: MetresPerSecond = 0.5

    def act(self, body):
        return Progress.SUCCEEDED


ACTIONS = {"Move": Move}


def load(text):
    return load_rules(read_toml(Path("rules.toml"), 'format = "reflex/1"\n' + text), ENVIRONMENT, ACTIONS)


def one(**keys):
    """A model of one rule `rules/R` on `speed > 1 m/s`."""
    lines = {"when": "speed > 1 m/s", "priority": 1} | keys
    body = "".join(f"{k.rstrip('_')} = {v if isinstance(v, int) else repr(v)}\n" for k, v in lines.items())
    return RuleModel(load(f"[rule.R]\n{body}[rule.R.action]\nname = 'Move'\n"))


def trace(model, rows):
    """Whether the rule is latched after each (t, speed)."""
    found = []
    for t, speed in rows:
        model.react(np.array([1.0, 1.0, 1.0, 1.0, speed]), t)
        found.append(bool(model.latched))
    return found


guards = st.sampled_from(
    [
        "min(front) < 0.5 m",
        "min(front) < 0.5 m and speed > 0.1 m/s",
        "rear < 0.5 m or min_valid(front, 2) < 0.4 m",
        "any(front < 0.3 m)",
        "rear / speed < 1 s",
        "speed > 0 m/s and rear / speed < 2 s",
        "min(front) < rear",
    ]
)
times = st.sampled_from(["0 s", "0.05 s", "0.1 s", "0.3 s"])


@st.composite
def rule_sets(draw):
    text = ""
    for i in range(draw(st.integers(1, 4))):
        policy = draw(st.sampled_from([p.value for p in OnInvalid]))
        until = draw(st.one_of(st.none(), guards.map(lambda g: f"not ({g})"), st.just("min(front) > 0.7 m")))
        text += f"[rule.R{i}]\nwhen = '{draw(guards)}'\n" + (f"until = '{until}'\n" if until else "")
        text += f"for = '{draw(times)}'\ncooldown = '{draw(times)}'\npriority = {i}\non_invalid = '{policy}'\n"
        text += (
            f"trigger = '{draw(st.sampled_from(['edge', 'level']))}'\nkeep = {draw(st.sampled_from([[], ['speed']]))}\n"
        )
        text += f"max_hold = '{draw(times)}'\n" if policy == "hold" else ""
        text += f"[rule.R{i}.action]\nname = 'Move'\nspeed = '{i} m/s + speed'\n"
        text += draw(st.sampled_from(["", f"[rule.R{i}.action.on_invalid]\nspeed = '7 m/s'\n"]))
    return load(text)


ranges = st.sampled_from([0.1, 0.35, 0.45, 0.6, 0.8, math.inf, math.nan])
rows = st.tuples(
    st.lists(ranges, min_size=4, max_size=4),
    st.sampled_from([0.0, 0.05, 0.5, 1.0, math.nan]),
    st.sampled_from([0.05, 0.05, 0.05, 0.013, 0.2, 0.0, -0.3]),
)


@settings(max_examples=120, deadline=None)
@given(rule_sets(), st.lists(rows, max_size=40))
def test_it_lives_as_the_plain_reference_does(rules, steps):
    model, t, kept = RuleModel(rules), 10.0, {}
    reference = choose_backend("numpy").machine(lower_rules(rules.rules))
    for distances, speed, dt in steps:
        x = np.array([*distances, speed])
        t += dt
        before = [bool(on) for on in reference.mask]
        reference.step(x, t)
        told = {reflex.rule: reflex for reflex in model.react(x, t)}
        assert set(model.latched) == {r.name for r, on in zip(rules.rules, reference.mask, strict=True) if on}
        for rule, was, latched, blind in zip(rules.rules, before, reference.mask, reference.blind, strict=True):
            reflex = told.pop(rule.name, None)
            if reflex is None:
                assert not latched
                assert not was or dt < 0.0
                continue
            assert reflex.latched == latched
            assert reflex.priority == rule.priority
            argument = rule.arguments["speed"]
            fallback = argument.blind and (blind or speed != speed)
            wanted = 7.0 if fallback else rule.priority + speed if speed == speed else 0.5
            if not latched or not was or dt < 0.0:
                kept.pop(rule.name, None)
            if latched and rule.keep and not blind:
                wanted = kept.setdefault(rule.name, wanted)
            if latched:
                assert reflex.parameters["speed"] == wanted
        assert not told


def test_what_a_rule_keeps_goes_with_other_rules_of_its_name_and_action():
    guard = "[rule.R]\nwhen = 'speed > 1 m/s'\npriority = 1\nkeep = ['speed']\n"
    text = guard + "[rule.R.action]\nname = 'Move'\nspeed = '{}'\n"
    model = RuleModel(load(text.format("speed")))
    x = np.array([1.0, 1.0, 1.0, 1.0, 2.0])
    for t, speed, expected in ((0.0, 2.0, 2.0), (0.1, 3.0, 2.0)):
        x[4] = speed
        assert model.react(x, t)[0].parameters["speed"] == expected
    model.replace(load(text.format("2 * speed")))
    assert model.react(x, 0.2)[0].parameters["speed"] == 2.0
    model.replace(load(text.format("2 * speed").replace("keep = ['speed']\n", "")))
    assert model.react(x, 0.3)[0].parameters["speed"] == 6.0
    model.replace(load(text.format("speed")))
    assert model.react(x, 0.4)[0].parameters["speed"] == 3.0
    model.reset()
    x[4] = 5.0
    assert model.react(x, 0.5)[0].parameters["speed"] == 5.0


def test_hysteresis_is_the_rules():
    model = one(until="speed < 0.5 m/s")
    assert trace(model, [(0, 0.9), (1, 1.1), (2, 0.6), (3, 0.4), (4, 0.9)]) == [False, True, True, False, False]


def test_for_is_counted_on_the_snapshots_time():
    model = one(for_="0.1 s")
    assert trace(model, [(0, 2), (0.05, 2), (0.1, 2)]) == [False, False, True]
    assert trace(one(for_="0.1 s"), [(0, 2), (0.09, 0), (0.1, 2), (0.2, 2)]) == [False, False, False, True]


def test_time_going_backwards_begins_anew():
    model = one(until="speed < 0 m/s", cooldown="5 s")
    assert trace(model, [(3, 2), (4, 0.5), (1, 0.5), (2, 2)]) == [True, True, False, True]


def test_cooldown_of_an_edge_rule_begins_when_it_fires():
    rows = [(0, 2), (0.1, 0), (0.2, 2), (0.5, 2)]
    assert trace(one(cooldown="0.5 s"), rows) == [True, False, False, True]


def test_cooldown_of_a_level_rule_begins_when_it_releases():
    rows = [(0, 2), (0.4, 0), (0.5, 2), (0.89, 2), (0.9, 2)]
    assert trace(one(cooldown="0.5 s", trigger="level"), rows) == [True, False, False, False, True]


@pytest.mark.parametrize(
    ("policy", "expected"), [("trip", [True] * 4), ("clear", [False] * 4), ("hold", [False, False, True, True])]
)
def test_invalid_before_the_latch(policy, expected):
    keys = {"max_hold": "0.2 s"} if policy == "hold" else {}
    model = one(on_invalid=policy, **keys)
    assert trace(model, [(0, math.nan), (0.1, math.nan), (0.2, math.nan), (0.3, math.nan)]) == expected


@pytest.mark.parametrize(("policy", "expected"), [("trip", True), ("clear", False), ("hold", True)])
def test_invalid_behind_the_latch(policy, expected):
    keys = {"max_hold": "0.2 s"} if policy == "hold" else {}
    assert trace(one(on_invalid=policy, **keys), [(0, 2), (0.1, math.nan), (9, math.nan)]) == [True, expected, expected]


def test_each_blind_while_is_held_for_its_own():
    rows = [(0, math.nan), (0.1, 0), (0.3, math.nan), (0.4, math.nan), (0.5, math.nan)]
    assert trace(one(on_invalid="hold", max_hold="0.2 s"), rows) == [False, False, False, False, True]


def test_fallbacks_stand_in_while_the_guard_is_invalid():
    rules = load(
        "[rule.R]\nwhen = 'rear < 1 m'\npriority = 1\non_invalid = 'trip'\n[rule.R.action]\nname = 'Move'\n"
        "speed = 'speed * 2'\n[rule.R.action.on_invalid]\nspeed = '0 m/s'\n"
    )
    model = RuleModel(rules)
    for rear, speed, expected in [(0.5, 0.2, 0.4), (math.nan, 0.2, 0.0), (0.5, math.nan, 0.0)]:
        (reflex,) = model.react(np.array([1.0, 1.0, 1.0, rear, speed]), 0.0)
        assert reflex.parameters == {"speed": expected}


def test_the_reading_tells_what_latched_and_what_released():
    model = one(until="speed < 0.5 m/s")
    (latched,) = model.react(np.array([1, 1, 1, 1, 1.234]), 0.0)
    (released,) = model.react(np.array([1, 1, 1, 1, 0.25]), 1.0)
    assert (latched.describe(), released.describe()) == ("speed = 1.23 m/s", "speed = 0.25 m/s")
    assert (latched.latched, released.latched) == (True, False)


@pytest.mark.parametrize("backend", ["numpy", pytest.param("kernel", marks=needs.kernel)])
def test_parameters_and_readings_know_the_temporal_operations_of_their_rule(backend):
    rules = load(
        "[rule.R]\nwhen = 'rate(rear, 0.1 s) < -1 m/s or once(speed > 2 m/s, 1 s)'\npriority = 1\n"
        "[rule.R.action]\nname = 'Move'\n"
        "speed = '-rate(rear, 0.1 s) if not held(speed > 2 m/s, 0.05 s) else time_since(rear < 0 m) * 1 m/s2'\n"
    )
    model, told = RuleModel(rules, choose_backend(backend)), []
    for k, (rear, speed) in enumerate([(3.0, 0.0), (2.9, 0.0), (2.6, 0.0), (2.6, 3.0), (2.6, 3.0)]):
        for reflex in model.react(np.array([1.0, 1.0, 1.0, rear, speed]), 0.05 * k):
            told.append((k, reflex.describe(), reflex.parameters["speed"]))
    assert [(k, speed) for k, _, speed in told] == [(2, pytest.approx(4.0)), (3, pytest.approx(3.0)), (4, np.inf)]
    assert [reading for _, reading, _ in told] == [
        "rate(rear, 0.1 s) = -4 m/s",
        "rate(rear, 0.1 s) = -3 m/s, once(speed > 2 m/s, 1 s) = true",
        "once(speed > 2 m/s, 1 s) = true",
    ]
