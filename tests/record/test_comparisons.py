"""Comparisons of guards, from tracks: against the samples of the run, evaluated one by one by the interpreter."""

import math

import numpy as np
import pytest

from rocs_bt import run
from rocs_bt.expression import evaluate, parse
from rocs_bt.expression.source import source
from rocs_bt.record import Recording, environment_of, samples
from rocs_bt.record.comparisons import Comparisons
from rocs_bt.record.tracks import Tracks


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
