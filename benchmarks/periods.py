"""CPU time of an episode's loop, told apart from what else the machine did meanwhile.

A run repeats to the bit, so the same period of the same seed is the same work each time. A shared machine stops for
tenths of a second here and there, and charges that to whoever ran; it seldom does so in the same period twice. The
loop's time is therefore the sum, over its periods, of each period's median over several plays. What belongs to a
period falls into it in each play.
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
    """CPU time of each period [s], by index, over `PLAYS` plays.

    Args:
        play: Plays the loop once, calls what it is given at each period with the simulated time, and returns the
            trajectory's hash.

    Raises:
        RuntimeError: Two plays came to different trajectories: they were not the same work.
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
        raise RuntimeError("Plays of one seed came to different trajectories; their times mean nothing.")
    return [statistics.median(same) for same in zip(*plays, strict=True)]
