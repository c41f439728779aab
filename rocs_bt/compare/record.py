"""EpisodeRecord: the stored result of one episode."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec
import numpy as np
import numpy.typing as npt

from ..simulation.outcome import OUTCOMES

__all__ = ["OUTCOMES", "EpisodeRecord", "decode_record", "encode_record"]


class EpisodeRecord(msgspec.Struct, frozen=True, kw_only=True):
    """Result of one episode. Contains only data that repeat bit by bit; the store keeps wall and CPU time separately.

    Attributes:
        key: sha256 of everything that the episode depends on; equal keys mean equal episodes.
        planner: Name of the planner.
        family: Family of the scene, or the name of the scenario.
        scene: Name of the scene; its seeds form one cluster.
        seed: Seed of the episode; varies starts, noise and movers in the same way for every planner.
        outcome: One of `OUTCOMES`.
        reason: Reason of a failure; empty for success.
        metrics: Values by metric name, as in `METRICS`; None if undefined for this episode.
        sim_time: Simulated time at the end [s].
        time_limit: Time limit of the episode [s].
        difficulty: Difficulty measures of the scene by name.
        track: Positions about every 0.1 m of path length: (n, 2) float32 x, y [m] as bytes.
        content: sha256 of all content used.
        trajectory_hash: sha256 of all positions at control periods; empty after an error.
        reproducible: Whether a repetition gives the same result. False if a planner's latency is measured, or after a
            wall limit.
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
        """Positions of the track [m], shape (n, 2)."""
        return np.frombuffer(self.track, dtype=np.float32).reshape(-1, 2)


def encode_record(record: EpisodeRecord) -> bytes:
    """Record as one line of JSON with sorted keys: equal records give equal bytes."""
    return msgspec.json.encode(record, order="sorted")


def decode_record(line: bytes | str) -> EpisodeRecord:
    """Record from its JSON.

    Raises:
        msgspec.ValidationError: The text is not a record.
    """
    return _DECODER.decode(line)


_DECODER = msgspec.json.Decoder(EpisodeRecord)
