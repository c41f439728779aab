"""Run display in MuJoCo's viewer."""

from __future__ import annotations

import importlib
import os
import sys
from types import TracebackType

from ..base.errors import Fault, InputError
from ..devices.mujoco import MujocoWorld
from .pace import Pace


class Viewer:
    """MuJoCo's passive viewer of a world; a context manager and an observer of an episode.

    In lockstep it also slows the run down to real time, so that a person can watch it.

    Raises:
        InputError: The machine has no display, or MuJoCo's viewer does not start.
    """

    def __init__(self, world: MujocoWorld) -> None:
        if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            raise InputError(
                Fault(
                    "cannot show the viewer: this machine has no display (DISPLAY and WAYLAND_DISPLAY are unset).",
                    hint="Use the animation in report.html, or render a video with --video FILE.",
                )
            )
        viewer = importlib.import_module("mujoco.viewer")
        try:
            self._handle = viewer.launch_passive(world.model, world.data, show_left_ui=False, show_right_ui=False)
        except (RuntimeError, ImportError, OSError) as error:
            raise InputError(Fault(f"the viewer does not start: {error}.", hint="See 'rocs-bt doctor'.")) from error
        self._world = world
        self._pace = Pace()

    def __enter__(self) -> Viewer:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._handle.close()

    def __call__(self, t: float) -> bool:
        """Show the world at time t [s], not before the wall clock has reached it; False if the window was closed."""
        going = self.show()
        self._pace(t)
        return going

    def show(self) -> bool:
        """Show the present state of the world; False if the window was closed."""
        with self._world.lock:
            self._world.update_poses()
            self._handle.sync()
        return bool(self._handle.is_running())
