"""Viewer and video: what cannot be shown or written here is told, with what to do."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from rocs_bt.base.errors import InputError, UnknownName
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog, ScenarioSpec
from rocs_bt.devices.mujoco import MujocoWorld
from rocs_bt.event import NullSink
from rocs_bt.running import RunOptions
from rocs_bt.simulation import build_world
from rocs_bt.simulation.video import Video, as_drawn
from rocs_bt.simulation.viewer import Viewer

from .. import needs

SHIPPED = Path(__file__).parents[2] / "robots"


@pytest.fixture(scope="module")
def world(exp1: ScenarioSpec, catalog: Catalog) -> MujocoWorld:
    return build_world(exp1, catalog, 1, NullSink()).world


@needs.linux("can be without a display")
def test_a_viewer_without_a_display_is_told(world: MujocoWorld, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(InputError, match=r"no display.*report\.html"):
        Viewer(world)


def test_an_unknown_video_format_lists_those_there_are(world: MujocoWorld, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"'run\.avi'.*must end in \.mp4, \.gif, \.webp, \.png"):
        Video(world, tmp_path / "run.avi")


def test_mp4_without_its_extra_says_what_to_install(
    world: MujocoWorld, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"needs the extra \[video\].*pip install"):
        Video(world, tmp_path / "run.mp4")


def test_no_opengl_says_what_to_install(world: MujocoWorld, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rocs_bt.simulation.video._BACKENDS", ("nowhere",))
    with pytest.raises(
        InputError, match=r"no OpenGL backend works on this machine \(nowhere: .*apt-get install libegl1"
    ):
        Video(world, tmp_path / "run.gif")


@pytest.mark.parametrize("suffix", [".gif", ".webp", ".png"])
def test_a_video_shows_the_world(world: MujocoWorld, tmp_path: Path, suffix: str) -> None:
    from PIL import Image

    file = tmp_path / f"run{suffix}"
    with needs.opengl():
        video = Video(world, file, size=(160, 120), rate=10.0)
    with video:
        for i in range(9):  # 20 looks a second, ten frames a second
            world.place("R1", Pose2(1.0, -1.0, 0.3 * i))  # so that no two frames are the same
            assert video(0.05 * i)
    with Image.open(file) as image:
        assert image.size == (160, 120)
        assert getattr(image, "n_frames", 1) == (1 if suffix == ".png" else 5)
        assert len(image.convert("RGB").getcolors(160 * 120)) > 5


def red_in_the_middle(file: Path) -> int:
    """Number of red pixels, of the body of a Pioneer, in the middle of an image."""
    from PIL import Image

    with Image.open(file) as image:
        wide, high = image.size
        middle = image.convert("RGB").crop((3 * wide // 8, 3 * high // 8, 5 * wide // 8, 5 * high // 8))
        pixels = np.asarray(middle).reshape(-1, 3).astype(int)
    return int(((pixels[:, 0] > 80) & (pixels[:, 1:].max(axis=1) < 60)).sum())


def test_the_camera_follows_a_robot(world: MujocoWorld, tmp_path: Path) -> None:
    with needs.opengl():
        for number, pose in enumerate((Pose2(1.2, -1.2, 0.5), Pose2(-1.2, 1.2, 2.0))):
            world.place("R2", pose)
            for follow in ("R2", ""):
                with Video(world, tmp_path / f"{number}{follow}.png", size=(160, 120), follow=follow) as video:
                    video(0.0)
    seen = {file.stem: red_in_the_middle(file) for file in tmp_path.iterdir()}
    assert min(seen["0R2"], seen["1R2"]) > 20
    assert max(seen["0"], seen["1"]) < 10
    with pytest.raises(UnknownName, match="no robot is named 'R9'"):
        Video(world, tmp_path / "x.png", follow="R9")
    with pytest.raises(InputError, match=r"needs a video: name its file with --video FILE"):
        RunOptions(follow="R2")


@pytest.mark.parametrize("file", sorted(SHIPPED.glob("*/robot.xml")), ids=lambda file: file.parent.name)
def test_each_shipped_body_is_drawn_in_its_own_shape(file: Path) -> None:
    """What is drawn of a body spans its hull, and no hull covers it."""
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    drawn = np.flatnonzero(as_drawn(model).geom_group < 3)
    assert not np.any(model.geom_group[drawn] >= 3)
    hull = [g for g in range(model.ngeom) if model.geom(g).name == "hull"]
    spans = []
    for geoms in (drawn, hull or drawn):
        turns, half = data.geom_xmat[geoms].reshape(-1, 3, 3), model.geom_aabb[geoms, 3:]
        reach = np.einsum("nij,nj->ni", np.abs(turns), half)
        spans.append(((data.geom_xpos[geoms] + reach).max(axis=0) - (data.geom_xpos[geoms] - reach).min(axis=0))[:2])
    assert np.all(spans[0] > 0.6 * spans[1])


def test_a_body_without_drawn_geoms_is_drawn_by_its_hull() -> None:
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody>"
        "<body><freejoint/><geom size='1' group='3'/><body><geom size='1' group='4'/></body></body>"
        "<body><freejoint/><geom size='1' group='3'/><body><geom size='1' group='1'/></body></body>"
        "</worldbody></mujoco>"
    )
    assert (as_drawn(model).geom_group < 3).tolist() == [True, True, False, True]
    assert model.geom_group.tolist() == [3, 4, 3, 1]
