"""Video of a run, rendered off-screen with EGL or OSMesa."""

from __future__ import annotations

import copy
import importlib
import importlib.util
from io import BytesIO
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.errors import Fault, InputError
from ..base.files import check_writable, write_whole
from ..devices.mujoco import MujocoWorld

_DRAWN_GROUPS = 3
"""Number of groups of geoms that MuJoCo draws by default: 0, 1 and 2."""

_SIZES = 8.0  # distance of a camera that follows, in radii of the robot

Frame = npt.NDArray[np.uint8]

_FORMATS = (".mp4", ".gif", ".webp", ".png")
_BACKENDS = ("egl", "osmesa")
_INSTALL = (
    "Install one of them: on Debian and Ubuntu 'apt-get install libegl1 libgl1 libgl1-mesa-dri' or "
    "'apt-get install libosmesa6'. Without it, report.html has the run as an animation."
)


class Video:
    """Renders a world into a file; a context manager and an observer of an episode.

    Args:
        world: World to render.
        file: Output file. `.mp4` needs the extra [video]; `.gif` and `.webp` need no extra; `.png` contains only the
            last frame.
        size: Width and height [pixels]; by default 1280 x 960 for `.mp4`, else 640 x 480.
        rate: Frames per simulated second [1/s].
        follow: Robot that the camera follows; by default it shows the whole world from above.

    Raises:
        UnknownName: The world has no such robot.
        InputError: Unknown format, or the format cannot be written or rendered on this machine; names the package to
            install.
    """

    def __init__(
        self,
        world: MujocoWorld,
        file: Path,
        *,
        size: tuple[int, int] | None = None,
        rate: float = 10.0,
        follow: str = "",
    ) -> None:
        if file.suffix not in _FORMATS:
            raise InputError(
                Fault(f"cannot write a video as '{file.name}'.", hint=f"Its name must end in {', '.join(_FORMATS)}.")
            )
        if file.suffix == ".mp4" and importlib.util.find_spec("imageio_ffmpeg") is None:
            raise InputError(
                Fault("writing .mp4 needs the extra [video].", hint="pip install 'rocs_bt[video]', or write a .gif.")
            )
        if not file.absolute().parent.is_dir():
            raise InputError(Fault(f"there is no folder '{file.parent}' for the video.", hint="Create it first."))
        check_writable(file)
        self._file = file
        self._rate = rate
        self._due = 0.0
        self._camera = _Camera(world, size or ((1280, 960) if file.suffix == ".mp4" else (640, 480)), follow)
        self._frames: list[Any] = []
        self._writer: Any = None

    def __enter__(self) -> Video:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def __call__(self, t: float) -> bool:
        """Render the world at time t [s] if a frame is due; always True, so it never ends the run."""
        if t >= self._due - 1e-9:
            self._due += 1.0 / self._rate
            self._take(self._camera.shoot())
        return True

    def close(self) -> None:
        """Complete the file."""
        self._camera.close()
        if self._writer is not None:
            self._writer.close()
            self._writer = None
        elif self._frames:
            first, *rest = self._frames
            still = self._file.suffix == ".png"
            options = {} if still else {"save_all": True, "append_images": rest, "loop": 0}
            content, self._frames = BytesIO(), []
            first.save(content, self._file.suffix[1:], duration=round(1000.0 / self._rate), **options)
            write_whole(self._file, content.getvalue())

    def _take(self, frame: Frame) -> None:
        if self._file.suffix == ".mp4":
            if self._writer is None:
                imageio = importlib.import_module("imageio.v2")
                self._writer = imageio.get_writer(str(self._file), fps=self._rate, macro_block_size=None)
            self._writer.append_data(frame)
            return
        image = importlib.import_module("PIL.Image").fromarray(frame)
        if self._file.suffix == ".png":
            self._frames = [image]
        else:
            self._frames.append(image.quantize(64) if self._file.suffix == ".gif" else image)


class _Camera:
    """MuJoCo's classic renderer with a separate OpenGL context."""

    def __init__(self, world: MujocoWorld, size: tuple[int, int], follow: str) -> None:
        from ..devices.mujoco.library import mujoco

        body = world.body(follow) if follow else None
        self._mj, self._world, self._size, self._follow = mujoco, world, size, follow
        self._model = as_drawn(world.model)
        self._gl = _context(size)
        self._gl.make_current()
        model = self._model
        model.vis.global_.offwidth = max(int(model.vis.global_.offwidth), size[0])
        model.vis.global_.offheight = max(int(model.vis.global_.offheight), size[1])
        self._scene = mujoco.MjvScene(model, maxgeom=2000)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0  # without shadows rendering is four times as fast
        self._option = mujoco.MjvOption()
        self._option.flags[mujoco.mjtVisFlag.mjVIS_RANGEFINDER] = 0
        self._render = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._render)
        self._view = mujoco.MjvCamera()
        self._view.lookat[:] = model.stat.center
        self._view.distance = 0.85 * model.stat.extent
        self._view.azimuth, self._view.elevation = 90.0, -65.0
        if body is not None:
            self._view.distance, self._view.elevation = max(1.0, _SIZES * body.reach), -30.0

    def shoot(self) -> Frame:
        """Render one frame, shape (height, width, 3)."""
        mj, (width, height) = self._mj, self._size
        with self._world.lock:
            self._world.update_poses()
            if self._follow:
                self._view.lookat[:] = self._world.pose3(self._follow)[:3]
            mj.mjv_updateScene(
                self._model,
                self._world.data,
                self._option,
                None,
                self._view,
                mj.mjtCatBit.mjCAT_ALL,
                self._scene,
            )
        view = mj.MjrRect(0, 0, width, height)
        frame = np.empty((height, width, 3), dtype=np.uint8)
        mj.mjr_render(view, self._scene, self._render)
        mj.mjr_readPixels(frame, None, view, self._render)
        return frame[::-1].copy()

    def close(self) -> None:
        """Free the renderer and its OpenGL context."""
        self._render.free()
        self._gl.free()


def as_drawn(model: Any) -> Any:
    """Copy of a model for drawings: hulls and other geoms that MuJoCo hides are visible only without drawn ones."""
    drawn = copy.copy(model)
    trees, hidden = model.body_rootid[model.geom_bodyid], model.geom_group >= _DRAWN_GROUPS
    bare = hidden & ~np.isin(trees, trees[~hidden])
    drawn.geom_group[bare] = 0
    return drawn


def _context(size: tuple[int, int]) -> Any:
    """Off-screen OpenGL context of the first backend that works; raises InputError."""
    tried = []
    for backend in _BACKENDS:
        try:
            return importlib.import_module(f"mujoco.{backend}").GLContext(*size)
        except Exception as error:  # noqa: BLE001 - the exceptions of OpenGL loaders depend on the platform
            tried.append(f"{backend}: {' '.join(str(error).split())[:120]}")
    raise InputError(
        Fault(f"cannot render a video: no OpenGL backend works on this machine ({'; '.join(tried)}).", hint=_INSTALL)
    )
