"""Requirements: the live run and its recording give the same; verdicts, margins and worst moments are right."""

import json
import math

import msgspec
import numpy as np
import pytest

from rocs_bt import run
from rocs_bt.base.signal import Signal
from rocs_bt.base.units import LENGTH, SPEED
from rocs_bt.catalog import Catalog
from rocs_bt.event import AgentStopped, BodyMoved, ListSink, RequirementViolated, SignalsWritten, pack
from rocs_bt.record import AgentInfo, Recording, RequirementInfo, SignalInfo
from rocs_bt.running import RequirementWatch, check_recorded

SIGNALS = tuple(SignalInfo.of(Signal(n, 1, (d,), max_age=0.15)) for n, d in (("front", LENGTH), ("speed", SPEED)))
R1 = AgentInfo(name="R1", robot="rover", mission="m", signals=SIGNALS)
SCENARIO = """
format = "scenario/2"
base = "exp1"
doc = "EXP1 with requirements."
[[requirement]]
name = "keeps clear"
require = "always min_clearance > 0.18 m"
[[requirement]]
name = "stops in time"
agent = "R2"
require = "always (min(front) < 0.3 m implies within 0.2 s speed < 0.05 m/s)"
[[requirement]]
name = "arrives"
require = "hypot(true_pose[0], true_pose[1]) < 0.12 m"
"""


def judge(text, rows, stopped=True):
    """The finding on rows of (t, front, speed), and the events that it told."""
    sink = ListSink()
    watch = RequirementWatch([RequirementInfo(name="it", agent="R1", text=text)], [R1], sink)
    for t, *values in rows:
        given = {n: v for n, v in zip(("front", "speed"), values, strict=True) if v is not None}
        watch.emit(BodyMoved(t=t, agent="R1", body="R1", x=0.0, y=0.0, yaw=0.0))
        data = pack(given.values())
        watch.emit(SignalsWritten(t=t, agent="R1", monitor="m", signals=(*given,), sizes=(1,) * len(given), data=data))
    if stopped:
        watch.emit(AgentStopped(t=rows[-1][0] + 0.05, agent="R1", by="test"))
    watch.close()
    (finding,) = watch.of("R1")
    return finding, sink.events


@pytest.mark.usefixtures("awake")
@pytest.mark.parametrize("mode", ["lockstep", "threaded"])
def test_a_recording_gives_what_the_run_gave(mode, tmp_path):
    file = tmp_path / "scenarios" / "req.toml"
    file.parent.mkdir()
    file.write_text(SCENARIO, "utf-8")
    result = run(str(file), Catalog(tmp_path), seed=3, mode=mode, out=tmp_path / "run", duration=2.5, report=False)
    recording = Recording.open(result.recording)
    live = json.loads((tmp_path / "run" / "summary.json").read_text())["agents"]["R2"]["requirements"]
    assert msgspec.to_builtins(check_recorded(recording)["R2"]) == live
    assert [f["name"] for f in live] == ["keeps clear", "stops in time", "arrives"]
    assert live[2]["verdict"] == "violated"
    told = {e.requirement: e.about for e in recording.events() if isinstance(e, RequirementViolated)}
    assert told == {f["name"]: f["violated"] for f in live if f["violated"] is not None}


def test_satisfied_with_its_least_margin_and_when():
    finding, told = judge("always front > 0.3 m", [(0.0, 1.0, 0), (0.05, 0.4, 0), (0.1, 0.6, 0)])
    assert (finding.verdict, finding.unit, finding.worst, finding.violated) == ("satisfied", "m", 0.05, None)
    assert finding.margin == pytest.approx(0.1)
    assert (finding.samples, finding.unknown, told) == (3, 0, [])


def test_violated_is_told_once_when_it_is_known():
    finding, told = judge("always front > 0.3 m", [(0.0, 1.0, 0), (0.05, 0.2, 0), (0.1, 0.1, 0), (0.15, 1.0, 0)])
    assert (finding.verdict, finding.worst, finding.violated) == ("violated", 0.1, 0.05)
    assert finding.margin == pytest.approx(-0.2)
    assert [(e.t, e.about, round(e.margin, 9)) for e in told] == [(0.1, 0.05, -0.1)]


def test_the_reading_is_that_of_the_first_violation_else_of_the_least_margin():
    random = np.random.default_rng(5)
    for _ in range(30):
        rows = [(0.05 * k, round(float(front), 3), 0.0) for k, front in enumerate(random.uniform(0.25, 2.0, 8))]
        finding, told = judge("always front > 0.3 m", rows)
        at = finding.worst if finding.violated is None else finding.violated
        front = next(front for t, front, _ in rows if math.isclose(t, at, abs_tol=1e-9))
        assert finding.reading == f"front = {front:.3g} m"
        assert [e.sentence for e in told] == [f"it was violated at {at:.2f} s ({finding.reading})"] * len(told)
    ahead, _ = judge("always (front < 0.3 m implies within 0.1 s speed < 0.05 m/s)", [(0.0, 0.2, 0.5), (0.2, 0.2, 0.5)])
    assert ahead.reading == ""  # its values are those of several samples


def test_unknown_is_neither():
    finding, _ = judge("always front > 0.3 m", [(0.0, 1.0, 0), (0.05, math.nan, 0), (0.1, 1.0, 0)])
    assert (finding.verdict, finding.unknown, finding.margin) == ("unknown", 1, pytest.approx(0.7))
    finding, _ = judge("always front > 0.3 m", [(0.0, math.nan, 0), (0.05, 0.1, 0)])
    assert finding.verdict == "violated"
    finding, _ = judge("always front > 0.3 m", [(0.0, None, 0.0)])
    assert (finding.verdict, finding.margin, finding.worst) == ("unknown", None, None)


def test_what_comes_later_is_waited_for_and_what_the_run_is_too_short_for_is_not_asked():
    text = "always (front < 0.3 m implies within 0.1 s speed < 0.05 m/s)"
    slow = [(0.05 * k, 0.2 if k == 2 else 1.0, 0.0 if k == 4 else 0.5) for k in range(8)]
    finding, _ = judge(text, slow)
    assert finding.verdict == "satisfied"
    finding, told = judge(text, [(t, front, 0.5) for t, front, _ in slow])
    assert (finding.verdict, finding.violated) == ("violated", pytest.approx(0.1))
    assert told[0].t == pytest.approx(0.25)
    finding, _ = judge(text, [(0.0, 1.0, 0.5), (0.05, 1.0, 0.5), (0.1, 1.0, 0.5), (0.15, 0.2, 0.5), (0.2, 0.2, 0.5)])
    assert (finding.verdict, finding.samples) == ("satisfied", 3)
    finding, _ = judge(text, [(0.0, 1.0, 0.5), (0.05, 0.2, 0.5)])
    assert (finding.verdict, finding.samples) == ("unknown", 0)


def test_without_always_the_end_counts():
    rows = [(0.0, 1.0, 0), (0.05, 0.1, 0), (0.1, 1.0, 0)]
    assert judge("front > 0.3 m", rows)[0].verdict == "satisfied"
    finding, told = judge("front > 0.3 m", rows[:2])
    assert (finding.verdict, finding.violated, finding.samples) == ("violated", 0.05, 1)
    assert [e.requirement for e in told] == ["it"]


def test_a_run_that_was_cut_off_is_judged_as_far_as_it_goes():
    finding, _ = judge("always front > 0.3 m", [(0.0, 1.0, 0), (0.05, 0.1, 0)], stopped=False)
    assert (finding.verdict, finding.samples) == ("violated", 2)


def test_a_margin_without_bound_is_none():
    finding, _ = judge("always front > 0.3 m", [(0.0, math.inf, 0)])
    assert (finding.verdict, finding.margin) == ("satisfied", None)
