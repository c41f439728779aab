"""A disk that becomes full while a run is recorded, or while its summary and report are written."""

from __future__ import annotations

import errno
import json
import os
import re
import resource
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import rocs_bt
from rocs_bt.catalog import Catalog
from rocs_bt.cli.main import call
from rocs_bt.record import Recording
from rocs_bt.record.file import recorder

from .. import needs

RUN = ("-m", "rocs_bt", "run")
FULL = os.strerror(errno.ENOSPC)


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A disk of 200 kB."""
    with needs.disk(tmp_path / "disk", "200k") as disk:
        yield disk


def test_on_a_full_disk_the_run_goes_on_and_says_what_is_missing(small_disk, start):
    process = start(*RUN, "exp1", "--out", str(small_disk))
    code, out, err = process.end()
    assert code == 1
    assert out.startswith("R2 success in 13.")
    assert "Report" not in out
    lines = err.splitlines()
    assert lines[0].startswith(f"the recording '{small_disk}/run.mcap' ends early, at t = ")
    assert lines[0].endswith(f" s: {FULL}.")
    assert lines[1] == f"the summary '{small_disk}/summary.json' cannot be written: {FULL}."
    assert lines[2] == f"the report '{small_disk}/report.html' cannot be written: {FULL}."
    assert len(lines) == 3
    assert [file.name for file in small_disk.iterdir()] == ["run.mcap"]  # and no half of another one
    recording = Recording.open(small_disk)
    assert not recording.complete
    assert len(list(recording.events())) > 100


def test_a_report_of_what_a_full_disk_left_goes_elsewhere(small_disk, start, tmp_path, capsys):
    start(*RUN, "exp1", "--out", str(small_disk), "--no-report").end()
    capsys.readouterr()
    assert call(["report", str(small_disk)]) == 2
    told = capsys.readouterr().err
    cut_off, missing = told.splitlines()
    assert cut_off.startswith(f"the recording '{small_disk}/run.mcap' was cut off; it is read up to t = ")
    assert (
        missing == f"the summary '{small_disk}/summary.json' cannot be written: {FULL}. Name another folder with --out."
    )
    assert call(["report", str(small_disk), "--out", str(tmp_path / "elsewhere")]) == 0
    assert "R2 interrupted (exp1, seed 1): the recording ends at " in capsys.readouterr().out
    assert json.loads((tmp_path / "elsewhere/summary.json").read_text())["agents"]["R2"]["path_length"] > 0.1
    assert (tmp_path / "elsewhere/report.html").exists()


def test_where_only_the_report_does_not_fit_the_rest_is_kept(project, start):
    """RLIMIT_FSIZE: a file that would become larger is refused, that of a short recording is not."""
    out = project / "out"
    code, told, err = start(*RUN, "exp1", "--for", "0.2", "--out", "out", file_size=70_000).end()
    assert code == 1
    assert told.startswith("R2 timeout")
    assert err == f"the report 'out/report.html' cannot be written: {os.strerror(errno.EFBIG)}.\n"
    assert sorted(file.name for file in out.iterdir()) == ["run.mcap", "summary.json"]
    assert Recording.open(out).complete


def test_a_place_that_is_full_from_the_beginning_is_refused_before_anything_moves(project, start):
    code, out, err = start(*RUN, "exp1", "--out", "out", file_size=1000).end()
    assert (code, out) == (2, "")
    assert err == f"the recording 'out/run.mcap' cannot be written: {os.strerror(errno.EFBIG)}.\n"


@pytest.mark.parametrize("mode", ["lockstep", "threaded"])
def test_in_python_the_result_says_what_is_missing(tmp_path, monkeypatch, mode):
    """The disk fills up at t = 1 s."""

    class Full(recorder.Writer):
        def flush(self) -> None:
            super().flush()
            if (tmp_path / "run.mcap").stat().st_size > 40_000:
                raise OSError(errno.ENOSPC, FULL)

    monkeypatch.setattr(recorder, "Writer", Full)
    result = rocs_bt.run("exp1", Catalog(), mode=mode, out=tmp_path, duration=3.0)
    (missing,) = result.missing
    assert missing.startswith(f"the recording '{tmp_path}/run.mcap' ends early, at t = ")
    assert str(result).endswith(missing)
    assert result.outcomes == {"R2": "timeout"}
    assert json.loads((tmp_path / "summary.json").read_text()) == json.loads(
        result.summary.to_json()
    )  # of the whole run
    assert result.report is not None  # of what was recorded
    assert result.report.exists()


FULL_AT = 300  # [bytes] a file that would become larger is refused
WRITERS = [
    # command, and what must not remain
    ("report r", "r/summary.json"),
    ("report r --out o", "o/report.html"),
    ("plot r --out o", "o/trajectory.svg"),
    ("rules replay avoid_collision r --out o", "o/margins.svg"),
    ("export r --rosbag bag", "bag"),
    ("export r --rosbag bag --storage sqlite3", "bag"),
    ("knowledge show r --out k.html", "k.html"),
    ("knowledge export r --out k2.json", "k2.json"),
    ("knowledge import k.json k3.json", ""),
    ("show --palette --out p.xml", "p.xml"),
    ("show go_to --format svg --out p.svg", "p.svg"),
    ("new p", "p"),
    ("scene maze 1 --out s", "s/scenarios/maze-1.toml"),
    ("knowledge keys R1 --out keys", ""),
    ("compare none random --scenario exp1 --report c.html", "c.html"),
    ("compare none random --scenario exp1 --store c", ""),
    ("run exp1 --for 0.3 --out n", "n/report.html"),
    ("run exp1 --for 0.3 --no-report --out n --knowledge k4.json", ""),
    ("run exp1 --for 0.3 --no-report --out n --video v.gif", "v.gif"),
]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("run") / "r"
    assert call(["run", "exp1", "--for", "0.5", "--out", str(out), "--no-report"]) == 1
    (out / "summary.json").unlink()
    assert call(["knowledge", "export", str(out), "--out", str(out / "k.json")]) == 0
    return out


@pytest.fixture
def full(tmp_path: Path, recorded: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[], None]]:
    """Function from whose call on no large file can be written; until the end of the test."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(recorded, tmp_path / "r")
    shutil.move(tmp_path / "r/k.json", tmp_path / "k.json")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    yield lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (FULL_AT, before[1]))
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize(("line", "left"), WRITERS, ids=[line for line, _ in WRITERS])
def test_each_writer_on_a_full_disk_gives_a_clear_error_and_leaves_no_half_file(line, left, full, tmp_path, capsys):
    before = {file: file.read_bytes() for file in tmp_path.rglob("*") if file.is_file()}
    full()
    code = call(line.split())
    out, err = capsys.readouterr()
    assert code == 2, out + err
    assert "Traceback" not in out + err
    assert re.search(f"{os.strerror(errno.EFBIG)}|database or disk is full|disk I/O error", err), err
    assert not left or not (tmp_path / left).exists()
    assert all(file.read_bytes() == content for file, content in before.items())
    assert not list(tmp_path.rglob("*.part"))
