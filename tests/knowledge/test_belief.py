"""Belief: the filter against least squares and against its own covariance, and what begins, moves and ends tracks."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

from rocs_bt.errors import InputError
from rocs_bt.geometry import Pose2
from rocs_bt.knowledge.belief import Belief, BeliefSettings, Sighting, Track
from rocs_bt.knowledge.belief.beams import Beams


def seen(x, y, sigma=0.05, radius=0.1):
    return Sighting(np.array([x, y]), sigma**2 * np.eye(2), radius)


def looks(belief, count, *sightings, t=0.0, in_view=True, period=0.1):
    """So many looks that show the same; gives the last one."""
    for k in range(count):
        last = belief.update(t + k * period, list(sightings), lambda track: in_view)
    return last


def test_what_is_seen_often_is_told_of_and_what_is_seen_once_is_not():
    belief = Belief()
    assert belief.update(0.0, [seen(1.0, 0.0)], lambda track: True).appeared == []
    assert belief.confirmed == {}
    assert belief.update(0.1, [seen(1.0, 0.0)], lambda track: True).appeared == [1]
    assert belief.confirmed[1].mean[:2] == pytest.approx([1.0, 0.0])


def test_what_a_look_should_have_shown_vanishes_and_what_is_hidden_stays():
    for in_view, gone in ((True, True), (False, False)):
        belief = Belief()
        looks(belief, 10, seen(1.0, 0.0))
        last = [looks(belief, 1, t=1.0 + 0.1 * k, in_view=in_view) for k in range(10)]
        assert any(look.vanished == [1] for look in last) is gone
        assert bool(belief.confirmed) is not gone


def test_what_nobody_sees_for_long_is_forgotten():
    belief = Belief(BeliefSettings(half_life=2.0))
    looks(belief, 10, seen(1.0, 0.0))
    assert belief.confirmed[1].existence > 0.9
    assert looks(belief, 1, t=20.0, in_view=False).vanished == [1]


def test_two_that_pass_each_other_keep_their_numbers():
    belief, t = Belief(), 0.0
    for k in range(80):
        t = 0.05 * k
        belief.update(t, [seen(-1.0 + 0.5 * t, 0.3), seen(1.0 - 0.5 * t, -0.3)][:: (-1) ** k], lambda track: True)
    tracks = belief.confirmed
    assert sorted(tracks) == [1, 2]
    assert tracks[1].mean == pytest.approx([-1.0 + 0.5 * t, 0.3, 0.5, 0.0], abs=0.1)
    assert tracks[2].mean == pytest.approx([1.0 - 0.5 * t, -0.3, -0.5, 0.0], abs=0.1)


def test_the_filter_finds_what_weighted_least_squares_finds():
    rng = np.random.default_rng(3)
    times = 0.1 * np.arange(30)
    sigma = rng.uniform(0.02, 0.3, 30)
    points = np.column_stack([1.0 + 0.4 * times, 2.0 - 0.2 * times]) + sigma[:, None] * rng.normal(size=(30, 2))
    track = Track.start(0.0, seen(*points[0], sigma[0]), 0.5, speed=1e6)
    for t, point, s in list(zip(times, points, sigma, strict=True))[1:]:
        track.predict(t, acceleration=1e-15, half_life=1e9)
        track.update(seen(*point, s), 0.9, 0.1)
    rows = np.column_stack([np.ones(30), times - times[-1]]) / sigma[:, None]
    best = np.linalg.lstsq(rows, points / sigma[:, None], rcond=None)[0]
    assert track.mean == pytest.approx([*best[0], *best[1]], abs=1e-5)
    spread = np.linalg.inv(rows.T @ rows)
    assert track.covariance[[0, 0, 2], [0, 2, 2]] == pytest.approx(spread[[0, 0, 1], [0, 1, 1]], rel=1e-3)


def test_its_covariance_is_as_large_as_its_errors():
    rng, q, sigma, errors = np.random.default_rng(4), 0.05, 0.05, []
    for _ in range(150):
        truth = np.array([0.0, 0.0, *rng.normal(0.0, 0.3, 2)])
        track = Track.start(0.0, seen(*(truth[:2] + sigma * rng.normal(size=2)), sigma), 0.5, speed=0.3)
        for k in range(1, 21):
            kick = rng.multivariate_normal([0.0, 0.0], q * np.array([[0.1**3 / 3, 0.1**2 / 2], [0.1**2 / 2, 0.1]]), 2)
            truth = truth + 0.1 * np.array([*truth[2:], 0.0, 0.0]) + np.concatenate([kick[:, 0], kick[:, 1]])
            track.predict(0.1 * k, q, 1e9)
            track.update(seen(*(truth[:2] + sigma * rng.normal(size=2)), sigma), 0.9, 0.1)
        error = track.mean - truth
        errors.append(error @ np.linalg.solve(track.covariance, error))
    low, high = chi2.ppf([0.0005, 0.9995], 4 * len(errors))
    assert low < sum(errors) < high


places = st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))


@settings(max_examples=80, deadline=None)
@given(st.lists(st.tuples(st.lists(places, max_size=4), st.booleans()), max_size=25))
def test_whatever_is_seen_beliefs_are_probabilities_and_covariances_positive(story):
    belief, known = Belief(), set()
    for k, (points, visible) in enumerate(story):
        look = belief.update(0.1 * k, [seen(*p) for p in points], lambda track, visible=visible: visible)
        known = (known | set(look.appeared)) - set(look.vanished)
        assert known == set(belief.confirmed)
        for track in belief.confirmed.values():
            assert 0.0 < track.existence < 1.0
            assert np.linalg.eigvalsh(track.covariance).min() > 0.0
            assert np.allclose(track.covariance, track.covariance.T)


@pytest.mark.parametrize(
    "wrong", [{"detection": 1.0}, {"initial": 0.7}, {"clutter": 0.9}, {"half_life": 0.0}, {"gate": math.inf}]
)
def test_settings_that_make_no_sense_are_refused(wrong):
    with pytest.raises(InputError):
        BeliefSettings(**wrong)


RING = Beams([(0.2 * math.cos(a), 0.2 * math.sin(a), a) for a in np.radians(22.5 * np.arange(16))], 0.26, 2.0)
SCAN = Beams([(0.0, 0.0, a) for a in np.radians(np.linspace(-135, 135, 541))], 0.005, 8.0, noise=0.01)


def ranges_of(beams, pose, things, cone=9):
    """What beams hear of round things (x, y, radius), each cone sampled by rays; the oracle that the tests trust."""
    told = []
    for x, y, bearing in beams.mounts:
        eye, yaw = pose.transform(x, y), pose.yaw + bearing
        nearest = math.inf
        for a in yaw + np.linspace(-beams.half_angle, beams.half_angle, cone):
            ray = np.array([math.cos(a), math.sin(a)])
            for tx, ty, radius in things:
                to = np.array([tx, ty]) - eye
                along = float(to @ ray)
                gap = radius**2 - float(to @ to) + along**2
                if along > 0.0 and gap >= 0.0:
                    nearest = min(nearest, along - math.sqrt(gap))
        told.append(nearest if nearest <= beams.max_range else math.inf)
    return told


@settings(max_examples=40, deadline=None)
@given(st.floats(0.6, 1.5), st.floats(-3.1, 3.1), st.floats(0.05, 0.2), st.floats(-3.1, 3.1))
def test_a_ring_shows_one_thing_about_where_it_is(away, bearing, radius, yaw):
    pose = Pose2(0.5, -0.3, yaw)
    x, y = pose.transform(away * math.cos(bearing), away * math.sin(bearing))
    (found,) = RING.sightings(pose, ranges_of(RING, pose, [(x, y, radius)]))
    error = found.position - (x, y)
    assert math.hypot(*error) < 0.2 + 0.3 * away * 0.26
    assert error @ np.linalg.solve(found.covariance + radius**2 * np.eye(2), error) < 16.0


@settings(max_examples=40, deadline=None)
@given(st.floats(1.0, 5.0), st.floats(-2.2, 2.2), st.floats(0.1, 0.3))
def test_a_scanner_shows_it_within_centimetres(away, bearing, radius):
    x, y = away * math.cos(bearing), away * math.sin(bearing)
    pose = Pose2(0.0, 0.0, 0.0)
    (found,) = SCAN.sightings(pose, ranges_of(SCAN, pose, [(x, y, radius)], cone=1))
    assert math.hypot(*(found.position - (x, y))) < 0.5 * radius + 0.02
    assert 0.5 * radius < found.radius < 1.2 * radius


def test_a_wall_is_no_thing_and_two_things_are_two():
    pose = Pose2(0.0, 0.0, 0.0)
    wall = [(2.0, 0.05 * k, 0.03) for k in range(-60, 61)]
    assert SCAN.sightings(pose, ranges_of(SCAN, pose, wall, cone=1)) == []
    assert len(SCAN.sightings(pose, ranges_of(SCAN, pose, [(2.0, 0.4, 0.1), (2.0, -0.4, 0.1)], cone=1))) == 2
    assert len(RING.sightings(pose, ranges_of(RING, pose, [(1.0, 0.0, 0.1), (-1.0, 0.0, 0.1)]))) == 2


def test_what_is_hidden_too_far_or_where_nobody_looks_is_not_in_view():
    pose = Pose2(0.0, 0.0, 0.0)
    clear, hidden = ranges_of(SCAN, pose, [], cone=1), ranges_of(SCAN, pose, [(1.0, 0.0, 0.3)], cone=1)
    ahead, behind, far = (Track.start(0.0, seen(x, 0.0), 0.5, 0.3) for x in (3.0, -3.0, 9.0))
    assert SCAN.in_view(pose, clear, ahead)
    assert not SCAN.in_view(pose, hidden, ahead)
    assert not SCAN.in_view(pose, clear, behind)
    assert not SCAN.in_view(pose, clear, far)
    assert not SCAN.in_view(pose, [math.nan] * len(clear), ahead)
