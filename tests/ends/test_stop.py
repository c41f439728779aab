"""SIGINT, SIGTERM and SIGHUP end commands that read and write: no half file and no process remains."""

from __future__ import annotations

import os
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest

from rocs_bt.cli.main import call

SLOW = """
import sys, time
from pathlib import Path
import {module} as module
slow = module.{name}
def wait(*arguments, **options):
    Path("reached").touch()
    {wait}
    return slow(*arguments, **options)
module.{name} = wait
from rocs_bt.cli.main import main
sys.argv = ["rocs-bt", *sys.argv[1:]]
main()
"""
COMPARE = "compare none random --family maze --scenes 50 --jobs 2 --store s --report r.html"
WAIT = "time.sleep(60.0)"
# Python runs no handler of a signal meanwhile:
IN_C = "import sqlite3; sqlite3.connect('lock', timeout=60.0).execute('begin exclusive')"

AT = {
    # command: module and function in which it is when the signal arrives, and what must not remain
    "new p": ("rocs_bt.cli.new", "read_bytes", "p"),
    "export r --rosbag bag": ("rocs_bt.ros2.bags.export", "_profile", "bag"),
    "report r --out o": ("rocs_bt.studio.report", "write_whole", "o/report.html"),
    "plot r --out o": ("rocs_bt.record.figures.figure", "write_whole", "o/trajectory.png"),
    "list": ("rocs_bt.cli.list", "echo", ""),
    "knowledge export r --out k.json": ("rocs_bt.cli.knowledge", "write_whole", "k.json"),
    "show --palette --out p.xml": ("rocs_bt.cli.show", "write_whole", "p.xml"),
}


@pytest.fixture
def folder(tmp_path: Path, recorded: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "r").symlink_to(recorded)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("run")
    assert call(["run", "exp1", "--for", "1", "--out", str(out), "--no-report"]) == 1
    return out


@pytest.fixture
def start() -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Starts Python in a session of its own, and ends what is left of it."""
    begun: list[subprocess.Popen[str]] = []

    def start(*command: str) -> subprocess.Popen[str]:
        begun.append(
            subprocess.Popen(
                [sys.executable, *command],
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                start_new_session=True,
            )
        )
        return begun[-1]

    yield start
    for process in begun:
        if alive(process):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def alive(process: subprocess.Popen[str]) -> bool:
    """Whether a process of the session of a command exists."""
    try:
        os.killpg(process.pid, 0)
    except ProcessLookupError:
        return False
    return True


def until(found: Callable[[], bool], process: subprocess.Popen[str]) -> None:
    while not found():
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)


def ended(process: subprocess.Popen[str], received: signal.Signals) -> str:
    """Stderr of a command that ends by a signal and leaves no process; the time is ample, for a loaded machine."""
    process.send_signal(received)
    _, err = process.communicate(timeout=30.0)
    assert process.returncode == 128 + received, err
    assert "Traceback" not in err
    for _ in range(1000):
        if not alive(process):
            return err
        time.sleep(0.01)
    raise AssertionError("a process remains")


@pytest.mark.parametrize(("line", "number"), list(zip(AT, [15, 2, 1, 15, 2, 1, 15], strict=True)))
def test_a_signal_ends_a_command_that_reads_or_writes(line, number, folder, start):
    module, name, left = AT[line]
    process = start("-c", SLOW.format(module=module, name=name, wait=WAIT), *line.split())
    until(lambda: Path("reached").exists(), process)
    ended(process, signal.Signals(number))
    assert not left or not (folder / left).exists()
    assert not [file for file in folder.rglob("*") if file.name.endswith(".part")]


def test_a_signal_ends_a_command_that_is_inside_a_library(folder, start):
    with closing(sqlite3.connect("lock", isolation_level=None)) as held:
        held.execute("create table t (x)")
        held.execute("begin exclusive")
        process = start("-c", SLOW.format(module="rocs_bt.cli.list", name="echo", wait=IN_C), "list")
        until(lambda: Path("reached").exists(), process)
        ended(process, signal.SIGTERM)


def test_a_signal_ends_a_comparison_with_its_worker_processes(folder, start):
    process = start("-m", "rocs_bt", *COMPARE.split())

    def plays() -> bool:
        with closing(sqlite3.connect("file:s/episodes.sqlite?mode=ro", uri=True)) as store:
            if not store.execute("select name from sqlite_master where name = 'episodes'").fetchone():
                return False
            return bool(store.execute("select count(*) from episodes").fetchone()[0])

    until(lambda: Path("s/episodes.sqlite-wal").exists() and plays(), process)
    ended(process, signal.SIGTERM)
    assert not Path("r.html").exists()
