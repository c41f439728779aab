"""Truncated and mutated bags never cause anything but an error message."""

import random
import shutil

import pytest

from rocs_bt.base.errors import InputError, RecordingError
from rocs_bt.ros2.bags.bag_file import Bag

from .robots import ForeignBag, cart

KINDS = {
    "mcap": ({}, "drive.mcap"),
    "zstd": ({"compression": "STORAGE"}, "drive.mcap"),
    "messages": ({"compression": "MESSAGE"}, "drive.mcap"),
    "sqlite3": ({"storage": "SQLITE3"}, "drive.db3"),
    "metadata": ({}, "metadata.yaml"),
    "file": ({"compression": "FILE"}, "drive.mcap.zstd"),
    "ros1": ({}, ""),
}


@pytest.fixture(scope="module")
def bags(tmp_path_factory):
    made = {}
    for kind, (options, file) in KINDS.items():
        path = tmp_path_factory.mktemp(kind) / ("drive.bag" if kind == "ros1" else "drive")
        with ForeignBag(path, **options) as bag:
            bag.drive(beams=30)
        made[kind] = path, path / file if file else path
    return made


def spoiled(data, rng):
    """A copy with random damage: cut off, bytes replaced, a part removed or repeated."""
    damaged = bytearray(data)
    how = rng.choice(["cut", "bytes", "bytes", "length", "remove", "repeat"])
    at = rng.randrange(len(damaged))
    if how == "cut":
        del damaged[at:]
    elif how == "bytes":
        for _ in range(rng.choice([1, 1, 5, 50])):
            damaged[rng.randrange(len(damaged))] = rng.randrange(256)
    elif how == "length":
        damaged[at : at + 4] = rng.choice([b"\xff\xff\xff\x7f", b"\x00\x00\x00\x00", b"\xff\xff\xff\xff"])
    elif how == "remove":
        del damaged[at : at + rng.randrange(1, 200)]
    else:
        damaged[at:at] = damaged[at : at + rng.randrange(1, 200)]
    return bytes(damaged)


def damage(bags, kind, seed, folder):
    """Copy of a bag with a damaged file; returns its path."""
    path, file = bags[kind]
    copy = folder / path.name
    if path.is_dir():
        shutil.copytree(path, copy)
    target = copy / file.name if path.is_dir() else copy
    target.write_bytes(spoiled(file.read_bytes(), random.Random(f"{kind} {seed}")))
    return copy


@pytest.mark.parametrize("kind", KINDS)
def test_reading_raises_only_what_is_documented(bags, kind, tmp_path):
    raised = 0
    for seed in range(40):
        (folder := tmp_path / str(seed)).mkdir()
        try:
            bag = Bag(damage(bags, kind, seed, folder))
            try:
                topics = ["/scan", "/odom"]
                bag.types("jazzy", topics)
                assert sum(1 for _ in bag.messages(topics)) < 1000
            finally:
                bag.close()
        except (InputError, RecordingError) as error:
            assert "drive" in str(error)
            raised += 1
    assert raised > 3


@pytest.mark.parametrize("kind", KINDS)
def test_the_command_ends_with_a_message(bags, kind, tmp_path, rocs_bt, monkeypatch):
    for name in ("robots", "planners", "scenarios"):
        (tmp_path / name).mkdir()
    cart(tmp_path)
    monkeypatch.chdir(tmp_path)
    for seed in range(100, 104):
        (folder := tmp_path / str(seed)).mkdir()
        told = rocs_bt("replay", "--bag", damage(bags, kind, seed, folder), "--robot", "cart", "--rules", "wall")
        assert told.code in (0, 2), told.err
        assert "Traceback" not in told.err
        assert told.code == 0 or told.err
