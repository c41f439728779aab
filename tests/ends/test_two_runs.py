"""Two runs never write in one folder."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from rocs_bt import InputError, Recording, run
from rocs_bt.cli.main import call
from rocs_bt.record import FolderLock

from .. import needs

HOLD = """
import sys, pathlib
from rocs_bt.cli.main import call
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


READ = [
    "replay run",
    "replay run --why 0.1",
    "export run --rosbag bag",
    "plot run --out figures",
    "report run --out other",
]


def test_a_folder_in_which_a_run_writes_is_read_up_to_its_newest_event_and_gets_no_report(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    out = tmp_path / "run"
    run("exp1", out=out, duration=1.0, report=False)
    whole = (out / "run.mcap").read_bytes()
    (out / "run.mcap").write_bytes(whole[: len(whole) // 2])  # what is on the disk meanwhile
    (out / "summary.json").unlink()
    before = files(out)
    lock = FolderLock(out)
    assert call(["report", "run"]) == 2
    assert (
        f"another run is writing in 'run', process {os.getpid()}. Write for example: --out run-2"
        in capsys.readouterr().err
    )
    for line in READ:
        assert call(line.split()) == 0, line
    lock.close()
    assert files(out) == before


def test_a_folder_that_cannot_be_written_is_refused_before_the_run(tmp_path, monkeypatch, capsys):
    with needs.disk(tmp_path / "disk", "2m") as disk:
        monkeypatch.chdir(tmp_path)
        run("exp1", out=disk / "run", duration=0.2, report=False)
        subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
        before = files(disk / "run")
        for line in ("run exp1 --for 0.1 --out disk/run", "run exp1 --for 0.1 --out disk/new", "report disk/run"):
            assert call(line.split()) == 2
            assert "Read-only file system" in capsys.readouterr().err
        for line in ("replay disk/run", "replay disk/run --why 0.1", "export disk/run --rosbag bag"):
            assert call(line.split()) == 0, line
        assert files(disk / "run") == before


def test_the_proposed_folder_does_not_exist(tmp_path: Path) -> None:
    for name in ("run", "run-2", "run-3"):
        (tmp_path / name).mkdir()
    lock = FolderLock(tmp_path / "run")
    with pytest.raises(InputError, match=rf"process {os.getpid()}.*run-4"):
        FolderLock(tmp_path / "run")
    lock.close()
    lock.close()
    FolderLock(tmp_path / "run").close()
