"""Random streams of an episode: one generator for each owner and purpose, so that they are independent."""

from __future__ import annotations

import hashlib
from typing import Final

import numpy as np

START: Final = "start"
"""Purpose: start pose. The purposes seed the random streams, so changing such a string would change all runs."""

NETWORK: Final = "network"
"""Purpose: loss and delay of the simulated network of sharing agents; the owner of this stream is empty."""

GROUND: Final = "ground"
"""Purpose: bumps of rough ground; the owner is the ground."""

CHOICE: Final = "choice"
"""Purpose: the object of a group that follows its script; the owner is the group."""

ODOMETER: Final = "odometer"
"""Purpose: errors of the odometer of the owner, if its pose sensors have one."""


def push_of(number: int) -> str:
    """Purpose: time of one push on the owner, by its number in the scenario from 0."""
    return f"push {number}"


def noise_of(sensor: str) -> str:
    """Purpose: noise of one sensor of the owner."""
    return f"noise of {sensor}"


def loop_of(actuator: str) -> str:
    """Purpose: inner loop of one actuator of the owner."""
    return f"loop of {actuator}"


def stream(scenario: str, seed: int, owner: str, purpose: str) -> np.random.Generator:
    """Generator of one owner and purpose in an episode.

    The stream depends only on the arguments, never on the contents of files. A changed comment or planner therefore
    changes no sample.

    Args:
        scenario: Name of the scenario.
        seed: Seed of the episode.
        owner: Robot, scripted object or agent that samples.
        purpose: `START`, `NETWORK`, `noise_of(...)`, the name of a script, or a name that a mission or planner gives.
    """
    digest = hashlib.sha256("\0".join((scenario, str(seed), owner, purpose)).encode()).digest()
    return np.random.default_rng(np.random.SeedSequence(int.from_bytes(digest, "big")))
