"""Recordings with the old names of events: read, queried, replayed and reported as those of today."""

import json
import shutil
from pathlib import Path

import pytest

from rocs_bt import event as ev
from rocs_bt import run
from rocs_bt.catalog import Catalog
from rocs_bt.cli.main import call
from rocs_bt.record import Recording, codec, event_table
from rocs_bt.record.renamed_events import RENAMED_EVENTS

from .old_recording import age


@pytest.fixture(scope="module")
def new(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short run of EXP1."""
    out = tmp_path_factory.mktemp("runs") / "new"
    run("exp1", Catalog(), seed=1, out=out, duration=4.0)
    return out


@pytest.fixture
def old(new: Path, tmp_path: Path) -> Path:
    """The same run as an earlier version recorded it."""
    folder = shutil.copytree(new, tmp_path / "old")
    names = age(folder / "run.mcap")
    assert names >= {"Followed", "Judged", "Approached"}
    assert b"rocs_bt.Judged" in (folder / "run.mcap").read_bytes()
    return folder


def test_its_events_are_those_of_today(old: Path, new: Path) -> None:
    found, wanted = Recording.open(old), Recording.open(new)
    assert [codec.encode(e) for e in found.events()] == [codec.encode(e) for e in wanted.events()]
    assert (found.header, found.summary) == (wanted.header, wanted.summary)


def test_old_names_select_events(old: Path) -> None:
    table = event_table(Recording.open(old), "Judged")
    assert table["outcome"].tolist() == event_table(Recording.open(old), ev.OutcomeDecided)["outcome"].tolist()
    assert len(table) == 1


def test_its_report_and_summary_are_made(old: Path, new: Path) -> None:
    before = json.loads((new / "summary.json").read_text())
    (old / "summary.json").unlink()
    assert call(["report", str(old)]) == 0
    assert json.loads((old / "summary.json").read_text())["agents"] == before["agents"]


def test_it_is_replayed_to_the_same_events(old: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(["replay", str(old)]) == 0
    assert capsys.readouterr().out == "All events are equal.\n"


@pytest.mark.parametrize(("old", "new"), RENAMED_EVENTS.items())
def test_a_renamed_event_exists_and_its_old_name_does_not(old: str, new: str) -> None:
    assert hasattr(ev, new)
    assert not hasattr(ev, old)
