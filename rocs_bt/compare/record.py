"""EpisodeRecord: the stored result of one episode."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec
import numpy as np
import numpy.typing as npt

from ..simulation import outcome

__all__ = ["OUTCOMES", "EpisodeRecord", "decode_record", "encode_record"]

OUTCOMES = (*outcome.OUTCOMES, "limit")
"""Outcomes of episodes: those of a run, and `limit` for an episode that the wall limit ended."""


class EpisodeRecord(msgspec.Struct, frozen=True, kw_only=True):
    """Result of one episode. It contains only data that are equal in every repetition, so no computation times.

    Attributes:
        key: sha256 of everything that the episode depends on; equal keys mean equal episodes.
        planner: Name of the planner.
        family: Family of the scene with its given parameters, or name of the scenario.
        scene: Name of the scene; episodes of one scene with different seeds form one cluster in the statistics.
        seed: Seed of the episode; it varies starts, noise and actors, equally for every planner.
        outcome: One of `OUTCOMES`.
        reason: Reason of a failure; empty for success.
        metrics: Values by metric name, as in `METRICS`; None if undefined for this episode.
        sim_time: Simulated time at the end [s].
        time_limit: Time limit of the episode [s].
        difficulty: Difficulty measures of the scene by name.
        track: Positions about every 0.1 m of path length: x and y [m], float32 of shape (n, 2) as bytes.
        content: sha256 of all content that was used.
        trajectory_hash: sha256 of the positions of all bodies in all control periods; empty after an error.
        reproducible: Whether a repetition gives the same result. False if the planner's latency is measured, or if the
            wall limit ended the episode.
    """

    key: str
    planner: str
    family: str
    scene: str
    seed: int
    outcome: str
    reason: str = ""
    metrics: Mapping[str, float | None] = {}
    sim_time: float = 0.0
    time_limit: float = 0.0
    difficulty: Mapping[str, float] = {}
    track: bytes = b""
    content: str = ""
    trajectory_hash: str = ""
    reproducible: bool = True

    @property
    def success(self) -> bool:
        """Whether the outcome is success."""
        return self.outcome == "success"

    @property
    def path(self) -> npt.NDArray[np.float32]:
        """Positions in `track` [m], shape (n, 2)."""
        return np.frombuffer(self.track, dtype=np.float32).reshape(-1, 2)


def encode_record(record: EpisodeRecord) -> bytes:
    """Encode a record as one line of JSON with sorted keys, so that equal records give equal bytes."""
    return msgspec.json.encode(record, order="sorted")


def decode_record(line: bytes | str) -> EpisodeRecord:
    """Decode a record from its line of JSON.

    Raises:
        msgspec.ValidationError: The text is not a record.
    """
    return _DECODER.decode(line)


_DECODER = msgspec.json.Decoder(EpisodeRecord)
