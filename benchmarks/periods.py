"""CPU time of an episode's loop, separated from disturbances of the machine.

A run repeats bit by bit, so the same period of the same seed is the same work each time. A shared machine pauses for
tenths of a second now and then and charges that time to the running process, but rarely in the same period twice. The
loop's time is therefore the sum, over its periods, of each period's median over several plays.
"""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable
from itertools import pairwise

from row import size

PLAYS = size(5, 2)


def clocked(play: Callable[[Callable[[float], None]], str]) -> list[float]:
    """CPU time of each period [s], by index, from `PLAYS` plays.

    Args:
        play: Function that plays the loop once, calls its argument at each period with the simulated time, and returns
            the trajectory's hash.

    Raises:
        RuntimeError: Two plays gave different trajectories, so they were not the same work.
    """
    plays, hashes = [], set()
    for _ in range(PLAYS):
        ticks: list[float] = []

        def tick(_: float, ticks: list[float] = ticks) -> None:
            ticks.append(time.process_time())

        gc.collect()
        hashes.add(play(tick))
        plays.append([after - before for before, after in pairwise(ticks)])
    if len(hashes) > 1:
        raise RuntimeError("Plays of one seed gave different trajectories, so their times are not comparable.")
    return [statistics.median(same) for same in zip(*plays, strict=True)]
