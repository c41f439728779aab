"""MJCF that asks for too much is refused before MuJoCo compiles it; what a robot's world needs is not."""

from __future__ import annotations

import zlib
from pathlib import Path

import mujoco
import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.catalog import shipped_root
from rocs_bt.check import check_content
from rocs_bt.devices.mujoco import compose_world, mjcf
from rocs_bt.devices.mujoco.mjcf import examine_model

BALL = '<geom size="0.1"/>'


def png(width: int, height: int) -> bytes:
    """A picture's head, which claims to have this size."""
    head = b"IHDR" + width.to_bytes(4, "big") + height.to_bytes(4, "big") + b"\x08\x02\0\0\0"
    return b"\x89PNG\r\n\x1a\n" + (13).to_bytes(4, "big") + head + zlib.crc32(head).to_bytes(4, "big")


def write(folder: Path, text: str) -> Path:
    (folder / "big.png").write_bytes(png(60_000, 60_000))
    (folder / "balls.xml").write_text(f"<mujoco><worldbody>{BALL * 500}</worldbody></mujoco>")
    (folder / "ball.xml").write_text(f"<mujoco>{BALL}</mujoco>")
    for i in range(5):  # each attaches the next ten times
        inner = "".join(f'<attach model="m" prefix="{j}/"/>' for j in range(10)) if i < 4 else BALL
        asset = f'<asset><model name="m" file="chain{i + 1}.xml"/></asset>' if i < 4 else ""
        (folder / f"chain{i}.xml").write_text(f"<mujoco>{asset}<worldbody>{inner}</worldbody></mujoco>")
    (folder / "loop.xml").write_text('<mujoco><asset><model name="m" file="loop.xml"/></asset></mujoco>')
    file = folder / "world.xml"
    file.write_text(f"<mujoco>\n{text}\n</mujoco>")
    return file


def world(text: str) -> str:
    return f"<worldbody>{text}</worldbody>"


TOO_MUCH = {
    "copies": (world(f'<replicate count="100000">{BALL}</replicate>'), "100000 elements from replicate"),
    "copies of copies": (
        world(f'<replicate count="100"><replicate count="100">{BALL}</replicate></replicate>'),
        "10100 elements from replicate",
    ),
    "copies without end": (world(f'<replicate count="1e300">{BALL}</replicate>'), "elements"),
    "copies of an include": (
        world('<replicate count="5000"><include file="ball.xml"/></replicate>'),
        "elements from replicate",
    ),
    "attached": ('<asset><model name="m" file="chain0.xml"/></asset>' + world('<attach model="m"/>'), "elements"),
    "attaches itself": ('<asset><model name="m" file="loop.xml"/></asset>', "'loop.xml' attaches itself"),
    "flex": (world('<flexcomp name="f" type="grid" count="100 100 1"/>'), "10000 elements from replicate"),
    "flex by default": (world('<replicate count="9"><flexcomp name="f"/></replicate>'), "elements from replicate"),
    "elements": (world(BALL * 20_001), "the model has 20001 elements or more; the maximum is 20000"),
    "joints": (world("<body><freejoint/></body>" * 4_001), "the model has 4001 joints or more; the maximum is 4000"),
    "depth": (world("<body>" * 600 + "</body>" * 600), "nested more than 500 deep"),
    "texture": ('<asset><texture type="2d" builtin="flat" width="60000" height="60000"/></asset>', "cells"),
    "textures": ('<asset><texture type="2d" builtin="flat" width="6000" height="6000"/></asset>' * 2, "cells"),
    "height field": ('<asset><hfield name="h" nrow="60000" ncol="60000" size="1 1 1 1"/></asset>', "cells"),
    "picture": ('<asset><texture type="2d" file="big.png"/></asset>', "pictures of more than"),
    "user values": ('<size nuser_geom="200000000"/>', "nuser_geom of <size> is 2e+08; the maximum is 10000"),
    "key frames": ('<size nkey="20000000"/>', "nkey of <size> is 2e+07"),
    "cone": ('<asset><mesh name="m" builtin="cone" params="200000000 1"/></asset>', "params of <mesh> is 2e+08"),
}


@pytest.mark.parametrize(("text", "message"), TOO_MUCH.values(), ids=TOO_MUCH.keys())
def test_a_model_that_asks_for_too_much_is_refused_before_it_is_compiled(tmp_path, monkeypatch, text, message):
    def compile_it(*args: object) -> None:
        raise AssertionError("MuJoCo reads what should have been refused")

    monkeypatch.setattr(mujoco.MjSpec, "from_file", compile_it)
    file = write(tmp_path, text)
    with pytest.raises(InputError) as caught:
        compose_world(file, [])
    (fault,) = caught.value.faults
    assert message in fault.message
    assert fault.file is not None
    assert fault.line
    assert fault.column


def test_check_tells_so_too(tmp_path):
    folder = tmp_path / "scenarios" / "worlds"
    folder.mkdir(parents=True)
    write(folder, world(f'<replicate count="100000">{BALL}</replicate>'))
    (fault,) = check_content([folder / "world.xml"], code=False).faults
    assert str(fault).startswith(f"{folder / 'world.xml'}:2:38: the model has 100000 elements from replicate")


def test_too_many_bytes_are_refused(tmp_path, monkeypatch):
    file = write(tmp_path, '<asset><mesh name="m" file="m.stl"/></asset>')
    (tmp_path / "m.stl").write_bytes(bytes(2000))
    monkeypatch.setattr(mjcf, "MOST_ASSETS", 1000)
    with pytest.raises(InputError, match="more than 0 MB of meshes"):
        examine_model(file, ())
    monkeypatch.setattr(mjcf, "MOST_TEXT", 20)
    with pytest.raises(InputError, match="of XML"):
        examine_model(file, ())


@pytest.mark.parametrize("files", [5, 6])
def test_a_model_may_consist_of_so_many_files(tmp_path, monkeypatch, files):
    """The model's own file counts."""
    monkeypatch.setattr(mjcf, "MOST_FILES", 5)
    for i in range(files - 1):
        (tmp_path / f"part{i}.xml").write_text(f"<mujoco><worldbody>{BALL}</worldbody></mujoco>")
    file = write(tmp_path, "".join(f'<include file="part{i}.xml"/>' for i in range(files - 1)))
    if files == 5:
        examine_model(file, ())
    else:
        with pytest.raises(InputError, match="the model consists of more than 5 files"):
            examine_model(file, ())


FINE = {
    "copies": world(f'<replicate count="200" offset="1 0 0">{BALL}</replicate>'),
    "balls": world(BALL * 2000),
    "include": '<include file="balls.xml"/>',
    "attached": '<asset><model name="m" file="balls.xml"/></asset>'
    + world('<attach model="m" prefix="a"/><attach model="m" prefix="b"/>'),
    "texture": '<asset><texture name="t" type="2d" builtin="flat" width="512" height="512"/></asset>',
}


@pytest.mark.parametrize("text", FINE.values(), ids=FINE.keys())
def test_a_model_of_some_size_is_fine(tmp_path, text):
    file = write(tmp_path, text)
    (tmp_path / "balls.xml").write_text(f"<mujoco><worldbody>{BALL * 500}</worldbody></mujoco>")
    assert compose_world(file, []).model.nbody >= 1


@pytest.mark.parametrize("file", sorted(shipped_root().glob("scenarios/worlds/*.xml")), ids=lambda p: p.stem)
def test_every_shipped_world_is_far_below_the_limits(file, monkeypatch):
    for name in ("MOST_ELEMENTS", "MOST_JOINTS", "MOST_CELLS"):
        monkeypatch.setattr(mjcf, name, getattr(mjcf, name) // 8)
    examine_model(file, ())
