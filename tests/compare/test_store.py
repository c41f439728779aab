"""Store: what it says of a file that it cannot use."""

from __future__ import annotations

import gc
import sqlite3
import sys
import threading

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.compare import EpisodeStore
from rocs_bt.compare.store import FILE, Cost

from .records import episode


def filled(folder):
    with EpisodeStore(folder) as store:
        for number in range(200):
            store.put(episode("tree", f"field-{number}"), Cost(1.0, 1.0))
    return folder / FILE


def overwrite(file):
    with file.open("r+b") as bytes_:
        bytes_.write(b"garbage " * 4)


def truncate(file):
    with file.open("r+b") as bytes_:
        bytes_.truncate(file.stat().st_size // 2)


def older(file):
    file.unlink()
    with sqlite3.connect(file) as db:
        db.execute("create table episodes (key text primary key, outcome text)")
    db.close()


def rewrite(file):
    with sqlite3.connect(file) as db:
        db.execute("update episodes set record = '{}'")
    db.close()


def test_a_store_in_memory_may_be_let_go_of_by_another_thread(monkeypatch):
    complaints = []
    monkeypatch.setattr(sys, "unraisablehook", complaints.append)
    held = [EpisodeStore()]
    thread = threading.Thread(target=held.clear)
    thread.start()
    thread.join()
    gc.collect()
    assert not complaints


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (overwrite, "cannot be used: file is not a database"),
        (truncate, "cannot be used: database disk image is malformed"),
        (older, "was made by another version of rocs_bt"),
        (rewrite, "holds a damaged record of the episode tree/field-7"),
    ],
)
def test_a_store_that_cannot_be_used_is_named_with_what_to_do(tmp_path, damage, words):
    damage(filled(tmp_path))

    def use():
        with EpisodeStore(tmp_path) as store:
            list(store.records(["tree/field-7/1"]))

    with pytest.raises(InputError, match=words) as told:
        use()
    assert str(tmp_path / FILE) in str(told.value)
    assert "move this file away" in str(told.value)


def test_a_folder_that_is_a_file_is_told(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be opened"):
        EpisodeStore(tmp_path / "file")
