"""Pictures of disagreements: the ways of two planners through the same scene, one of which did not arrive."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import numpy.typing as npt

from ...catalog import Catalog
from ...record import RunHeader
from ...record.figures.arena import draw_world
from ...simulation import compose_scenario
from ...simulation.header import make_scenery
from ..bench import Bench
from ..comparison import Comparison, Disagreement
from ..replay import place_named
from .style import colour, line

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

Corner: TypeAlias = npt.NDArray[np.float64]

_MARGIN = 1.0  # [m]
_WIDTH, _LABELS = 3.8, 0.4  # [inch]


def sceneries(scenes: Sequence[str], catalog: Catalog) -> dict[str, RunHeader]:
    """What stands in some scenes, by their names.

    Raises:
        InputError: A scene is no longer there.
    """
    bench, found = Bench(catalog.project), {}
    try:
        for scene in dict.fromkeys(scenes):
            setting = bench.setting(place_named(scene, catalog))
            found[scene] = make_scenery(setting.scenario, compose_scenario(setting.scenario, setting.catalog))
    finally:
        bench.close()
    return found


def draw_disagreement(
    canvas: Canvas, name: str, found: Disagreement, comparison: Comparison, scenery: RunHeader | None
) -> None:
    """Both ways; a ring where the one that did not succeed ended.

    Args:
        canvas: Where to.
        name: The figure's name, with which its ids begin.
        found: The two episodes.
        comparison: All planners, for their colours.
        scenery: What stands there, where that is known.
    """
    axes = canvas.add_subplot()
    axes.set_aspect("equal")
    if scenery is not None:
        draw_world(axes, scenery, name)
    for record in (found.winner, found.loser):
        number = comparison.planners.index(record.planner)
        path = record.path.astype(float)
        if not len(path):
            continue
        axes.plot(*path.T, zorder=4, gid=f"{name}-{record.planner}", **line(number))
        axes.plot(*path[0], "o", color=colour(number), ms=3, zorder=5)
        if not record.success:
            axes.plot(*path[-1], "x", color=colour(number), ms=9, mew=2.0, zorder=6, gid=f"{name}-end")
    low, high = _box(found)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")


def picture_size(found: Disagreement) -> tuple[float, float]:
    """Width and height [inch] that fit both ways."""
    (width, height) = np.subtract(*reversed(_box(found)))
    return _WIDTH, float(np.clip(_WIDTH * height / width, _WIDTH / 2, 2 * _WIDTH)) + _LABELS


def _box(found: Disagreement) -> tuple[Corner, Corner]:
    """The least and the greatest x and y [m] of both ways and what stands near them, not of all of a large world."""
    every = np.concatenate([found.winner.path, found.loser.path, np.zeros((0, 2), np.float32)]).astype(float)
    if not len(every):
        return np.array([-_MARGIN, -_MARGIN]), np.array([_MARGIN, _MARGIN])
    return every.min(axis=0) - _MARGIN, every.max(axis=0) + _MARGIN
