"""Comparisons of guards, from tracks: against the samples of the run, evaluated one by one by the interpreter."""

import math
import random
from dataclasses import replace

import numpy as np
import pytest

from rocs_bt import run
from rocs_bt.base.signal import Signal
from rocs_bt.base.units import LENGTH
from rocs_bt.expression import Environment, evaluate, parse
from rocs_bt.expression.source import source
from rocs_bt.reactive import RuleModel
from rocs_bt.record import Recording, RunHeader, environment_of, samples
from rocs_bt.record.explanation.comparisons import Comparisons, Guard
from rocs_bt.record.explanation.condition import Condition
from rocs_bt.record.fold.states import RuleState
from rocs_bt.record.fold.tracks import Tracks
from rocs_bt.running.header import guard_info

from ..reactive.random_rules import ENVIRONMENT, SIZE, random_case


@pytest.fixture(scope="module", params=["exp1", "exp3"])
def recorded(request, tmp_path_factory):
    out = tmp_path_factory.mktemp("run")
    run(request.param, seed=1, duration=6.0, out=out, report=False)
    return Recording.open(out)


@pytest.fixture(scope="module")
def tracks(recorded):
    return Tracks.of_recording(recorded)


def test_each_guard_is_near_1_where_it_is_true_and_only_there(recorded, tracks):
    Comparisons(tracks).update(over=True)
    met = 0
    for agent in recorded.header.agents:
        environment = environment_of(agent)
        t, x = samples(tracks, agent)
        for guard in agent.guards:
            near = tracks.get(agent.name, "near", guard.rule)
            tree = parse(guard.sources[0], environment)
            if near is None or tree.temporal:
                continue
            truth = [evaluate(tree, row) for row in x.tolist()]
            told = near.rows()[:, 0]
            for when, true, part in zip(t, truth, told, strict=True):
                assert (part == 1.0) == (true is True), (guard.rule, when)
                assert math.isnan(part) or 0.0 <= part <= 1.0
            met += any(truth)
    assert met or recorded.header.scenario != "exp1"


def test_piece_by_piece_they_are_the_same_as_at_once(recorded):
    whole, parts = Tracks(recorded.header), Tracks(recorded.header)
    whole.take(recorded.events())
    Comparisons(whole).update(over=True)
    comparisons, events = Comparisons(parts), list(recorded.events())
    for i in range(0, len(events), 97):
        parts.take(events[i : i + 97])
        comparisons.update()
    comparisons.update(over=True)
    for key, track in whole.items():
        if key.topic in ("near", "compare", "guard"):
            other = parts.get(*key)
            assert track.t == other.t
            assert (
                track.v == other.v
                if key.topic == "guard"
                else np.array_equal(track.rows(), other.rows(), equal_nan=True)
            )


def test_sources_are_read_as_the_guards_that_they_were(recorded):
    for agent in recorded.header.agents:
        environment = environment_of(agent)
        for guard in agent.guards:
            for text in guard.sources:
                assert source(parse(text, environment), environment) == text


@pytest.mark.parametrize(
    ("text", "near"), [("0.1 m < x < 0.5 m", 0.25), ("not (x > 1 m)", 0.5), ("x > 1 m and not (0.1 m < x < 8 m)", 0.25)]
)
def test_what_has_to_change_tells_how_near_a_guard_is(text, near):
    tree = parse(text, Environment.packed([Signal("x", 1, (LENGTH,))]))
    assert Condition(tree)([0.0], np.array([[2.0]])).near[0] == pytest.approx(near)


def changed(before, mask, t):
    """State of a rule as events give it: latched, released, or as it was."""
    was = before is not None and before.latched
    return RuleState(phase="latched" if mask else "released", latched=mask) if was is not mask else before


@pytest.mark.parametrize("seed", range(12))
def test_holds_cooldowns_and_modes_are_those_of_the_rules_themselves(seed):
    """Against the state of a reactive model that lives through the same samples."""
    draw = random.Random(seed)
    case = random_case(seed, rules=4, steps=1)
    given = [replace(r, modes=draw.choice([(), ("dock",), ("dock", "drive")])) for r in case.rules.rules]
    rules = replace(case.rules, rules=tuple(given))
    model = RuleModel(rules)
    guards = []
    for rule in rules.rules:
        info = guard_info(rules, rule, ENVIRONMENT)
        guards.append(Guard(info, [Condition(parse(text, ENVIRONMENT)) for text in info.sources]))
    tracks, t, mode = Tracks(RunHeader(scenario="s", seed=0)), 1.0, "drive"
    times, x, entered, told = [], [], [], []
    for _ in range(60):
        row = (
            [draw.choice([0.1, 0.3, 0.5, 0.7, 1.0, 2.0, math.nan]) for _ in range(SIZE)]
            if draw.random() < 0.4 or not x
            else x[-1]
        )
        mode = draw.choice(["drive", "dock", "park"]) if draw.random() < 0.1 else mode
        model.enter(mode)
        model.react(np.array(row), t)
        for name, mask in zip((r.name for r in rules.rules), model._machine.mask, strict=True):
            track = tracks.begun("a", "rule", name)
            if (state := changed(track.v[-1] if track.v else None, bool(mask), t)) is not None:
                track.put(t, state)
        values = model._machine.values()
        told.append([values[model.table.part(name)].copy() for name in ("latched", "risen", "ready")])
        for rows, value in ((times, t), (x, row), (entered, mode)):
            rows.append(value)
        t += draw.choice([0.05, 0.05, 0.02, 0.2])
    cut = draw.randrange(61)
    for part in (slice(0, cut), slice(cut, 60)):
        if times[part]:
            for guard in guards:
                guard.add(tracks, "a", times[part], np.array(x[part]), entered[part])
    for i, rule in enumerate(rules.rules):
        track = tracks.get("a", "guard", rule.name)
        for when, mode, (latched, risen, ready) in zip(times, entered, told, strict=True):
            state = track.at(when)
            assert (state.mode is not None) == bool(rule.modes and mode not in rule.modes)
            if not latched[i] and state.mode is None:
                assert state.since == (None if risen[i] == math.inf else risen[i]), (rule.when.text, when)
                left = max(0.0, ready[i] - when)  # of the cooldown [s]
                assert state.since is None or max(0.0, (state.ready or 0.0) - when) == left
