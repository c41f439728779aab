"""MRPB: the maps of a user's own clone of the local planning benchmark (Wen et al., MRPB 1.0, ICRA 2021).

A map has no starts and no goals; they are drawn, from the map's name alone, so that everybody gets the same.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...errors import Fault, InputError
from ..family import AgentSetup, Scene
from .map_scenes import ground_of, sample_ends, scene_between
from .raster import read_map

APART = 4.0
"""Between start and goal at least [m]."""


def read_mrpb(folder: Path, setup: AgentSetup | None = None, *, pairs: int = 5) -> Iterator[Scene]:
    """Scenes on each map below a folder: `mrpb_<map>-0`, `mrpb_<map>-1` ...

    Args:
        folder: The clone, or any folder with maps: YAML files that name a picture.
        setup: Robot, mission and rules; the Jackal by default.
        pairs: Starts and goals for each map.

    Raises:
        InputError: There is no map, one cannot be read, or there is no room on it; with the file.
    """
    files = sorted(file for file in folder.rglob("*.yaml") if "image:" in _text(file))
    if not files:
        hint = "Give your clone of the benchmark, or a folder with a map's .yaml and .pgm."
        raise InputError(Fault("there is no map in it: no .yaml that names an image.", folder, hint=hint))
    for file in files:
        grid = read_map(file)
        ground = ground_of(grid, file)
        seed = hashlib.sha256(file.stem.encode()).digest()
        rng = np.random.default_rng(np.random.SeedSequence(int.from_bytes(seed, "big")))
        for pair in range(pairs):
            ends = sample_ends(grid, rng, APART)
            if ends is None:
                raise InputError(
                    Fault(f"no start and goal {APART:g} m apart have a way between them on this map.", file)
                )
            name = f"mrpb_{file.stem}-{pair}"
            doc = f"On the map {file.stem} of MRPB, without knowing it."
            yield scene_between(name, doc, ground, *ends, setup or AgentSetup())


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return ""
