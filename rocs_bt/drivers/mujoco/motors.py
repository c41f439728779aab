"""Motors: some of a robot's velocity actuators, and what they are asked for."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field


@dataclass
class Motors:
    """Some motors of one robot: what they are asked for, and how fast they may get there.

    Attributes:
        ids: Their places in MuJoCo's control vector.
        joints: Their joints' places in the velocity vector.
        angles: Their joints' places in the position vector.
        target: Speeds that they are asked for [rad/s].
        change: Greatest change of a speed in one physics step [rad/s].
        settled: Whether all have reached their target.
        delay: How many physics steps later a target holds than it was asked for.
        coming: Targets that do not hold yet, each with the step at which it will.
    """

    ids: list[int]
    joints: list[int]
    angles: list[int]
    target: list[float]
    change: float = math.inf
    settled: bool = True
    delay: int = 0
    coming: deque[tuple[int, Sequence[float]]] = field(default_factory=deque)
