"""A laser scanner's echoes as the report draws them: where things stand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rocs_bt import Catalog, run
from rocs_bt.compare import load_family

from ..pages import columns_of


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scans")
    scene = load_family(Catalog(), "barn_like", {}).scene(4)
    scene.write(folder)
    return columns_of(run(scene.name, Catalog(folder), out=folder / "run", duration=3.0).report)


def track(report, topic):
    """Times and rows of the only track of a topic, and the rays from one value to the next."""
    data, column = report
    ((_, _, t, v, _, ray),) = [each for each in data["tracks"] if each[0].split("|")[1] == topic]
    return column(t)[:, 0], column(v), ray


def ends_of(report, i):
    """(k, 2) The echoes of a scan in the world, as the page's script reckons them."""
    (body,) = report[0]["header"]["bodies"]
    (fan,) = body["fans"].values()
    (times, scans, ray), (moved, poses, _) = track(report, "scan"), track(report, "pose")
    px, py, yaw = (np.interp(times[i], moved, values) for values in (*poses[:, :2].T, np.unwrap(poses[:, 2])))
    eye = (
        px + math.cos(yaw) * fan["x"] - math.sin(yaw) * fan["y"],
        py + math.sin(yaw) * fan["x"] + math.cos(yaw) * fan["y"],
    )
    heard = np.flatnonzero((scans[i] > 0.0) & (scans[i] < fan["reach"]))
    angles, ranges = yaw + fan["yaw"] + heard * fan["step"] * ray, scans[i][heard]
    return np.array(eye) + ranges[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def test_echoes_are_drawn_where_posts_stand(report):
    outlines = report[0]["header"]["outlines"]
    posts = np.array([(*o["points"][0], o["radius"]) for o in outlines if o["radius"] > 0.0])
    assert len(track(report, "scan")[0]) > 40
    for i in (0, 20, 40):
        ends = ends_of(report, i)
        assert len(ends) > 60
        away = np.linalg.norm(ends[:, None, :] - posts[None, :, :2], axis=2) - posts[:, 2]
        # The range has noise of 1 cm, poses and ranges are rounded, and the floor is hit nowhere.
        assert np.median(np.abs(away).min(axis=1)) < 0.015
        assert (np.abs(away).min(axis=1) < 0.06).mean() > 0.99
