"""The engine fails in the middle of a run: neutral first, and the files hold what there is."""

from __future__ import annotations

import json
import signal
from pathlib import Path

import pytest

import rocs_bt
from rocs_bt.base.errors import BlockError
from rocs_bt.catalog import Catalog
from rocs_bt.cli.main import call
from rocs_bt.devices.mujoco import MujocoWorld
from rocs_bt.event import ActuatorCommanded, AgentStopped, Event, OutcomeDecided
from rocs_bt.monitor import RangeMonitor
from rocs_bt.record import Recording
from rocs_bt.running import EndedAtOnce, StopSignals
from rocs_bt.simulation import SimulatedWorld
from rocs_bt.studio import report

MODES = pytest.mark.parametrize("mode", ["lockstep", "threaded"])


class Defect(ArithmeticError):
    """A defect of the engine."""


def breaks(t: float) -> None:
    """A watcher that raises after a second."""
    if t > 1.0:
        raise Defect("a worm")


def written(folder: Path) -> dict:
    """The summary of a run that broke off, after a look at its other files."""
    recording = Recording.open(folder)
    events = list(recording.events())
    summary = json.loads((folder / "summary.json").read_text())
    assert recording.complete
    assert json.loads(recording.summary.to_json()) == summary
    assert [e.agent for e in events if isinstance(e, AgentStopped)] == ["R2"]
    assert len([e for e in events if isinstance(e, OutcomeDecided)]) == 1
    assert [e.values for e in events if isinstance(e, ActuatorCommanded)][-1] == [0.0, 0.0]
    assert (folder / "report.html").read_text().rstrip().endswith("</html>")
    return summary


@MODES
def test_what_raises_beside_the_agents_stops_them_and_leaves_all_files(tmp_path, mode):
    with pytest.raises(Defect, match="a worm") as caught:
        rocs_bt.run("exp1", Catalog(), mode=mode, out=tmp_path, progress=breaks)
    agent = written(tmp_path)["agents"]["R2"]
    assert (agent["outcome"], agent["reason"]) == ("error", "the run ended by an exception: Defect: a worm")
    (note,) = caught.value.__notes__
    assert "R2 error: the run ended by an exception: Defect: a worm" in note
    assert f"Report: {tmp_path}/report.html" in note


@MODES
def test_a_sink_that_raises_ends_the_run_and_loses_no_file(tmp_path, mode):
    class Broken:
        """Raises in the midst of whatever block emits first after a second."""

        def emit(self, event: Event) -> None:
            breaks(event.t)

    with pytest.raises(Defect, match="a worm"):
        rocs_bt.run("exp1", Catalog(), mode=mode, out=tmp_path, sinks=[Broken()])
    agent = written(tmp_path)["agents"]["R2"]
    assert (agent["outcome"], agent["reason"]) == ("error", "the run ended by an exception: Defect: a worm")
    assert agent["failed_block"] is None


@MODES
def test_on_the_command_line_it_is_the_engine_that_failed(tmp_path, monkeypatch, capsys, mode):
    advance = MujocoWorld.advance

    def unstable(self: MujocoWorld, steps: int) -> None:
        if self.clock.now() > 1.0:
            raise BlockError("physics", "raised", "the world is unstable")
        advance(self, steps)

    monkeypatch.setattr(MujocoWorld, "advance", unstable)
    assert call(["run", "exp1", "--mode", mode, "--out", str(tmp_path)]) == 3
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith("the engine failed: block 'physics' raised: ")
    assert "the world is unstable" in told.err
    assert told.err.endswith(f"\nReport: {tmp_path}/report.html\n")
    assert written(tmp_path)["agents"]["R2"]["outcome"] == "error"


def test_a_device_that_does_not_let_go_costs_no_report(tmp_path):
    def prepare(stage: SimulatedWorld) -> None:
        def close() -> None:
            raise Defect("stuck in the socket")

        stage.sensors["R2"]["sonar"].close = close

    with pytest.raises(Defect, match="stuck in the socket") as caught:
        rocs_bt.run("exp1", Catalog(), out=tmp_path, duration=1.0, prepare=prepare)
    assert "R2 timeout" in caught.value.__notes__[0]
    assert written(tmp_path)["agents"]["R2"]["outcome"] == "timeout"


def test_a_block_of_the_engine_that_fails_is_exit_code_3(tmp_path, monkeypatch, capsys):
    run = RangeMonitor.run

    def raises(self: RangeMonitor, t: float, count: int) -> None:
        if t > 0.5:  # in the run, not in the check before it
            raise Defect("a worm")
        run(self, t, count)

    monkeypatch.setattr(RangeMonitor, "run", raises)
    assert call(["run", "exp1", "--out", str(tmp_path), "--no-report"]) == 3
    assert "R2 error" in capsys.readouterr().out
    agent = json.loads((tmp_path / "summary.json").read_text())["agents"]["R2"]
    assert (agent["failed_block"], agent["failed_owner"]) == ("monitor range", "engine")


def test_a_report_that_cannot_be_drawn_loses_neither_summary_nor_outcome(tmp_path, monkeypatch, capsys):
    def broken(*args: object) -> str:
        raise Defect("a pen without ink")

    monkeypatch.setattr(report, "render_report", broken)
    assert call(["run", "exp1", "--out", str(tmp_path)]) == 3
    told = capsys.readouterr().err
    assert "Defect: a pen without ink" in told
    assert "R2 success; " in told
    assert json.loads((tmp_path / "summary.json").read_text())["agents"]["R2"]["outcome"] == "success"


class TestSignalsWhileTheReportIsWritten:
    """The run is over by then, so its outcome stays."""

    @pytest.fixture
    def signals(self, monkeypatch: pytest.MonkeyPatch) -> list[signal.Signals]:
        """Signals that arrive when the report is half done."""
        sent: list[signal.Signals] = []
        render = report.render_report

        def interrupted(*args: object) -> str:
            for each in sent:
                signal.raise_signal(each)
            return render(*args)

        monkeypatch.setattr(report, "render_report", interrupted)
        return sent

    def test_the_first_one_waits_for_the_report(self, tmp_path, signals):
        signals.append(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            rocs_bt.run("exp1", Catalog(), out=tmp_path, duration=1.0)
        assert written(tmp_path)["agents"]["R2"]["outcome"] == "timeout"

    def test_a_second_one_costs_the_report_alone(self, tmp_path, signals):
        signals += [signal.SIGINT, signal.SIGTERM]
        with pytest.raises(EndedAtOnce) as caught:
            rocs_bt.run("exp1", Catalog(), out=tmp_path, duration=1.0)
        assert caught.value.__notes__ == [f"There is no report.html. To create it: rocs-bt report {tmp_path}"]
        assert sorted(file.name for file in tmp_path.iterdir()) == ["run.mcap", "summary.json"]
        signals.clear()
        assert call(["report", str(tmp_path)]) == 0
        written(tmp_path)

    def test_a_caller_who_looks_at_the_signals_gets_the_result(self, tmp_path, signals):
        signals.append(signal.SIGTERM)
        before = signal.getsignal(signal.SIGTERM)
        stopping = StopSignals()
        result = rocs_bt.run("exp1", Catalog(), out=tmp_path, duration=1.0, signals=stopping)
        assert result.report is not None
        assert stopping.received is signal.SIGTERM
        assert signal.getsignal(signal.SIGTERM) is before
