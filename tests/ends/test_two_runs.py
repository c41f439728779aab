"""Two runs never write in one folder."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from rocs_bt import InputError, Recording, run
from rocs_bt.record import FolderLock

HOLD = """
import sys, pathlib
from rocs_bt.record import FolderLock
lock = FolderLock(pathlib.Path(sys.argv[1]))
print("locked", flush=True)
sys.stdin.read()
"""


def files(folder: Path) -> dict[str, bytes]:
    return {each.name: each.read_bytes() for each in folder.iterdir()}


def test_a_second_run_is_refused_until_the_first_has_ended_however_it_ends(tmp_path: Path) -> None:
    out = tmp_path / "run"
    run("exp1", out=out, duration=0.1, report=False)
    before = files(out)
    other = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(out)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    try:
        assert other.stdout is not None
        assert other.stdout.readline() == "locked\n"
        with pytest.raises(InputError, match=rf"process {other.pid}.*--out .*run-2") as caught:
            run("exp1", out=out, duration=0.1, report=False)
        assert str(out) in str(caught.value)
        assert files(out) == before
    finally:
        other.kill()
        other.communicate()
    run("exp1", out=out, duration=0.2, report=False)
    Recording.open(out)


def test_the_proposed_folder_does_not_exist(tmp_path: Path) -> None:
    for name in ("run", "run-2", "run-3"):
        (tmp_path / name).mkdir()
    lock = FolderLock(tmp_path / "run")
    with pytest.raises(InputError, match=rf"process {os.getpid()}.*run-4"):
        FolderLock(tmp_path / "run")
    lock.close()
    lock.close()
    FolderLock(tmp_path / "run").close()
