"""docs/python.md: its code runs, and the calls that it names exist."""

import pkgutil
import re
from pathlib import Path
from urllib.parse import unquote
from xml.etree import ElementTree

import msgspec
import numpy as np
import pytest

import rocs_bt
from rocs_bt.base.errors import InputError, RecordingError
from rocs_bt.base.registered import registered
from rocs_bt.cli.main import COMMANDS
from rocs_bt.event import RuleChanged, SensorRead

PAGE = (Path(__file__).resolve().parents[2] / "docs/python.md").read_text("utf-8")


@pytest.fixture(scope="module")
def names(tmp_path_factory):
    """The names of the page after its code has run."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("page"))
        found = {}
        for block in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL):
            exec(block, found)
        found["result"] = found["result"].__class__(
            summary=found["result"].summary, recording=found["result"].recording.resolve()
        )
        return found


def test_every_call_of_the_table_exists():
    calls = re.findall(r"`([\w.]+)\(", "".join(re.findall(r"^\|.*", PAGE, re.MULTILINE)))
    assert len(calls) > 10
    for call in calls:
        assert callable(pkgutil.resolve_name(f"rocs_bt.{call.removeprefix('rocs_bt.')}")), call


def test_every_command_is_in_the_table():
    table = "".join(re.findall(r"^\|.*", PAGE, re.MULTILINE))
    known = {*COMMANDS, *(name for name in registered("rocs_bt.commands") if "." not in name)}
    assert known - {"language-server", "studio"} <= set(re.findall(r"`rocs-bt ([a-z]+)`", table)) <= known


def test_events_of_one_kind_have_the_fields_of_that_kind(names):
    result = names["result"]
    events = list(rocs_bt.Recording.open(result.recording).events())
    fired = result.events(RuleChanged, agent="R2")
    expected = [e for e in events if isinstance(e, RuleChanged)]
    assert fired.dtype.names == (
        "time",
        "agent",
        "event",
        "rule",
        "phase",
        "priority",
        "reading",
        "parameters",
        "refirings",
    )
    assert [tuple(row) for row in fired[["time", "rule", "priority"]]] == [(e.t, e.rule, e.priority) for e in expected]
    assert len(result.events()) == len(events)
    assert set(result.events(agent="R2")["agent"]) == {"R2"}
    (sonar,) = {len(e.values) for e in events if isinstance(e, SensorRead) and e.sensor == "sonar"}
    reads = result.events("SensorRead")["data"]
    assert {len(row) for row in reads} >= {sonar}
    goals = result.events("OutcomeDecided")["time_to_goal"]
    assert goals.dtype == np.float64


def test_signals_have_a_row_for_each_period_and_units(names):
    signals = names["signals"]
    assert signals.dtype["front"].subdtype[0] == signals["speed"].dtype == np.float64
    assert signals.dtype.metadata["units"] == {"time": "s", "front": "m", "speed": "m/s"}
    assert np.allclose(np.diff(signals["time"]), 0.05)
    assert len(names["result"].signals("R2").dtype.names) > 3


def test_the_rows_of_a_table_make_a_data_frame_with_its_names(names):
    assert "pandas.DataFrame(fired.tolist(), columns=fired.dtype.names)" in PAGE
    for table in (names["fired"], names["signals"]):
        rows = table.tolist()
        assert [len(row) for row in rows] == [len(table.dtype.names)] * len(table)
        assert rows[0][0] == table["time"][0]
    try:
        import pandas  # no dependency: tested where it is installed
    except ImportError:
        return
    frame = pandas.DataFrame(names["signals"].tolist(), columns=names["signals"].dtype.names)
    assert list(frame["speed"]) == list(names["signals"]["speed"])


def test_a_notebook_shows_outcome_figures_and_report_with_all_texts_escaped(names):
    result = names["result"]
    agent = result.summary.agents["R2"]
    told = msgspec.structs.replace(agent, reason="leaf <b> & '\"'", min_clearance=None)
    summary = msgspec.structs.replace(result.summary, agents={"R<2>": told})
    report = Path("runs/a 'b' <c>#1/report.html")
    shown = rocs_bt.RunResult(summary=summary, report=report, missing=("no <disk>",))._repr_html_()
    root = ElementTree.fromstring(f"<div>{shown}</div>")  # well-formed: nothing of the texts is markup
    head, row = ([cell.text for cell in line] for line in root.iter("tr"))
    values = dict(zip(head, row, strict=True))
    assert values["agent"] == "R<2>"
    assert values["outcome"] == agent.outcome
    assert values["reason"] == told.reason
    assert values["time to goal"] == ("–" if agent.time_to_goal is None else f"{agent.time_to_goal:.2f} s")
    assert values["path"] == f"{agent.path_length:.2f} m"
    assert values["minimum clearance"] == "–"
    (link,) = root.iter("a")
    assert link.text == str(report)
    assert unquote(link.attrib["href"]) == report.as_posix()
    assert not set("#<>' ") & set(link.attrib["href"])
    assert root.findall("p")[-1].text == "no <disk>"
    assert "Report" not in rocs_bt.RunResult(summary=summary)._repr_html_()


def test_mistakes_are_told(names, tmp_path):
    result = names["result"]
    for ask, message in (
        (lambda: result.events("Nonsense"), "no type of event is named 'Nonsense'"),
        (lambda: result.events(agent="R9"), "no agent is named 'R9'"),
        (lambda: result.signals("R2", ["nonsense"]), "no signal is named 'nonsense'"),
        (lambda: rocs_bt.run("exp1", mode="nonsense"), "invalid value 'nonsense' for the option mode"),
        (lambda: rocs_bt.drive("exp1", view=True), "remove the option view"),
    ):
        with pytest.raises(InputError, match=message):
            ask()
    with pytest.raises(RecordingError, match="out=FOLDER"):
        rocs_bt.RunResult(summary=result.summary).events()
