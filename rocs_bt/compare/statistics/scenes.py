"""Scenes are the sample: the seeds of one scene are alike, so they say less than as many scenes would.

All functions take values[scene, seed], with NaN where an episode has no value. The mean of a scene's seeds is what the
scene says; the scenes are independent of each other, so everything follows from these means as it does from a plain
sample (ultimate clusters: Hansen, Hurwitz and Madow, Sample Survey Methods and Theory, 1953).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


def scene_means(values: Floats) -> Floats:
    """The mean of each scene that has a value.

    Args:
        values: (n_scenes, n_seeds), NaN where there is none.

    Returns:
        (n,) With n <= n_scenes.
    """
    known = values[~np.isnan(values).all(axis=1)]
    return known[:, 0].copy() if known.shape[1] == 1 else np.nanmean(known, axis=1)


@dataclass(frozen=True)
class Size:
    """How much a sample of scenes and seeds is worth.

    Attributes:
        scenes: How many scenes have a value.
        episodes: How many episodes have one.
        alike: How alike the seeds of a scene are: 0 as if they were of different scenes, 1 all the same (the
            intra-class correlation, from the analysis of variance; clipped to 0 and 1).
        design_effect: By how much the variance of the mean exceeds that of as many independent episodes (Kish, Survey
            Sampling, 1965).
        effective: How many independent episodes would say as much.
    """

    scenes: int
    episodes: int
    alike: float
    design_effect: float
    effective: float


def sample_size(values: Floats) -> Size:
    """How much a sample of scenes and seeds is worth.

    Args:
        values: (n_scenes, n_seeds), NaN where there is none.
    """
    known = values[~np.isnan(values).all(axis=1)]
    scenes, episodes = len(known), int((~np.isnan(known)).sum())
    if scenes < 2:
        return Size(scenes, episodes, 1.0, float(episodes or 1), float(scenes))
    spread = float(np.nanvar(known)) * episodes / (episodes - 1)
    between = float(scene_means(known).var(ddof=1)) / scenes
    seeds = episodes / scenes
    effect = between * episodes / spread if spread > 0.0 else seeds
    effect = min(max(effect, 1.0), seeds)
    alike = (effect - 1.0) / (seeds - 1.0) if seeds > 1.0 else 1.0
    return Size(scenes, episodes, alike, effect, episodes / effect)
