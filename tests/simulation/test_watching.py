"""Viewer and video: what cannot be shown or written here is told, with what to do."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from rocs_bt.catalog import Catalog, ScenarioSpec
from rocs_bt.drivers.mujoco import MujocoWorld
from rocs_bt.errors import InputError
from rocs_bt.event import NullSink
from rocs_bt.geometry import Pose2
from rocs_bt.simulation import build_world
from rocs_bt.simulation.video import Video
from rocs_bt.simulation.viewer import Viewer


@pytest.fixture(scope="module")
def world(exp1: ScenarioSpec, catalog: Catalog) -> MujocoWorld:
    return build_world(exp1, catalog, 1, NullSink()).world


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="other systems always have a display")
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
    try:
        video = Video(world, file, size=(160, 120), rate=10.0)
    except InputError as error:
        pytest.skip(f"no video can be made here: {error}")
    with video:
        for i in range(9):  # 20 looks a second, ten frames a second
            world.place("R1", Pose2(1.0, -1.0, 0.3 * i))  # so that no two frames are the same
            assert video(0.05 * i)
    with Image.open(file) as image:
        assert image.size == (160, 120)
        assert getattr(image, "n_frames", 1) == (1 if suffix == ".png" else 5)
        assert len(image.convert("RGB").getcolors(160 * 120)) > 5
