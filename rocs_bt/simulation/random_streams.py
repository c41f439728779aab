"""Random streams of an episode: one generator per owner and purpose, so that samples do not affect each other."""

from __future__ import annotations

import hashlib
from typing import Final

import numpy as np

START: Final = "start"
"""Purpose: start pose. These strings seed every run and are frozen: a changed one changes all runs."""

NETWORK: Final = "network"
"""Purpose: loss and delay of the simulated network of sharing agents; its owner is empty."""


def noise_of(sensor: str) -> str:
    """Purpose: noise of one sensor of the owner."""
    return f"noise of {sensor}"


def stream(scenario: str, seed: int, owner: str, purpose: str) -> np.random.Generator:
    """Generator of one owner and purpose in an episode.

    The seed depends on names only, never on the contents of files: a changed comment or planner changes no sample.

    Args:
        scenario: Name of the scenario.
        seed: Seed of the episode.
        owner: Robot, scripted object or agent that samples.
        purpose: `START`, `NETWORK`, `noise_of(...)`, the name of a script, or a name that a mission or planner gives.
    """
    digest = hashlib.sha256("\0".join((scenario, str(seed), owner, purpose)).encode()).digest()
    return np.random.default_rng(np.random.SeedSequence(int.from_bytes(digest, "big")))
