"""Comparisons of guards, from tracks: against the samples of the run, evaluated one by one by the interpreter."""

import math

import numpy as np
import pytest

from rocs_bt import run
from rocs_bt.expression import Environment, evaluate, parse
from rocs_bt.expression.source import source
from rocs_bt.record import GuardInfo, Recording, RunHeader, environment_of, samples
from rocs_bt.record.comparisons import Comparisons, Guard
from rocs_bt.record.tracks import Tracks
from rocs_bt.record.why_not import holding
from rocs_bt.signal import Signal
from rocs_bt.units import LENGTH


@pytest.fixture(scope="module", params=["exp1", "exp3"])
def recorded(request, tmp_path_factory):
    out = tmp_path_factory.mktemp("run")
    run(request.param, seed=1, duration=6.0, out=out, report=False)
    return Recording.open(out)


@pytest.fixture(scope="module")
def tracks(recorded):
    tracks = Tracks(recorded.header)
    tracks.take(recorded.events())
    return tracks


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
        if key.topic in ("near", "compare"):
            other = parts.get(*key)
            assert track.t == other.t
            assert np.array_equal(track.rows(), other.rows(), equal_nan=True)


def test_sources_are_read_as_the_guards_that_they_were(recorded):
    for agent in recorded.header.agents:
        environment = environment_of(agent)
        for guard in agent.guards:
            for text in guard.sources:
                assert source(parse(text, environment), environment) == text


GUARDS = [
    "0.1 m < x < 0.5 m",
    "0.5 m > x >= 0.1 m",
    "0.1 m < x < y < 1.5 m",
    "not (0.1 m < x < 0.5 m)",
    "x < 0.5 m and not (y < 1 m)",
    "x < 0.5 m or not (y < 1 m or x > 0.2 m)",
    "not (not (x < y) and 0.2 m < y <= 1 m)",
    "not (x == 0.5 m) and y != 1 m",
    "any(g < 0.5 m) and not all(g < 1 m)",
    "all(0.1 m < g < 1.5 m)",
    "any(0.1 m < g < 0.5 m)",
    "not any(g > x)",
]


@pytest.mark.parametrize("text", GUARDS)
def test_chains_and_not_are_near_1_where_the_guard_is_true_and_only_there(text):
    signals = [Signal("x", 1, (LENGTH,)), Signal("y", 1, (LENGTH,)), Signal("g", 3, (LENGTH,))]
    tree = parse(text, Environment.packed(signals))
    listed = [pair.text for node in tree.walk() if node.op == "compare" for pair in node.pairs]
    guard = Guard(GuardInfo(rule="r/R", when=text, sources=(text,), comparisons=tuple(listed)), [tree])
    x = np.random.default_rng(5).choice([0.05, 0.1, 0.3, 0.5, 0.8, 1.0, 2.0, math.nan], (400, 5))
    x[:200] = np.random.default_rng(6).uniform(0.0, 2.0, (200, 5))
    t = np.arange(400.0).tolist()
    tracks = Tracks(RunHeader(scenario="s", seed=0))
    guard.add(tracks, "a", t, x)
    truth = [evaluate(tree, row) for row in x.tolist()]
    near = tracks.get("a", "near", "r/R").rows()[:, 0]
    assert np.array_equal(near >= 1.0, [true is True for true in truth])
    assert {True, False} <= set(truth)
    if text == "any(0.1 m < g < 0.5 m)":  # each comparison may hold for another value
        return
    rows = np.array(guard.rows(t, x))
    for i in np.flatnonzero(np.isfinite(x).all(axis=1)):
        held = holding(guard.texts["tree"], rows[:, i].tolist(), want=True)
        assert bool(held) == (truth[i] is False), x[i]


def test_a_chain_has_a_comparison_for_each_sign():
    signals = [Signal("x", 1, (LENGTH,))]
    tree = parse("0.1 m < x < 0.5 m", Environment.packed(signals))
    assert [pair.text for pair in tree.pairs] == ["0.1 m < x", "x < 0.5 m"]
    guard = Guard(GuardInfo(rule="r/R", when=tree.text, comparisons=tuple(p.text for p in tree.pairs)), [tree])
    assert guard.texts["tree"] == ["and", 0, 1]
    assert [row[0, 2] for row in guard.rows([0.0], np.array([[2.0]]))] == [1.0, 0.0]


@pytest.mark.parametrize(
    ("text", "near"), [("0.1 m < x < 0.5 m", 0.25), ("not (x > 1 m)", 0.5), ("x > 1 m and not (0.1 m < x < 8 m)", 0.25)]
)
def test_what_has_to_change_tells_how_near_a_guard_is(text, near):
    tree = parse(text, Environment.packed([Signal("x", 1, (LENGTH,))]))
    listed = [pair.text for node in tree.walk() if node.op == "compare" for pair in node.pairs]
    guard = Guard(GuardInfo(rule="r/R", when=text, comparisons=tuple(listed)), [tree])
    tracks = Tracks(RunHeader(scenario="s", seed=0))
    guard.add(tracks, "a", [0.0], np.array([[2.0]]))
    assert tracks.get("a", "near", "r/R").rows()[0, 0] == pytest.approx(near)
