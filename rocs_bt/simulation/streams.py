"""Random streams: one for each who and what for, so that nothing disturbs anything else (docs/architecture.md)."""

from __future__ import annotations

import hashlib

import numpy as np

from ..catalog import ScenarioSpec, content_hash, make_entry


def scenario_content(scenario: ScenarioSpec) -> str:
    """The hash that keys a scenario's streams: of its files alone, so that who plans in it changes no draw."""
    return content_hash(make_entry(file, "scenario", "file") for file in (scenario.file, *scenario.bases))


def stream(content: str, seed: int, who: str, what: str) -> np.random.Generator:
    """A generator of its own.

    Args:
        content: A hash of the scenario's content: another scenario draws other numbers.
        seed: The episode's seed.
        who: The robot or device that draws.
        what: What it draws for, such as `start`.
    """
    digest = hashlib.sha256("\0".join((content, str(seed), who, what)).encode()).digest()
    return np.random.default_rng(np.random.SeedSequence(int.from_bytes(digest, "big")))
