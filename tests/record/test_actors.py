"""Movements of scripted actors, and doors: lines of the log, and states with their times."""

import math

import numpy as np
import pytest

from rocs_bt.event import BodyMoved
from rocs_bt.record.file.header import BodyInfo, RunHeader
from rocs_bt.record.fold.tracks import Tracks

PERIOD = 0.05
DOOR = ((-0.5, -0.03), (0.5, -0.03), (0.5, 0.03), (-0.5, 0.03))
PERSON = tuple((0.3 * math.cos(a), 0.3 * math.sin(a)) for a in np.linspace(0.0, 6.0, 9))


STATES = {"shut": (0.0, 0.0, 0.0), "open": (1.2, 0.0, 0.0)}


def header(hull=DOOR, script="slide", states=STATES):
    return RunHeader(scenario="doors", seed=1, bodies=(BodyInfo(name="gate", hull=hull, script=script, states=states),))


def tracks_of(poses, hull=DOOR, **of):
    tracks = Tracks(header(hull, **of))
    for i, (x, y, yaw) in enumerate(poses):
        tracks.emit(BodyMoved(t=i * PERIOD, body="gate", x=x, y=y, yaw=yaw))
    return tracks


@pytest.mark.parametrize("seed", range(12))
def test_every_movement_has_a_line_at_its_begin_and_at_its_end(seed):
    """Random movements with rests between them: slides, turns, and both, of random speeds."""
    rng = np.random.default_rng(seed)
    pose, poses, truth = np.zeros(3), [np.zeros(3)], []
    for _ in range(int(rng.integers(1, 6))):
        for _ in range(int(rng.integers(25, 60))):
            poses.append(pose.copy())
        step = rng.uniform(0.3, 2.0) * PERIOD * np.array([*rng.normal(size=2), 0.0])
        step[2] = rng.choice([0.0, 0.8, -1.5]) * PERIOD
        if rng.random() < 0.3:
            step[:2] = 0.0
        if np.hypot(*step[:2]) < 0.01 and not step[2]:
            step[0] = 0.02
        began = (len(poses) - 1) * PERIOD
        for _ in range(int(rng.integers(5, 40))):
            pose = pose + step
            poses.append(pose.copy())
        truth += [("moves", began), ("rests", (len(poses) - 1) * PERIOD)]
    poses += [pose] * 30
    tracks = tracks_of(poses)
    track = tracks.get("gate", "actor")
    assert track is not None
    found = list(zip(track.v, track.t, strict=True))[1:]  # after the state at the start
    assert [state == "moves" for state, _ in found] == [state == "moves" for state, _ in truth]
    assert np.allclose([t for _, t in found], [t for _, t in truth], atol=PERIOD + 1e-9)
    lines = [line for line in tracks.log if line.about == ("gate", "actor", "")]
    assert len(lines) == len(truth)
    assert all(0.0 <= line.t - t < 0.65 for line, (_, t) in zip(lines, truth, strict=True))
    assert [line.t for line in tracks.log] == sorted(line.t for line in tracks.log)


def test_what_trembles_or_does_not_move_has_no_line_and_what_appears_has_one():
    rng = np.random.default_rng(1)
    assert tracks_of(rng.normal(scale=1e-4, size=(200, 3))).log == []
    late = Tracks(header(PERSON))
    late.emit(BodyMoved(t=3.0, body="gate", x=0.0, y=0.0, yaw=0.0))
    assert [line.text for line in late.log] == ["gate appears (scripted)"]


def test_a_door_says_that_it_is_shut_and_since_when_and_what_has_no_states_that_it_is_at_rest():
    poses = [(1.2 - 0.04 * max(0, min(i - 40, 30)), 0.0, 0.0) for i in range(120)]
    lines = [line.text for line in tracks_of(poses).log]
    assert lines == ["gate begins to move (scripted)", "gate is shut since 3.50 s"]
    assert [line.text for line in tracks_of(poses, PERSON, states={}).log][-1] == "gate is at rest since 3.50 s"
    half_way = tracks_of(poses[:60] + [poses[59]] * 30)
    assert [line.text for line in half_way.log][-1] == "gate is at rest since 2.95 s"
    assert half_way.get("gate", "actor").v[0] == "open"
    assert next(line.text for line in tracks_of(poses, script="").log) == "gate begins to move"


def test_a_swing_that_turns_back_goes_on_moving():
    poses = [(0.0, 0.0, math.sin(2.0 * math.pi * i * PERIOD / 10.0)) for i in range(600)]
    assert [line.text for line in tracks_of(poses).log] == ["gate begins to move (scripted)"]
