"""Ground of a scenario, with random bumps by its seed."""

from __future__ import annotations

import numpy as np

from ..catalog import GroundSpec, ScenarioSpec
from ..devices.mujoco.terrain import GroundPiece
from ..record.file.header import Outline
from .random_streams import GROUND, stream


def ground_pieces(scenario: ScenarioSpec, seed: int) -> list[GroundPiece]:
    """Pieces of ground of a scenario."""
    return [piece for ground in scenario.grounds for piece in _pieces(ground, scenario.name, seed)]


def ground_outlines(scenario: ScenarioSpec) -> tuple[Outline, ...]:
    """Outlines of the ground that is not level, from above."""
    return tuple(
        Outline.box(g.name, g.pose, (g.length, g.width), g.height * (g.count if g.kind == "step" else 1))
        for g in scenario.grounds
    )


def _pieces(ground: GroundSpec, scenario: str, seed: int) -> list[GroundPiece]:
    length, width, height = ground.length, ground.width, ground.height
    if ground.kind == "slope":
        heights = np.array([[0.0, height], [0.0, height]])
        return [GroundPiece(ground.name, ground.pose, length, width, heights)]
    if ground.kind == "rough":
        bumps = _bumps(ground, stream(scenario, seed, ground.name, GROUND))
        return [GroundPiece(ground.name, ground.pose, length, width, bumps)]
    depth = length / ground.count
    middles = [ground.pose.transform((i + 0.5) * depth - length / 2.0, 0.0) for i in range(ground.count)]
    return [
        GroundPiece(f"{ground.name}/{i}", ground.pose._replace(x=x, y=y), depth, width, np.array([[i * height]]))
        for i, (x, y) in enumerate(middles, 1)
    ]


def _bumps(ground: GroundSpec, rng: np.random.Generator) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Heights of rough ground: uniformly distributed, level at the border, and the highest has the ground's height."""
    rows, columns = (max(round(side / ground.grain) + 1, 3) for side in (ground.width, ground.length))
    heights = rng.uniform(0.0, 1.0, (rows, columns))
    heights[[0, -1], :] = heights[:, [0, -1]] = 0.0
    scaled: np.ndarray[tuple[int, ...], np.dtype[np.float64]] = heights * (ground.height / heights.max())
    return scaled
