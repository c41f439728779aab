"""What `_numbers.c` stands in for: it does the same to the bit."""

import math
import struct
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import rocs_bt.actions.give_way as give_way
import rocs_bt.control.follower as follower
import rocs_bt.control.grid as grid
import rocs_bt.control.motion_filter as motion_filter
import rocs_bt.control.path as path
import rocs_bt.control.profile as profile
import rocs_bt.control.reference as reference
import rocs_bt.control.ways as ways
import rocs_bt.drivers.mujoco.sensors as sensors
import rocs_bt.event as event
import rocs_bt.geometry as geometry
import rocs_bt.knowledge.signals as signals
import rocs_bt.monitor.free_ground as free_ground
import rocs_bt.monitor.gaps as gaps
import rocs_bt.record.codec as codec
import rocs_bt.record.container as container
from rocs_bt.compiled import PLAIN, compiled
from rocs_bt.geometry import Pose2, Twist2

near = st.floats(-4.0, 4.0)
small = st.one_of(near, st.floats(-1e-8, 1e-8), st.just(0.0))
poses = st.builds(Pose2, near, near, st.floats(-math.pi, math.pi))
twists = st.builds(Twist2, near, small, small)


def bits(numbers):
    return [struct.pack("d", number) for number in np.ravel(numbers)]


def points(least=0):
    return st.integers(least, 12).flatmap(lambda n: arrays(float, (n, 2), elements=near))


def test_what_is_not_in_the_kernel_is_itself():
    def nobody_compiled_this():
        pass

    try:
        assert compiled(nobody_compiled_this) is nobody_compiled_this
    finally:
        del PLAIN["nobody_compiled_this"]


@pytest.mark.usefixtures("kernel")
def test_all_of_them_are_compiled():
    places = {
        "arc_poses": geometry,
        "arc_positions": geometry,
        "wrap_angle": geometry,
        "hull_gaps": geometry,
        "least_gaps": gaps,
        "nearest_moment": give_way,
        "pull": give_way,
        "bent_at": give_way,
        "turned_at": give_way,
        "least_apart": give_way,
        "costs_at": give_way,
        "along_at": ways,
        "nearest": path,
        "rows_at": grid,
        "within": follower,
        "turn_on": motion_filter,
        "sight": motion_filter,
        "inverse": motion_filter,
        "stations_at": profile,
        "path_stages": reference,
        "timed_lines": reference,
        "timed_stages": reference,
        "strides_at": free_ground,
        "mark_at": free_ground,
        "fill": signals,
        "valid": signals,
        "least_echoes": sensors,
        "finite_all": codec,
        "chunked": container,
        "pack": event,
    }
    assert {*PLAIN} == {*places}
    assert all(getattr(place, name) is not PLAIN[name] for name, place in places.items())


@pytest.mark.usefixtures("kernel")
@given(poses, twists, st.lists(small, max_size=9))
def test_arcs(pose, twist, durations):
    expected = PLAIN["arc_positions"](pose, twist, durations)
    found = geometry.arc_positions(pose, twist, iter(durations))
    assert bits(found) == bits(expected)
    assert [type(place) for place in found] == [tuple] * len(durations)
    assert bits(geometry.arc_poses(pose, twist, durations)) == bits(PLAIN["arc_poses"](pose, twist, durations))
    assert bits(geometry.arc(pose, twist, durations)) == bits([geometry.along_arc(pose, twist, t) for t in durations])


@pytest.mark.usefixtures("kernel")
@given(st.lists(st.tuples(poses, st.tuples(near, near)), max_size=9), st.tuples(near, near), near)
def test_gaps(moments, half, radius):
    way, places = [pose for pose, _ in moments], [place for _, place in moments]
    assert bits(geometry.hull_gaps(way, places, half, radius)) == bits(PLAIN["hull_gaps"](way, places, half, radius))


@pytest.mark.usefixtures("kernel")
@given(st.tuples(near, near, near, near), points(), st.integers(1, 7), near)
def test_ground(frame, spots, size, t):
    frame = tuple(10.0 * value for value in frame[:2]) + frame[2:]
    rng = np.random.default_rng(0)
    one = rng.normal(size=(size, size))
    other = one.copy()
    free_ground.mark_at(one, frame, spots, t)
    PLAIN["mark_at"](other, frame, spots, t)
    assert one.tobytes() == other.tobytes()
    fan = np.moveaxis(rng.uniform(-2.0, 2.0, (2, 5, 4, 2)), 1, 2)
    for asked in (fan, fan[::2, :, ::-1], fan[:0], fan[:, :0], fan[:, :, :0], spots[:, None, None]):
        for since in (-9.0, -0.8, 0.3):
            expected = PLAIN["strides_at"](one, frame, asked, since)
            assert free_ground.strides_at(one, frame, asked, since) == expected


@pytest.mark.usefixtures("kernel")
@given(
    poses,
    arrays(float, (9, 3), elements=near),
    st.lists(arrays(float, (9, 3), elements=near), max_size=3),
    st.tuples(st.floats(0.0, 2.0), st.floats(0.0, 1.0), st.floats(0.0, 2.0), st.floats(0.0, 1.0)),
)
def test_strings(pose, leader, others, limits):
    one, other = np.empty((9, 3)), np.empty((9, 3))
    give_way.pull(one, pose, leader, others, give_way.DETOURS, limits)
    PLAIN["pull"](other, pose, leader, others, give_way.DETOURS, limits)
    assert one.tobytes() == other.tobytes()


@pytest.mark.usefixtures("kernel")
@given(
    poses,
    arrays(float, (4, 1), elements=small),
    st.sampled_from([1, 5, 8, 26, 137, 300]),
    st.integers(0, 2**32),
    st.integers(0, 2),
    st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)),
)
def test_ways_out_of_the_way(pose, bends, moments, seed, crowd, half):
    rng, made = np.random.default_rng(seed), []
    runs = np.minimum(rng.uniform(-1.0, 3.0, (4, moments)), 1.0)  # many are alike
    leader, *others = rng.normal(0.0, 2.0, (1 + crowd, moments, 3))
    headings, errors, reach = rng.uniform(-3.0, 3.0, (3, 3))
    errors[0] = reach[1] = 0.0  # it looks there already; it may not go there
    ahead, times = (headings, errors, np.abs(reach)), np.linspace(0.0, 2.5, moments)
    for of in (vars(give_way), PLAIN):
        ways, costs = np.zeros((3, 8, moments)), np.empty(8)
        of["bent_at"](pose, runs, bends, ways[:, 1:5])  # as GiveWay asks: for some of all ways
        of["turned_at"](pose, ahead, (0.5, 1.5, 0.3, 0.75), times, ways[:, 5:])
        soon = [other[: (moments + 1) // 2] for other in others]
        of["costs_at"](ways, leader, soon, half, (1.4, 1.2, 0.6, 4.0, 0.02), (moments + 1) // 2, costs)
        least = [of["least_apart"](way, leader, half) for way in (ways[:, 2].T, others[0] if others else leader)]
        made.append((ways.tobytes(), costs.tobytes(), *least))
    assert made[0] == made[1]


@pytest.mark.usefixtures("kernel")
@given(st.lists(st.tuples(near, near, near, near, small, near), min_size=1, max_size=3), st.integers(0, 6))
def test_many_arcs(motions, count):
    durations = np.linspace(0.0, 2.5, count) + np.arange(len(motions))[:, None]
    one, other = np.empty((*durations.shape, 3)), np.empty((*durations.shape, 3))
    ways.along_at(motions, durations, one)
    PLAIN["along_at"](motions, durations, other)
    assert one.tobytes() == other.tobytes()


@pytest.mark.usefixtures("kernel")
@given(
    st.lists(
        st.lists(st.one_of(near, st.just(math.nan), st.just(math.inf), st.integers(-3, 3)), max_size=4), max_size=4
    ),
    st.lists(st.tuples(st.floats(-5.0, 0.0), st.sampled_from([0.0, 3.0, math.inf])), min_size=1, max_size=3),
    st.integers(0, 1),
)
def test_signals(values, limits, more):
    sizes = tuple(map(len, values))
    size = sum(sizes)
    edges = np.linspace(0, size, len(limits) + 1).astype(int).tolist()
    runs = [(*limit, *edges[i : i + 2]) for i, limit in enumerate(limits) if edges[i] < edges[i + 1]]
    bounds = np.array(runs, dtype=float).reshape(-1, 4)
    made = []
    for filling in (signals.fill, PLAIN["fill"]):
        target, expires = np.zeros(size), np.zeros(size)
        found = filling(target, expires, 2.5, [*values[more:], *values[:more]], sizes, bounds)
        made.append((found, target.tobytes(), expires.tobytes()))
    assert made[0] == made[1]


@pytest.mark.usefixtures("kernel")
@given(points(least=1), st.data())
def test_rows_and_nearest(spots, data):
    low = data.draw(st.integers(0, len(spots) - 1))
    high = data.draw(st.integers(low, len(spots) - 1))
    (x, y), (xs, ys) = data.draw(st.tuples(near, near)), spots.T.copy()
    assert path.nearest(xs, ys, x, y, low, high) == PLAIN["nearest"](xs, ys, x, y, low, high)
    rows, slopes, steps = (data.draw(arrays(float, shape, elements=near)) for shape in ((5, 3), (5, 3), 4))
    found, expected = np.empty((4, 3)), np.empty((4, 3))
    grid.rows_at(rows, slopes, 2.0 * steps, found)
    PLAIN["rows_at"](rows, slopes, 2.0 * steps, expected)
    assert found.tobytes() == expected.tobytes()


@pytest.mark.usefixtures("kernel")
@given(
    st.lists(st.tuples(st.sampled_from([0.1, 0.3, 0.5]), st.floats(0.0, 1.0), st.floats(0.01, 0.5)), max_size=9),
    st.lists(st.floats(0.0, 0.5), max_size=6),
    st.tuples(st.floats(-0.5, 3.0), st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.0, 2.0)),
    st.data(),
)
def test_profiles(cells, steps, begin, data):
    stations, squared, passed = np.cumsum([(0.0, 0.25, 0.0), *cells], axis=0).T.copy()
    squared, times, made = 1.0 / (1.0 + squared), np.cumsum(steps), []
    rows = np.abs(data.draw(arrays(float, (len(times), 5), elements=near)))
    for of in ({**vars(profile), **vars(reference)}, PLAIN):
        found, stages = np.empty(len(times)), np.empty((len(times), 6))
        if len(times):
            of["stations_at"]((stations, squared, passed), begin, times, found)
        of["path_stages"](rows, begin[:3], times, stages)
        made.append((found.tobytes(), stages.tobytes()))
    assert made[0] == made[1]


@pytest.mark.usefixtures("kernel")
@given(arrays(float, 5, elements=small), poses, st.floats(0.01, 2.0), st.floats(0.1, 9.0), st.data())
def test_tracks(state, observer, dt, distance, data):
    matrix, made = data.draw(arrays(float, (2, 2), elements=st.floats(0.1, 3.0))) + np.diag([0.0, 9.0]), []
    for of in (vars(motion_filter), PLAIN):
        moved, slope, seen, error, found = (np.zeros(shape) for shape in (5, (5, 5), (2, 5), 2, (2, 2)))
        of["turn_on"](state, dt, 0.9, moved, slope)
        there = of["sight"](state, observer, distance, 0.3 * dt, seen, error)
        nowhere = of["sight"](state, Pose2(*state[:2].tolist()), distance, 0.3 * dt, seen, error)
        of["inverse"](matrix, found)
        made.append((there, nowhere, *(array.tobytes() for array in (moved, slope, seen, error, found))))
    assert made[0] == made[1]


TIMES = st.lists(st.sampled_from([0.5, 1.0, 1.25, 2.0, 2.75, 3.0, 3.5, 9.0]), min_size=1, max_size=5)


@pytest.mark.usefixtures("kernel")
@given(st.one_of(TIMES, TIMES.map(lambda times: sorted({*times}))), TIMES, st.data())
def test_timetables(times, at, data):
    times, at, made = np.array(times), np.array(at), []
    poses = data.draw(arrays(float, (len(times), 3), elements=st.one_of(near, st.sampled_from([math.pi, math.nan]))))
    kernel, plain = ((reference.timed_lines, reference.timed_stages), (PLAIN["timed_lines"], PLAIN["timed_stages"]))
    for lines, stages in (kernel, plain):
        since, begin, velocity = np.empty(len(times) + 1), np.empty((len(times) + 1, 3)), np.empty((len(times) + 1, 3))
        fit, found = lines(times, poses, since, begin, velocity), np.empty((len(at), 6))
        if fit is not False:
            stages(times, since, begin, velocity, at, found)
            made.append((fit, *(array.tobytes() for array in (since, begin, velocity, found))))
        else:
            made.append((fit,))
    assert made[0] == made[1]


@pytest.mark.usefixtures("kernel")
@given(points(), st.tuples(near, near), arrays(float, (6, 3), elements=near), arrays(float, (6, 3), elements=near))
def test_what_is_near(spots, half, way, other):
    bearings, sectors = np.arctan2(spots[:, 1], spots[:, 0]), np.array([(0.3, 1.0), (0.7, 0.85), (1.0, 0.6)])
    given_ones = spots, bearings, half, sectors
    assert bits(gaps.least_gaps(*given_ones)) == bits(PLAIN["least_gaps"](*given_ones))
    assert give_way.nearest_moment(way, other) == PLAIN["nearest_moment"](way, other)
    turned = np.array([*other.T.copy()]).T  # as GiveWay leaves it, columns first
    assert give_way.nearest_moment(way, turned) == PLAIN["nearest_moment"](way, turned)


@pytest.mark.usefixtures("kernel")
@given(st.lists(st.floats(), max_size=9), st.floats(allow_nan=False))
def test_readings(numbers, t):
    assert event.pack(numbers) == event.pack(iter(numbers)) == PLAIN["pack"](numbers)
    values, expires = np.array(numbers), np.array(numbers[::-1])
    found, expected = np.empty(len(numbers)), np.empty(len(numbers))
    signals.valid(values, expires, t, found)
    PLAIN["valid"](values, expires, t, expected)
    np.testing.assert_array_equal(found, expected)
    rays = np.resize(np.array([*numbers, -1.0]), 6)
    np.testing.assert_array_equal(sensors.least_echoes(rays, 3), PLAIN["least_echoes"](rays, 3))


@pytest.mark.usefixtures("kernel")
@given(arrays(float, (3, 4, 2), elements=st.one_of(near, st.sampled_from([math.nan, math.inf, -math.inf]))), near)
def test_limits(numbers, limit):
    for values in (numbers, numbers[0], numbers[:0], numbers[:, ::2, ::-1], numbers.T, numbers[1, 1]):
        for most in (abs(limit), sys.float_info.max):
            assert follower.within(values, most) is PLAIN["within"](values, most)


@pytest.mark.usefixtures("kernel")
@given(st.floats(allow_infinity=False, allow_nan=False))
def test_angles(angle):
    assert bits(geometry.wrap_angle(angle)) == bits(PLAIN["wrap_angle"](angle))


@pytest.mark.usefixtures("kernel")
def test_half_turns_are_positive():
    assert geometry.wrap_angle(-math.pi) == geometry.wrap_angle(3.0 * math.pi) == math.pi
    for wrap in (geometry.wrap_angle, PLAIN["wrap_angle"]):
        assert math.isnan(wrap(math.nan))
        with pytest.raises(ValueError, match="domain"):
            wrap(math.inf)


DATA = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=3), st.just(np.float64(1.0))),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.tuples(inner, inner),
        st.dictionaries(st.text(max_size=3), inner, max_size=3),
    ),
    max_leaves=8,
)


@pytest.mark.usefixtures("kernel")
@given(st.lists(DATA, max_size=4))
def test_what_is_finite(values):
    assert codec.finite_all(values) is PLAIN["finite_all"](values)


@pytest.mark.usefixtures("kernel")
@given(
    st.lists(st.tuples(st.integers(0, 3), st.integers(0, 2**32 - 1), st.integers(0, 2**64 - 1), st.binary())),
    st.integers(0, 2**40),
)
def test_messages(messages, begin):
    one, other = ({channel: [] for channel in range(4)} for _ in range(2))
    assert container.chunked(messages, begin, one) == PLAIN["chunked"](messages, begin, other)
    assert one == other


@pytest.mark.usefixtures("kernel")
def test_what_is_nowhere_is_on_no_square():
    ground = np.zeros((3, 3))
    nowhere = np.array([[math.nan, 0.0], [math.inf, 0.0], [-math.inf, 0.0], [1e300, 1e300]])
    assert free_ground.strides_at(ground, (0.0, 0.0, 1.0, 0.0), nowhere[:, None, None], 0.0) == [0] * 4
    free_ground.mark_at(ground, (0.0, 0.0, 1.0, 0.0), nowhere, 1.0)
    assert not ground.any()


def test_a_crowd_of_any_size_is_gone_round():
    crowd = [np.tile((2.0, 0.1 * i, 0.0), (9, 1)) for i in range(200)]
    leader, one, other = np.tile((5.0, 0.0, 0.0), (9, 1)), np.empty((9, 3)), np.empty((9, 3))
    limits = (1.0, 0.5, 0.5, 0.3)
    give_way.pull(one, Pose2(0.0, 0.0), leader, crowd, give_way.DETOURS, limits)
    PLAIN["pull"](other, Pose2(0.0, 0.0), leader, crowd, give_way.DETOURS, limits)
    assert one.tobytes() == other.tobytes()


@pytest.mark.parametrize("where", range(3))
def test_what_is_not_a_number_is_near_to_nobody(where):
    pose = [0.5, 0.2, 0.1]
    pose[where] = math.nan
    assert math.isnan(geometry.hull_gaps((Pose2(*pose),), ((0.0, 0.0),), (0.3, 0.2), 0.1)[0])
    way = np.array([[0.0, 0.0, 0.0], pose])
    if where < 2:
        assert math.isnan(give_way.nearest_moment(way, np.zeros((2, 3))))
