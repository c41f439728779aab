"""MRPB: maps from a user's clone of the local planning benchmark (Wen et al., MRPB 1.0, ICRA 2021).

The maps have no starts and goals. These are sampled with a seed from the map's name, so every import gives the same
scenes.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...errors import Fault, InputError
from ...files import read_text
from ..family import AgentSetup, Scene
from .map_scenes import ground_of, sample_ends, scene_between
from .raster import read_map

APART = 4.0
"""Minimum distance between start and goal [m]."""


def read_mrpb(folder: Path, setup: AgentSetup | None = None, *, pairs: int = 5) -> Iterator[Scene]:
    """Yield scenes on each map in a folder and its subfolders: `mrpb_<map>-0`, `mrpb_<map>-1` ...

    Args:
        folder: The clone, or any folder with maps (YAML files that name an image).
        setup: Robot, mission and rules; the Jackal by default.
        pairs: Number of start-goal pairs per map.

    Raises:
        InputError: There is no map, a map is invalid, or it has no room for a scene; with the file.
    """
    files = sorted(file for file in folder.rglob("*.yaml") if "image:" in _text(file))
    if not files:
        hint = "Give your clone of the benchmark, or a folder with a map's .yaml and .pgm."
        raise InputError(Fault("the folder has no map: no .yaml file names an image.", folder, hint=hint))
    for file in files:
        grid = read_map(file)
        ground = ground_of(grid, file)
        seed = hashlib.sha256(file.stem.encode()).digest()
        rng = np.random.default_rng(np.random.SeedSequence(int.from_bytes(seed, "big")))
        for pair in range(pairs):
            ends = sample_ends(grid, rng, APART)
            if ends is None:
                raise InputError(Fault(f"found no start and goal {APART:g} m apart with a path between them.", file))
            name = f"mrpb_{file.stem}-{pair}"
            doc = f"MRPB's map {file.stem}, without a map."
            yield scene_between(name, doc, ground, *ends, setup or AgentSetup())


def _text(file: Path) -> str:
    try:
        return read_text(file)
    except InputError:
        return ""
