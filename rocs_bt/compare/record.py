"""EpisodeRecord: what is kept of one episode of one planner in one scene."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec
import numpy as np
import numpy.typing as npt

from ..simulation.outcome import OUTCOMES

__all__ = ["OUTCOMES", "EpisodeRecord", "decode_record", "encode_record"]


class EpisodeRecord(msgspec.Struct, frozen=True, kw_only=True):
    """One episode. It holds what repeats to the bit; wall time and CPU time are kept beside it, by the store.

    Attributes:
        key: sha256 of all that the episode depends on; the same key is the same episode.
        planner: The planner's name.
        family: The family of the scene; the scenario's name for one that was written by hand.
        scene: The scene's name: the cluster that its seeds belong to.
        seed: The episode's seed. It moves starts, noise and movers, alike for every planner.
        outcome: Exactly one of `OUTCOMES`.
        reason: Why not success; empty for success.
        metrics: By name, as in `METRICS`; None where the episode says nothing of it.
        sim_time: When it ended [s], on the clock that starts at 0.
        time_limit: When it would have been ended [s].
        difficulty: The scene's, by measure.
        track: Where the robot was about every 0.1 m of its way: (n, 2) float32 x, y [m] as bytes.
        content: sha256 of all content used.
        trajectory_hash: sha256 of all positions at control periods; empty where the episode broke down.
        reproducible: Whether another run gives the same; not so where a planner's latency is measured or a wall limit
            struck.
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
        """Whether it succeeded."""
        return self.outcome == "success"

    @property
    def path(self) -> npt.NDArray[np.float32]:
        """(n, 2) The track [m]."""
        return np.frombuffer(self.track, dtype=np.float32).reshape(-1, 2)


def encode_record(record: EpisodeRecord) -> bytes:
    """A record as one line of JSON, keys sorted: equal records give equal bytes."""
    return msgspec.json.encode(record, order="sorted")


def decode_record(line: bytes | str) -> EpisodeRecord:
    """A record from its JSON.

    Raises:
        msgspec.ValidationError: It is none.
    """
    return _DECODER.decode(line)


_DECODER = msgspec.json.Decoder(EpisodeRecord)
