"""`rocs-bt report`: the same summary as the live run, from its recording; and one of any recording that was cut off."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rocs_bt
from rocs_bt.base.errors import RecordingError
from rocs_bt.catalog import Catalog
from rocs_bt.cli.main import call
from rocs_bt.event import BlockFailed, ContactBegan, OutcomeDecided
from rocs_bt.record import Recorder, Recording, RunHeader, Summary
from rocs_bt.record.file.header import AgentInfo
from rocs_bt.running import summary_of
from rocs_bt.simulation import OUTCOMES

from ..pages import data_of

UNRECORDED = ("wall_time", "real_time_factor", "trajectory_hash", "knowledge")
REQUIRED = """format = "scenario/2"
base = "exp1"
[[requirement]]
name = "clear"
require = "always min(front) > 0.1 m"
[[requirement]]
name = "fast"
require = "always speed > 0.3 m/s"
"""


def plain(summary: Summary) -> dict[str, Any]:
    """A summary as JSON, without what no event holds."""
    found = json.loads(summary.to_json())
    agents = {name: {**agent, "sharing": None} for name, agent in found["agents"].items()}
    return {key: value for key, value in {**found, "agents": agents}.items() if key not in UNRECORDED}


@pytest.mark.parametrize(
    ("scenario", "options"),
    [
        ("exp1", {}),
        ("required", {}),
        ("exp3_shared", {"duration": 4.0}),
        ("exp1_localised", {"duration": 4.0}),
        ("exp3", {"duration": 3.0, "mode": "threaded"}),
        ("exp1", {"duration": 2.0, "knowledge": True}),
    ],
    ids=lambda value: value if isinstance(value, str) else "-".join(map(str, value.values())),
)
def test_a_recording_gives_the_summary_of_its_run(project, capsys, scenario: str, options: dict[str, Any]) -> None:
    (project / "scenarios/required.toml").write_text(REQUIRED)
    if options.pop("knowledge", False):
        options["knowledge"] = project / "known.json"
    live = rocs_bt.run(scenario, Catalog(project), out="out", report=False, **options).summary
    capsys.readouterr()
    assert call(["report", "out", "--out", "again"]) == 0
    assert "Report: again/report.html" in capsys.readouterr().out
    assert Path("again/summary.json").read_text() == live.to_json()
    # Computed, not copied: without the summary at the end of the recording it is the same but for what no event holds.
    recording = Recording.open(Path("out"))
    recording.summary = None
    found = summary_of(recording)
    assert plain(found) == plain(live)
    assert not any(getattr(found, key) for key in UNRECORDED)
    if scenario == "required":
        assert [r.verdict for r in found.agents["R2"].requirements] == ["satisfied", "violated"]


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> tuple[bytes, Summary, Callable[[bytes], Path]]:
    """The recording of a run of 2 s, its summary, and a way to write another one."""
    folder = tmp_path_factory.mktemp("short")
    summary = rocs_bt.run("exp1", Catalog(), out=folder, duration=2.0, report=False).summary

    def write(data: bytes) -> Path:
        (folder / "cut.mcap").write_bytes(data)
        return folder / "cut.mcap"

    return (folder / "run.mcap").read_bytes(), summary, write


@settings(max_examples=60, deadline=None)
@given(share=st.floats(0.0, 1.0))
def test_a_recording_that_was_cut_off_anywhere_gives_a_summary_or_says_why_not(short, share: float) -> None:
    data, live, write = short
    file = write(data[: int(share * len(data))])
    try:
        recording = Recording.open(file)
    except RecordingError as error:
        assert "is cut off within its header" in str(error) or "is not an MCAP recording" in str(error)
        return
    found, whole = summary_of(recording).agents["R2"], live.agents["R2"]
    assert found.path_length <= whole.path_length
    if found.outcome == "interrupted":
        end = summary_of(recording).sim_time
        assert found.reason == f"the recording ends at {end:.2f} s without an outcome"
        assert 0.0 <= end <= 2.0
    else:
        assert (found.outcome, found.reason) == (whole.outcome, whole.reason)


def test_what_was_sure_when_a_recording_was_cut_off_outranks_interrupted(tmp_path: Path) -> None:
    agents = tuple(AgentInfo(name=name, robot="r", mission="m") for name in ("R1", "R2", "R3", "R4"))
    recorder = Recorder(tmp_path / "run.mcap", RunHeader(scenario="one", seed=1, agents=agents))
    recorder.emit(OutcomeDecided(t=0.5, agent="R4", outcome="success", reason="", time_to_goal=0.5))
    recorder.emit(ContactBegan(t=1.0, agent="R1", other="box", kind="struck"))
    recorder.emit(ContactBegan(t=1.0, agent="R2", other="box", kind="collision"))
    recorder.emit(BlockFailed(t=2.0, agent="R3", block="plan", kind="hung", detail="no end"))
    recorder.close()
    agents_found = summary_of(Recording.open(tmp_path / "run.mcap")).agents
    assert {name: (agent.outcome, agent.reason) for name, agent in agents_found.items()} == {
        "R1": ("interrupted", "the recording ends at 2.00 s without an outcome"),
        "R2": ("collision", "it ran into box at 1.00 s"),
        "R3": ("error", "block 'R3/plan' hung: no end"),
        "R4": ("success", ""),
    }
    assert all(agent.outcome in OUTCOMES for agent in agents_found.values())


def test_after_kill_9_there_is_a_report(project, start, capsys) -> None:
    process = start("-m", "rocs_bt", "run", "long", "--mode", "threaded", "--out", "out")
    process.wait_for(project / "out/run.mcap")
    process.kill()
    assert process.end()[0] == -9
    assert [file.name for file in Path("out").iterdir()] == ["run.mcap"]
    capsys.readouterr()
    assert call(["report", "out"]) == 0
    told = capsys.readouterr().out
    assert told.startswith("R2 interrupted (long, seed 1): the recording ends at ")
    summary = json.loads(Path("out/summary.json").read_text())
    assert (summary["wall_time"], summary["trajectory_hash"]) == (None, None)
    assert summary["agents"]["R2"]["path_length"] > 0.0
    shown = data_of(Path("out/report.html"))["results"]["R2"]
    assert (shown["outcome"], shown["reason"]) == ("interrupted", summary["agents"]["R2"]["reason"])


def test_a_run_that_is_not_there_is_an_error_in_a_sentence(project, capsys) -> None:
    shutil.rmtree("runs", ignore_errors=True)
    assert call(["report", "runs/first-1"]) == 2
    assert capsys.readouterr().err.startswith("no recording is named 'runs/first-1'.")
