"""Real-time physics in a separate thread."""

from __future__ import annotations

import threading

from ..base.clock import WallClock
from ..base.errors import BlockError
from ..devices.mujoco import MujocoWorld

_FORGIVE = 0.25  # [s] delay above which physics skips the lost time instead of catching up


def run_physics(world: MujocoWorld, clock: WallClock, stop: threading.Event) -> None:
    """Advance a world step by step in real time until `stop` is set.

    After a short delay, steps follow without a pause until the world has caught up with the clock. After a delay of
    more than 0.25 s, for example of a suspended process, the lost time is skipped.

    Args:
        world: World on the same clock.
        clock: Wall clock.
        stop: Event that ends the loop.
    """
    due = clock.now()
    while clock.wait_until(due, stop):
        world.advance(1)
        late = clock.now() - due
        due = clock.now() if late > _FORGIVE else due + world.step


class PhysicsThread:
    """Runs `run_physics` in a thread while its context is open; sets `stop` if it fails."""

    def __init__(self, world: MujocoWorld, clock: WallClock, stop: threading.Event) -> None:
        self._world = world
        self._clock = clock
        self._stop = stop
        self._thread = threading.Thread(target=self._run, name="physics", daemon=True)
        self._failure: Exception | None = None

    def __enter__(self) -> PhysicsThread:
        self._thread.start()
        return self

    def __exit__(self, *exc: object) -> None:
        self._stop.set()
        self._thread.join()

    def raise_failure(self) -> None:
        """Raise the failure of physics, if there was one.

        Raises:
            BlockError: Physics failed.
        """
        if isinstance(self._failure, BlockError):
            raise self._failure
        if self._failure is not None:
            raise BlockError("physics", "raised", str(self._failure)) from self._failure

    def _run(self) -> None:
        try:
            run_physics(self._world, self._clock, self._stop)
        except Exception as error:  # noqa: BLE001 - thread boundary: `raise_failure` raises it
            self._failure = error
            self._stop.set()
