"""Tracking: segments and circle fits against cast rays, the filter against least squares and its own covariance."""

import math

import numpy as np
import pytest
from scipy.stats import chi2

from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2
from rocs_bt.control.tracking import Beams, TrackedObjects, Tracker, TrackerSettings, segments_of

HERE = Pose2(0.0, 0.0)
RING = Beams([(0.2 * math.cos(a), 0.2 * math.sin(a), a) for a in np.radians(22.5 * np.arange(16))], 0.26, 2.0)
SCAN = Beams([(0.1, 0.0, a) for a in np.radians(np.linspace(-135, 135, 721))], math.radians(0.19), 8.0, noise=0.01)


def ranges_of(beams, pose, things, walls=(), noise=None):
    """What beams hear of discs (x, y, radius) and walls (x0, y0, x1, y1), each cone sampled by rays."""
    cone = np.linspace(-1.0, 1.0, 9 if beams.half_angle > 0.05 else 1) * beams.half_angle * (beams.half_angle > 0.05)
    mounts = np.array(beams.mounts)
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    eye = mounts[:, :2] @ np.array([[c, s], [-s, c]]) + pose[:2]
    angle = mounts[:, 2, None] + pose.yaw + cone
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    nearest = np.full(angle.shape, np.inf)
    for x, y, radius in things:
        to = np.array([x, y]) - eye[:, None]
        along = (to * ray).sum(axis=-1)
        inside = radius**2 - (to * to).sum(axis=-1) + along**2
        hit = (along > 0.0) & (inside >= 0.0)
        nearest = np.where(hit, np.minimum(nearest, along - np.sqrt(np.maximum(inside, 0.0))), nearest)
    for x0, y0, x1, y1 in walls:
        d, to = np.array([x1 - x0, y1 - y0]), np.array([x0, y0]) - eye[:, None]
        cross = ray[..., 0] * d[1] - ray[..., 1] * d[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            away = (to[..., 0] * d[1] - to[..., 1] * d[0]) / cross
            part = (to[..., 0] * ray[..., 1] - to[..., 1] * ray[..., 0]) / cross
        hit = (away > 0.0) & (part >= 0.0) & (part <= 1.0)
        nearest = np.where(hit, np.minimum(nearest, away), nearest)
    ranges = nearest.min(axis=1)
    ranges = ranges if noise is None else ranges + noise.normal(0.0, beams.noise, len(ranges))
    return np.where(ranges <= beams.max_range, ranges, np.inf)


def found(beams, pose, things, **more):
    return segments_of(beams.scan(pose, ranges_of(beams, pose, things, **more)), 0.9)


@pytest.mark.parametrize("seed", range(12))
def test_a_scanner_shows_each_disc_where_it_is_within_its_covariance(seed):
    rng = np.random.default_rng(seed)
    pose = Pose2(*rng.uniform(-1.0, 1.0, 2), rng.uniform(-3.0, 3.0))
    away, bearing, radius = rng.uniform(1.0, 6.0), rng.uniform(-2.2, 2.2), rng.uniform(0.1, 0.35)
    x, y = pose.transform(away * math.cos(bearing), away * math.sin(bearing))
    segments = found(SCAN, pose, [(x, y, radius)], noise=rng)
    assert len(segments) == 1
    assert segments.radius == pytest.approx([radius], abs=0.04)
    (centre,), (covariance,), _ = segments.fitted(np.array([radius]))
    error = centre - (x, y)
    assert math.hypot(*error) < 0.04
    assert error @ np.linalg.solve(covariance, error) < 16.0


@pytest.mark.parametrize("seed", range(12))
def test_a_half_hidden_disc_is_where_it_is_once_its_radius_is_known(seed):
    rng = np.random.default_rng(seed)
    away, bearing, side = rng.uniform(2.0, 4.0), rng.uniform(-1.5, 1.5), rng.choice([-1.0, 1.0])
    x, y = 0.1 + away * math.cos(bearing), away * math.sin(bearing)  # from the scanner
    shift = side * (0.12 + rng.uniform(-0.1, 0.1) / away)
    hides = (0.1 + math.cos(bearing + shift), math.sin(bearing + shift), 0.12)
    segments = found(SCAN, HERE, [(x, y, 0.25), hides], noise=rng)
    near = np.hypot(*(segments.centre - (x, y)).T) < 0.4
    assert segments.hidden[near].tolist() == [1]
    centres, _, _ = segments.fitted(np.full(len(segments), 0.25))
    assert np.hypot(*(centres[near][0] - (x, y))) < 0.09


@pytest.mark.parametrize("seed", range(8))
def test_a_ring_shows_one_thing_about_where_it_is(seed):
    rng = np.random.default_rng(seed)
    pose, away, bearing = Pose2(0.5, -0.3, rng.uniform(-3.0, 3.0)), rng.uniform(0.6, 1.5), rng.uniform(-3.0, 3.0)
    x, y = pose.transform(away * math.cos(bearing), away * math.sin(bearing))
    segments = found(RING, pose, [(x, y, 0.1)])
    assert len(segments) == 1
    (centre,), (covariance,), _ = segments.fitted(segments.radius)
    error = centre - (x, y)
    assert math.hypot(*error) < 0.2 + 0.3 * away * 0.26
    assert error @ np.linalg.solve(covariance + 0.1**2 * np.eye(2), error) < 16.0


def test_walls_are_no_objects_and_neither_are_pieces_of_them_between_people():
    wall = [(4.0, -5.0, 4.0, 5.0)]
    assert len(found(SCAN, HERE, [], walls=wall)) == 0
    people = [(2.0, y, 0.25) for y in np.arange(-2.4, 2.5, 0.8)]
    rng = np.random.default_rng(1)
    for _ in range(10):
        segments = found(SCAN, HERE, people, walls=wall, noise=rng)
        assert (segments.centre[segments.hidden < 2, 0] < 3.0).all()  # a few echoes between two people tell nothing
        assert np.count_nonzero(segments.hidden < 2) == len(people)


def test_two_things_are_two_also_across_the_seam_of_a_ring():
    assert len(found(SCAN, HERE, [(2.0, 0.4, 0.1), (2.0, -0.4, 0.1)])) == 2
    assert len(found(RING, HERE, [(1.0, 0.0, 0.1), (-1.0, 0.0, 0.1)])) == 2
    assert len(found(RING, HERE, [(1.0, -0.1, 0.15)])) == 1


def test_only_a_beam_that_goes_on_behind_the_place_shows_that_nothing_is_there():
    radius = np.array([0.2])
    for things, place, past in [
        ([], (3.0, 0.0), True),
        ([(1.0, 0.0, 0.3)], (3.0, 0.0), False),  # hidden
        ([(3.0, 0.0, 0.2)], (3.0, 0.0), False),
        ([], (-3.0, 0.0), False),  # where no beam looks
        ([], (9.0, 0.0), False),  # too far
    ]:
        scan = SCAN.scan(HERE, ranges_of(SCAN, HERE, things))
        assert scan.sees_past(np.array([place]), radius).tolist() == [past]
    blind = SCAN.scan(HERE, [math.nan] * len(SCAN.mounts))
    assert not blind.sees_past(np.array([[3.0, 0.0]]), radius).any()


def test_beams_of_a_sweep_are_placed_from_where_the_robot_was():
    wall = [(3.0, -9.0, 3.0, 9.0)]
    swept = Beams(SCAN.mounts[::30], SCAN.half_angle, 8.0, 0.01, sweep=0.05)
    poses = np.column_stack([20.0 * swept.offsets, np.zeros_like(swept.offsets), 4.0 * swept.offsets])
    ranges = [ranges_of(swept, Pose2(*pose), [], walls=wall)[i] for i, pose in enumerate(poses)]
    scan = swept.scan(poses, ranges)
    assert scan.heard.sum() > 10
    assert scan.points[scan.heard, 0] == pytest.approx(3.0)


def seen(tracker, t, *things, pose=HERE, rng=None, beams=SCAN, size=0.9):
    """Numbers of the confirmed tracks after one scan of some discs, through the whole chain."""
    tracker.update(t, segments_of(beams.scan(pose, ranges_of(beams, pose, things, noise=rng)), size))
    return tracker.tracks.ids[tracker.tracks.confirmed].tolist()


def test_what_is_seen_twice_is_reported_and_what_is_seen_past_vanishes():
    tracker = Tracker()
    assert seen(tracker, 0.0, (2.0, 0.0, 0.2)) == []
    assert seen(tracker, 0.05, (2.0, 0.0, 0.2)) == [1]
    for k in range(20):
        seen(tracker, 0.1 + 0.05 * k, (2.0, 0.0, 0.2))
    known = [seen(tracker, 2.0 + 0.05 * k) for k in range(6)]
    assert known[0] == [1]
    assert known[-1] == []


def test_what_is_hidden_stays_and_is_forgotten_after_its_half_lives():
    tracker = Tracker(TrackerSettings(half_life=2.0))
    for k in range(20):
        seen(tracker, 0.05 * k, (3.0, 0.0, 0.2))
    for k in range(20):
        seen(tracker, 1.0 + 0.05 * k, (1.0, 0.0, 0.4))
    assert 1 in tracker.tracks.ids
    seen(tracker, 20.0, (1.0, 0.0, 0.4))
    assert 1 not in tracker.tracks.ids


@pytest.mark.parametrize("seed", range(4))
def test_people_that_cross_keep_their_numbers_and_their_velocities(seed):
    rng, tracker = np.random.default_rng(seed), Tracker()
    speed = rng.uniform(0.5, 1.3, 2)
    for k in range(80):
        t = 0.05 * k
        at = [(2.0 + 0.6 * i, (1.0 - 2.0 * i) * (1.6 - speed[i] * t), 0.25) for i in (0, 1)]
        seen(tracker, t, *at, rng=rng)
    tracks = tracker.tracks
    movers = np.flatnonzero(tracks.movers(t))
    assert tracks.ids[movers].tolist() == [1, 2] or tracks.ids[movers].tolist() == [2, 1]
    for x, y, _ in at:
        i = movers[np.argmin(np.hypot(*(tracks.mean[movers, :2] - (x, y)).T))]
        way = -1.0 if x < 2.3 else 1.0
        assert tracks.mean[i] == pytest.approx([x, y, 0.0, way * speed[0 if x < 2.3 else 1]], abs=0.15)


@pytest.mark.parametrize("seed", range(3))
def test_nothing_that_stands_is_taken_for_a_mover_while_the_robot_drives_by(seed):
    rng, tracker = np.random.default_rng(seed), Tracker()
    places = [(1.0 + 0.9 * i, side * rng.uniform(0.6, 3.0)) for i in range(8) for side in (-1.0, 1.0)]
    posts = [(x, y, rng.uniform(0.05, 0.3)) for x, y in places]
    walls = [(-2.0, 3.5, 12.0, 3.5), (-2.0, -3.5, 12.0, -3.5), (10.0, -4.0, 10.0, 4.0)]
    for k in range(100):
        pose = Pose2(0.06 * k, 0.2 * math.sin(0.06 * k), 0.2 * math.cos(0.06 * k))
        ranges = ranges_of(SCAN, pose, posts, walls=walls, noise=rng)
        tracker.update(0.05 * k, segments_of(SCAN.scan(pose, ranges), 0.9))
        assert not (tracker.tracks.movers(0.05 * k) & tracker.tracks.confirmed).any()


def filtered(times, points, sigma, acceleration, speed_noise):
    """A track through measured points, of its own: without scans."""
    tracker = Tracker(TrackerSettings(acceleration, speed_noise))
    noise = sigma[:, None, None] ** 2 * np.eye(2)
    tracker._predict(times[0])
    tracker._start(times[0], points[:1], noise[:1], np.array([0.2]))
    for k in range(1, len(times)):
        tracker._predict(times[k])
        tracker._correct(np.array([0]), points[k : k + 1], noise[k : k + 1])
    return tracker.tracks.mean[0], tracker.tracks.covariance[0]


def test_the_filter_finds_what_weighted_least_squares_finds():
    rng = np.random.default_rng(3)
    times, sigma = 0.1 * np.arange(30), rng.uniform(0.02, 0.3, 30)
    points = np.column_stack([1.0 + 0.4 * times, 2.0 - 0.2 * times]) + sigma[:, None] * rng.normal(size=(30, 2))
    mean, covariance = filtered(times, points, sigma, acceleration=1e-9, speed_noise=1e4)
    rows = np.column_stack([np.ones(30), times - times[-1]]) / sigma[:, None]
    best = np.linalg.lstsq(rows, points / sigma[:, None], rcond=None)[0]
    assert mean == pytest.approx([*best[0], *best[1]], abs=1e-5)
    spread = np.linalg.inv(rows.T @ rows)
    assert covariance[[0, 0, 2], [0, 2, 2]] == pytest.approx(spread[[0, 0, 1], [0, 1, 1]], rel=1e-3)


def test_its_covariance_is_as_large_as_its_errors():
    rng, sigma, errors = np.random.default_rng(4), np.full(20, 0.05), []
    times = 0.1 * np.arange(20)
    for _ in range(150):
        truth, points = np.array([0.0, 0.0, *rng.normal(0.0, 0.5, 2)]), []
        for k in range(20):
            if k:
                push = rng.normal(0.0, 1.5, 2)
                truth = truth + np.concatenate([0.1 * truth[2:] + 0.005 * push, 0.1 * push])
            points.append(truth[:2] + 0.05 * rng.normal(size=2))
        mean, covariance = filtered(times, np.array(points), sigma, acceleration=1.5, speed_noise=0.5)
        errors.append((mean - truth) @ np.linalg.solve(covariance, mean - truth))
    low, high = chi2.ppf([0.0005, 0.9995], 4 * len(errors))
    assert low < sum(errors) < high


@pytest.mark.parametrize("seed", range(6))
def test_whatever_is_seen_beliefs_are_probabilities_and_covariances_positive(seed):
    rng, tracker = np.random.default_rng(seed), Tracker()
    for k in range(40):
        things = [(*rng.uniform(-3.0, 3.0, 2), rng.uniform(0.05, 0.4)) for _ in range(rng.integers(0, 5))]
        ranges = ranges_of(SCAN, HERE, things)
        ranges[rng.random(len(ranges)) < 0.05] = rng.choice([math.nan, math.inf, 0.0])
        tracker.update(0.05 * k, segments_of(SCAN.scan(HERE, ranges), 0.9))
        tracks = tracker.tracks
        assert len(set(tracks.ids.tolist())) == len(tracks)
        assert ((tracks.existence > 0.0) & (tracks.existence < 1.0)).all()
        assert np.isfinite(tracks.mean).all()
        assert all(np.linalg.eigvalsh(covariance).min() > 0.0 for covariance in tracks.covariance)


@pytest.mark.parametrize("wrong", [{"acceleration": 0.0}, {"half_life": -1.0}, {"memory": math.inf}])
def test_settings_that_make_no_sense_are_refused(wrong):
    with pytest.raises(InputError):
        TrackerSettings(**wrong)


@pytest.mark.parametrize("wrong", [{"mounts": []}, {"max_range": 0.0}, {"sweep": -1.0}, {"noise": math.inf}])
def test_beams_that_cannot_be_are_refused(wrong):
    with pytest.raises(InputError):
        Beams(**{"mounts": [(0.0, 0.0, 0.0)], "half_angle": 0.1, "max_range": 2.0} | wrong)


def test_no_tracks_are_no_tracks():
    assert len(TrackedObjects()) == 0
    assert TrackedObjects().movers(0.0).tolist() == []
