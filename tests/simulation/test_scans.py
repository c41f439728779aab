"""A laser scanner's echoes as the report draws them: where things stand."""

from __future__ import annotations

import json
import math
import re

import numpy as np
import pytest

from rocs_bt import Catalog, run
from rocs_bt.compare import load_family


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scans")
    scene = load_family(Catalog(), "barn_like", {}).scene(4)
    scene.write(folder)
    page = run(scene.name, Catalog(folder), out=folder / "run", duration=3.0).report.read_text()
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)[1])


def ends_of(data, i):
    """(k, 2) The echoes of a scan in the world, as the page's script reckons them."""
    (body,), (agent,) = data["bodies"], data["agents"]
    (scans,) = agent["scans"]
    x, y, first, step, reach = scans["fan"]
    t = scans["t"][i]
    px, py, yaw = (
        np.interp(t, body["t"], np.unwrap(body[axis]) if axis == "yaw" else body[axis]) for axis in ("x", "y", "yaw")
    )
    eye = px + math.cos(yaw) * x - math.sin(yaw) * y, py + math.sin(yaw) * x + math.cos(yaw) * y
    heard = [(k, r) for k, r in enumerate(scans["ranges"][i]) if r is not None and 0.0 < r < reach]
    angles = np.array([yaw + first + k * step for k, _ in heard])
    ranges = np.array([r for _, r in heard])
    return np.array(eye) + ranges[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def test_echoes_are_drawn_where_posts_stand(data):
    posts = np.array([(*o["points"][0], o["radius"]) for o in data["outlines"] if o["radius"] > 0.0])
    assert len(data["agents"][0]["scans"][0]["t"]) > 40
    for i in (0, 20, 40):
        ends = ends_of(data, i)
        assert len(ends) > 60
        away = np.linalg.norm(ends[:, None, :] - posts[None, :, :2], axis=2) - posts[:, 2]
        # The range has noise of 1 cm, poses and ranges are rounded, and the floor is hit nowhere.
        assert np.median(np.abs(away).min(axis=1)) < 0.015
        assert (np.abs(away).min(axis=1) < 0.06).mean() > 0.99


def test_the_picture_is_wide_enough_for_the_goal(data):
    (goal,) = data["places"]
    left, low, right, high = data["bounds"]
    assert left <= goal["x"] - goal["radius"] < goal["x"] + goal["radius"] <= right
    assert low <= goal["y"] - goal["radius"] < goal["y"] + goal["radius"] <= high
