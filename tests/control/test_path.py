from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.errors import InputError
from rocs_bt.control.path import Path

coordinates = st.floats(-5.0, 5.0)
points = st.tuples(coordinates, coordinates)
polylines = st.lists(points, min_size=1, max_size=8)


def circle(radius: float, count: int) -> Path:
    angles = np.linspace(0.0, 2.0 * np.pi, count)
    return Path(radius * np.column_stack([np.cos(angles), np.sin(angles)]))


@given(polylines)
def test_a_path_keeps_its_ends_and_never_gains_length(corners: list[tuple[float, float]]) -> None:
    path = Path(corners)
    legs = np.hypot(*np.diff(np.array(corners), axis=0).T)
    assert path.length == pytest.approx(legs.sum(), abs=1e-6)
    np.testing.assert_allclose(path.position(0.0), corners[0], atol=1e-8)
    np.testing.assert_allclose(path.position(path.length), corners[-1], atol=1e-8)
    assert np.isfinite(path.samples).all()


@given(polylines, points)
@settings(max_examples=60)
def test_projection_is_the_nearest_place(corners: list[tuple[float, float]], point: tuple[float, float]) -> None:
    path = Path(corners)
    x, y = point
    fine = path.position(np.linspace(0.0, path.length, 20001))
    nearest = np.hypot(fine[:, 0] - x, fine[:, 1] - y).min()
    found = path.position(path.project(x, y))
    # On a cell beside the nearest sample the true nearest place may be a fraction of the spacing closer.
    assert np.hypot(found[0] - x, found[1] - y) <= nearest + path.spacing  # as above: math.hypot rounds otherwise


@given(points, st.floats(-math.pi, math.pi), st.floats(0.1, 5.0), st.floats(0.0, 1.0), st.floats(-2.0, 2.0))
def test_projection_onto_a_line_is_the_foot_of_the_normal(start, yaw, length, at, offset) -> None:
    c, s = math.cos(yaw), math.sin(yaw)
    path = Path.line(start, (start[0] + length * c, start[1] + length * s))
    x, y = start[0] + at * length * c - offset * s, start[1] + at * length * s + offset * c
    assert path.project(x, y) == pytest.approx(at * length, abs=1e-6)


@given(st.floats(-0.4, 0.4), st.floats(0.1, 0.9), st.floats(-0.4, 0.4))
def test_projection_from_a_near_hint_finds_the_foot_of_the_normal(error: float, at: float, offset: float) -> None:
    path = circle(1.5, 400)
    s = at * path.length
    x, y, yaw, _ = path.sample(s)
    found = path.project(x - offset * math.sin(yaw), y + offset * math.cos(yaw), s + error)
    assert found == pytest.approx(s, abs=0.02)


def test_a_hint_follows_a_crossing_path_in_order() -> None:
    t = np.linspace(0.0, 2.0 * np.pi, 800)
    path = Path(np.column_stack([np.sin(t), np.sin(t) * np.cos(t)]))
    half = path.length / 2.0
    assert path.project(0.0, 0.0, half - 0.1) == pytest.approx(half, abs=0.02)
    assert path.project(0.0, 0.0, 0.1) == pytest.approx(0.0, abs=0.02)


@pytest.mark.parametrize("count", [40, 400, 4000])
def test_heading_and_curvature_of_a_circle(count: int) -> None:
    path = circle(0.8, count)
    inner = np.linspace(0.1, path.length - 0.1, 300)
    assert path.curvature(inner).mean() == pytest.approx(1 / 0.8, rel=0.01)
    np.testing.assert_allclose(path.heading(inner), np.pi / 2 + inner / 0.8, atol=0.05)
    if count > 100:
        np.testing.assert_allclose(path.curvature(inner), 1 / 0.8, rtol=0.1)


def test_single_and_vectorised_look_ups_agree() -> None:
    path = Path.through([(0, 0), (1, 0), (1, 2)], corner_radius=0.3)
    stations = np.linspace(-0.5, path.length + 0.5, 57)
    rows = path.at(stations)
    for s, row in zip(stations, rows, strict=True):
        np.testing.assert_allclose(path.at(s), row, atol=1e-12)
        np.testing.assert_allclose(path.sample(float(s)), row, atol=1e-12)
    assert path.at(-0.5)[0] == 0.0
    np.testing.assert_allclose(path.position(99.0), [1.0, 2.0])


def test_rounded_corners_have_the_radius_asked_for_and_touch_the_legs() -> None:
    path = Path.through([(0, 0), (2, 0), (2, 2)], corner_radius=0.5)
    assert path.length == pytest.approx(4.0 - 2 * 0.5 + 0.5 * math.pi / 2, abs=1e-3)
    assert path.curvature(path.length / 2) == pytest.approx(2.0, rel=0.02)
    s = path.project(2.0 - 0.5, 0.5)
    middle = path.position(path.length / 2)
    assert math.hypot(middle[0] - 1.5, middle[1] - 0.5) == pytest.approx(0.5, abs=1e-3)
    assert 0.0 < s < path.length


def test_a_radius_too_large_for_its_legs_is_cut_down() -> None:
    path = Path.through([(0, 0), (0.4, 0), (0.4, 3)], corner_radius=5.0)
    assert path.position(0.0) == pytest.approx([0.0, 0.0])
    assert path.curvature(np.linspace(0, path.length, 200)).max() == pytest.approx(1 / 0.2, rel=0.1)


def test_straight_on_and_straight_back_are_left_as_they_are() -> None:
    path = Path.through([(0, 0), (1, 0), (2, 0), (1, 0)], corner_radius=0.3)
    assert path.length == pytest.approx(3.0)
    assert np.isfinite(path.samples).all()


@pytest.mark.parametrize("same", [[(1.0, 2.0)], [(1.0, 2.0)] * 3])
def test_a_path_of_one_place_is_legal(same: list[tuple[float, float]]) -> None:
    path = Path(same)
    assert path.length == 0.0
    assert path.project(7.0, -3.0, hint=2.0) == 0.0
    np.testing.assert_array_equal(path.at([0.0, 5.0]), [[1.0, 2.0, 0.0, 0.0]] * 2)
    assert path.sample(3.0) == (1.0, 2.0, 0.0, 0.0)


def test_repeated_points_change_nothing() -> None:
    once, twice = Path([(0, 0), (1, 0), (1, 1)]), Path([(0, 0), (0, 0), (1, 0), (1, 0), (1, 1), (1, 1)])
    np.testing.assert_array_equal(once.samples, twice.samples)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [([], "one or more points"), ([1.0, 2.0], "one or more points"), ([(0, 0), (math.nan, 1)], "point 1")],
)
def test_points_that_are_none_are_refused(wrong: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Path(wrong)


def test_numbers_out_of_range_are_refused() -> None:
    with pytest.raises(InputError, match="spacing"):
        Path([(0, 0), (1, 0)], spacing=0.0)
    with pytest.raises(InputError, match="corner radius"):
        Path.through([(0, 0), (1, 0)], corner_radius=-1.0)


def test_places_before_the_least_do_not_count() -> None:
    there_and_back = Path([(0.0, 0.0), (2.0, 0.0), (2.0, 0.1), (0.0, 0.1)])
    assert there_and_back.project(1.0, 0.0) == pytest.approx(1.0)
    assert there_and_back.project(1.0, 0.0, least=2.1) == pytest.approx(3.1)
    assert there_and_back.project(1.0, 0.0, hint=1.0, least=2.1) == pytest.approx(3.1)
    assert there_and_back.project(1.0, 0.0, least=99.0) == pytest.approx(there_and_back.length)


@pytest.mark.parametrize("far", [10_001.0, 9e9, 1e300])
def test_a_path_that_is_too_long_is_refused(far: float) -> None:
    with pytest.raises(InputError, match="a path may be 10000 m long, found "):
        Path([(0.0, 0.0), (far, far)])


@pytest.mark.parametrize("seed", range(20))
def test_the_outline_is_near_the_path_and_short(seed):
    rng = np.random.default_rng(seed)
    turns = rng.uniform(-1.5, 1.5, 12)
    points = np.cumsum(rng.uniform(0.5, 2.0, (12, 1)) * np.stack([np.cos(turns), np.sin(turns)], 1), axis=0)
    path = Path(points)
    corners = np.array(path.outline())
    assert np.allclose(corners[[0, -1]], path.samples[[0, -1], :2], atol=1e-3)
    assert len(corners) <= 0.1 * len(path.samples)
    begin, end = corners[:-1, None], corners[1:, None]
    along = end - begin
    part = ((path.samples[:, :2] - begin) * along).sum(-1) / np.maximum((along**2).sum(-1), 1e-12)
    off = np.hypot(*np.moveaxis(begin + np.clip(part, 0.0, 1.0)[..., None] * along - path.samples[:, :2], -1, 0))
    assert off.min(axis=0).max() < 0.011
