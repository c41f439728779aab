"""Reading other benchmarks' files: small ones made here, and what is broken in them is told, never raised otherwise."""

from __future__ import annotations

import itertools
import math
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image

from rocs_bt import Catalog, run
from rocs_bt.base.errors import InputError
from rocs_bt.check import check_content
from rocs_bt.cli.main import call
from rocs_bt.compare import Block, Floor, Post, SweepOptions, sweep
from rocs_bt.compare.family import AgentSetup
from rocs_bt.compare.metric import barn_score
from rocs_bt.search.imports.barn import read_barn, read_world
from rocs_bt.search.imports.maps import read_map, read_maps, read_pgm, read_png

CYLINDER = """<model name='{0}'><pose>{1} {2} 0 0 0 0</pose><static>1</static><link name='link'><collision name='c'>
<geometry><cylinder><radius>0.075</radius><length>1</length></cylinder></geometry></collision></link></model>"""
WORLD = """<sdf version='1.6'><world name='default'><model name='ground_plane'><link name='link'><collision name='c'>
<geometry><plane><normal>0 0 1</normal></plane></geometry></collision></link></model>
{0}<state world_name='default'>{0}</state></world></sdf>"""
_IMAGE = BytesIO()
Image.fromarray(np.arange(12, dtype=np.uint8).reshape(3, 4)).save(_IMAGE, "png")
PNG = _IMAGE.getvalue()
POSTS = [(-4.0, 6.0), (-1.5, 7.25), (-2.9, 8.0)]


def clone(folder: Path, worlds: int = 2) -> Path:
    """A clone as the challenge lays it out, with a few cylinders."""
    place = folder / "jackal_helper" / "worlds" / "BARN"
    (place / "path_files").mkdir(parents=True)
    for i in range(worlds):
        models = "".join(CYLINDER.format(f"unit_cylinder_{k}", x, y) for k, (x, y) in enumerate(POSTS[: i + 2]))
        (place / f"world_{i}.world").write_text(WORLD.format(models))
        np.save(place / "path_files" / f"path_{i}.npy", np.array([[15, 0], [15, 10], [16, 29]]))
    (place / "world_odd.world").write_text("no world of the challenge")
    return folder


def test_barn_is_read_as_the_challenge_plays_it(tmp_path: Path) -> None:
    made = list(read_barn(clone(tmp_path / "clone")))
    assert [scene.name for scene in made] == ["barn-0", "barn-1"]
    floor = made[1].floor
    assert [(p.x, p.y, p.radius, p.height) for p in floor.obstacles] == [(x, y, 0.075, 1.0) for x, y in POSTS]
    assert made[1].reference[0] == (-2.25, 3.0)
    assert made[1].reference[-1] == (-2.25, 13.0)
    assert made[1].reference[1] == pytest.approx((0.15 * 15 - 4.575, 5.075))
    assert made[1].reference_length == pytest.approx(sum(map(math.dist, made[1].reference, made[1].reference[1:])))
    assert made[1].difficulty["cylinders"] == 3.0
    inner = read_barn(tmp_path / "clone" / "jackal_helper" / "worlds" / "BARN")
    assert [scene.world for scene in inner] == [scene.world for scene in made]


def test_barn_scenes_check_and_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    clone(tmp_path / "clone")
    assert call(["import", "barn", str(tmp_path / "clone"), "--out", str(tmp_path / "mine"), "--limit", "1"]) == 0
    assert "1 scenario: barn-0." in capsys.readouterr().out
    found = check_content([tmp_path / "mine"])
    assert not found.faults, found.faults
    catalog = Catalog(tmp_path / "mine")
    summary = run(catalog.load_scenario("barn-0"), catalog, seed=1, duration=0.5, report=False).summary
    assert summary.agents["R"].outcome == "timeout"


def test_an_imported_scene_is_scored_by_its_own_shortest_way(tmp_path: Path) -> None:
    scene = next(iter(read_barn(clone(tmp_path / "clone"))))
    scene.write(tmp_path / "mine")
    (agent,) = Catalog(tmp_path / "mine").load_scenario("barn-0").agents
    assert agent.success.shortest_path == pytest.approx(scene.reference_length, abs=1e-4)
    (record,) = sweep(
        ["tree"], ["barn-0"], seeds=[1], catalog=Catalog(tmp_path / "mine"), options=SweepOptions(workers=1)
    ).records()
    assert record.outcome == "success"
    assert record.metrics["spl"] == pytest.approx(
        agent.success.shortest_path / max(record.metrics["path_length"], agent.success.shortest_path)
    )
    assert record.metrics["barn2024"] == pytest.approx(
        barn_score(record.metrics["time"], agent.success.shortest_path, low=2.0, high=8.0)
    )


def test_poses_of_model_link_and_collision_are_put_together(tmp_path: Path) -> None:
    file = tmp_path / "w.world"
    file.write_text(
        "<world><model name='m'><pose>1 2 0 0 0 1.5707963267948966</pose><link name='l'><pose>1 0 0 0 0 0</pose>"
        "<collision name='c'><pose>0 1 0 0 0 0.5</pose><geometry><box><size>1 2 3</size></box></geometry></collision>"
        "</link></model></world>"
    )
    (box,) = read_world(file)
    assert isinstance(box, Block)
    assert (box.x, box.y, box.yaw) == pytest.approx((0.0, 3.0, math.pi / 2.0 + 0.5))
    assert (box.length, box.width, box.height) == (1.0, 2.0, 3.0)


@pytest.mark.parametrize(
    "cells", [np.zeros((3, 3)), np.zeros((0, 2)), np.array([[np.nan, 1.0]]), np.array([["a", "b"]]), np.array(1.0)]
)
def test_what_is_wrong_with_a_reference_way_is_told(tmp_path: Path, cells: object) -> None:
    clone(tmp_path, worlds=1)
    file = tmp_path / "jackal_helper" / "worlds" / "BARN" / "path_files" / "path_0.npy"
    np.save(file, np.asarray(cells))
    with pytest.raises(InputError, match="reference path"):
        list(read_barn(tmp_path))
    for data in (b"", b"\x93NUMPY junk", b"no array"):
        file.write_bytes(data)
        with pytest.raises(InputError, match="cannot read the reference path"):
            list(read_barn(tmp_path))
    file.unlink()
    with pytest.raises(InputError, match="cannot read the reference path"):
        list(read_barn(tmp_path))


ROOM = np.full((60, 80), 254)
ROOM[[0, -1], :] = ROOM[:, [0, -1]] = 0
ROOM[20:40, 40] = 0
YAML = """image: {0}.pgm
resolution: 0.1  # [m]
origin: [-1.0, -2.0, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.2
"""


def save_map(folder: Path, name: str = "office01", kind: str = "P5", text: str = YAML) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    header = f"{kind}\n# made here\n{ROOM.shape[1]} {ROOM.shape[0]}\n255\n".encode()
    body = ROOM.astype(np.uint8).tobytes() if kind == "P5" else " ".join(map(str, ROOM.ravel())).encode()
    (folder / f"{name}.pgm").write_bytes(header + body)
    (folder / f"{name}.yaml").write_text(text.format(name))
    return folder / f"{name}.yaml"


@pytest.mark.parametrize("kind", ["P5", "P2"])
def test_a_map_is_read_with_its_place(tmp_path: Path, kind: str) -> None:
    made = read_map(save_map(tmp_path, kind=kind))
    for grid in (made.walls, made.barred):
        assert (grid.cell, grid.low, grid.occupied.shape) == (0.1, (-1.0, -2.0), (60, 80))
        assert (grid.occupied == (ROOM == 0)[::-1]).all()
    negated = read_map(save_map(tmp_path, text=YAML.replace("negate: 0", "negate: 1")))
    assert (negated.walls.occupied == ~made.walls.occupied).all()


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data(), st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.booleans())
def test_cells_are_what_map_server_makes_of_their_shades(
    tmp_path: Path, data: st.DataObject, one: float, other: float, negate: bool
) -> None:
    """Occupied above one threshold, free below the other, else unknown, as the shade of the unknown in saved maps."""
    free, occupied = sorted((one, other))
    shades = data.draw(st.lists(st.integers(0, 255), min_size=4, max_size=4))
    (tmp_path / "m.pgm").write_text(f"P2 4 1 255 {' '.join(map(str, shades))}")
    (tmp_path / "m.yaml").write_text(
        f"image: m.pgm\nresolution: 1\norigin: [0, 0, 0]\nnegate: {int(negate)}\n"
        f"occupied_thresh: {occupied!r}\nfree_thresh: {free!r}\n"
    )
    made = read_map(tmp_path / "m.yaml")
    for i, x in enumerate(shades):
        p = x / 255.0 if negate else (255 - x) / 255.0
        if min(abs(p - occupied), abs(p - free)) < 1e-9:
            continue
        assert made.walls.occupied[0, i] == (p > occupied)
        assert made.barred.occupied[0, i] == (not p < free or (x == 205 and not negate))


def test_a_robot_is_sent_over_free_cells_only(tmp_path: Path) -> None:
    """As in the maps that SLAM saves: most of the picture is unknown, and its free_thresh lies above that shade."""
    file = save_map(tmp_path)
    picture = np.full((200, 240), 205)
    picture[30:90, 100:180] = ROOM
    (tmp_path / "office01.pgm").write_bytes(b"P5 240 200 255\n" + picture.astype(np.uint8).tobytes())
    file.write_text(file.read_text().replace("free_thresh: 0.2", "free_thresh: 0.25"))
    free = picture[::-1] == 254
    for scene in read_maps(file, pairs=4):
        for (x0, y0), (x1, y1) in itertools.pairwise(scene.reference):
            for t in np.linspace(0.0, 1.0, 50):
                x, y = x0 + t * (x1 - x0), y0 + t * (y1 - y0)
                assert free[int((y + 2.0) / 0.1), int((x + 1.0) / 0.1)]


def test_the_list_of_an_origin_may_be_written_in_lines(tmp_path: Path) -> None:
    for origin in ("\n- -1.0\n- -2.0\n- 0.0", "\n  - -1.0\n  - -2.0\n  - 0.0  # none", " [-1.0,\n  -2.0, 0.0]"):
        text = YAML.replace(" [-1.0, -2.0, 0.0]", origin)
        assert read_map(save_map(tmp_path, text=text)).walls.low == (-1.0, -2.0)


def test_maps_become_scenes_that_check(tmp_path: Path) -> None:
    file = save_map(tmp_path / "clone" / "maps")
    (tmp_path / "clone" / "params.yaml").write_text("speed: 1\n")
    made = list(read_maps(tmp_path / "clone", pairs=2))
    assert [scene.name for scene in made] == ["map_office01-0", "map_office01-1"]
    assert [s.scenario for s in read_maps(file, pairs=2)] == [s.scenario for s in made]
    for scene in made:
        assert math.dist(scene.reference[0], scene.reference[-1]) >= 4.0
        scene.write(tmp_path / "mine")
    found = check_content([tmp_path / "mine"])
    assert not found.faults, found.faults


@pytest.mark.parametrize("mode", ["L", "1", "P", "RGB", "RGBA", "LA"])
def test_a_png_is_the_same_map_as_its_graymap(tmp_path: Path, mode: str) -> None:
    gray = read_map(save_map(tmp_path))
    (tmp_path / "office01.yaml").write_text(YAML.format("office01").replace(".pgm", ".png"))
    Image.fromarray(ROOM.astype(np.uint8)).convert(mode).save(tmp_path / "office01.png")
    assert (read_map(tmp_path / "office01.yaml").walls.occupied == gray.walls.occupied).all()


@pytest.mark.parametrize("data", [b"", b"P5 1 1 255 x", PNG[:24], PNG[:40], PNG[:16] + b"\xff" * 8 + PNG[24:]])
def test_a_file_that_is_no_whole_png_is_told(tmp_path: Path, data: bytes) -> None:
    with pytest.raises(InputError, match=r"cannot import an image of|the image is damaged"):
        read_png(data, tmp_path / "m.png")


def broken(data: bytes) -> st.SearchStrategy[bytes]:
    """A file with a piece cut out, doubled, or overwritten."""
    spots = st.integers(0, len(data))
    return st.builds(
        lambda a, b, middle: data[: min(a, b)] + middle + data[max(a, b) :], spots, spots, st.binary(max_size=12)
    )


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    world=broken(WORLD.format(CYLINDER.format("a", 1, 2)).encode()),
    png=broken(PNG),
    yaml=broken(YAML.format("m").encode()),
    picture=broken(b"P5 4 3 255\n" + bytes(range(12))),
)
def test_broken_files_are_told_or_read(tmp_path: Path, world: bytes, png: bytes, yaml: bytes, picture: bytes) -> None:
    for name, data, reader in (
        ("w.world", world, read_world),
        ("m.png", png, lambda file: read_png(png, file)),
        ("m.pgm", picture, lambda file: read_pgm(picture, file)),
        ("m.yaml", yaml, read_map),
    ):
        file = tmp_path / name
        file.write_bytes(data)
        try:
            reader(file)
        except InputError as error:
            assert error.faults[0].file is not None
            assert len(str(error)) < 1000


@settings(max_examples=60, deadline=None)
@given(st.data(), st.integers(1, 12), st.integers(1, 12))
def test_the_boxes_of_a_grid_are_its_taken_cells(data: st.DataObject, rows: int, columns: int) -> None:
    line = st.lists(st.booleans(), min_size=columns, max_size=columns)
    taken = np.array(data.draw(st.lists(line, min_size=rows, max_size=rows)))
    grid = Floor((1.0, -2.0), (1.0 + 0.5 * columns, -2.0 + 0.5 * rows)).grid(0.5)
    grid.occupied[:] = taken
    blocks = grid.blocks()
    again = Floor(grid.low, (1.0 + 0.5 * columns, -2.0 + 0.5 * rows), blocks).grid(0.5)
    assert (again.occupied == taken).all()
    assert all(isinstance(b, Block) for b in blocks)
    assert sum(b.length * b.width for b in blocks if isinstance(b, Block)) == pytest.approx(0.25 * taken.sum())


def test_who_drives_is_the_users_choice(tmp_path: Path) -> None:
    (scene, _) = read_barn(clone(tmp_path), AgentSetup(robot="pioneer_p3dx", rules=""))
    assert 'robot = "pioneer_p3dx"' in scene.toml
    assert "rules = []" in scene.toml
    assert isinstance(scene.floor.obstacles[0], Post)
