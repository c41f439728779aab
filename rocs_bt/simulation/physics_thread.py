"""Physics at the pace of the wall clock, in a thread of its own."""

from __future__ import annotations

import threading

from ..clock import WallClock
from ..drivers.mujoco import MujocoWorld
from ..errors import BlockError

_FORGIVE = 0.25  # [s] of delay after which lost time is given up rather than caught up


def run_physics(world: MujocoWorld, clock: WallClock, stop: threading.Event) -> float:
    """Advance a world step by step in real time until `stop` is set.

    Steps that are late are caught up, so that the world stays with the clock; after a long delay, such as a
    suspended process, the lost time is given up instead of being driven in a burst.

    Args:
        world: Composed on the same clock.
        clock: Wall time.
        stop: Ends it.

    Returns:
        The furthest that it fell behind [s].
    """
    due, worst = clock.now(), 0.0
    while clock.wait_until(due, stop):
        world.advance(1)
        late = clock.now() - due
        worst = max(worst, late)
        due = clock.now() if late > _FORGIVE else due + world.step
    return worst


class PhysicsThread:
    """Runs `run_physics` while its context is open; sets `stop` when that fails.

    Attributes:
        worst: The furthest that physics fell behind [s]; known when the context is left.
    """

    def __init__(self, world: MujocoWorld, clock: WallClock, stop: threading.Event) -> None:
        self._world = world
        self._clock = clock
        self._stop = stop
        self._thread = threading.Thread(target=self._run, name="physics", daemon=True)
        self._failure: Exception | None = None
        self.worst = 0.0

    def __enter__(self) -> PhysicsThread:
        self._thread.start()
        return self

    def __exit__(self, *exc: object) -> None:
        self._stop.set()
        self._thread.join()

    def raise_failure(self) -> None:
        """Tell that physics failed.

        Raises:
            BlockError: It did.
        """
        if self._failure is not None:
            raise BlockError("physics", "raised", str(self._failure)) from self._failure

    def _run(self) -> None:
        try:
            self.worst = run_physics(self._world, self._clock, self._stop)
        except Exception as error:  # noqa: BLE001 - the thread's boundary: kept, and raised by who waits for it
            self._failure = error
            self._stop.set()
