"""A run that is watched: the same run, on a live page and in Groot2's log."""

from __future__ import annotations

from pathlib import Path

import pytest
from py_trees.behaviour import Behaviour

from rocs_bt import run
from rocs_bt.base.errors import InputError
from rocs_bt.catalog import Catalog
from rocs_bt.event import ListSink, NodeTicked, SubtreeSwapped, TicketChanged
from rocs_bt.plan import Mission
from rocs_bt.record import Recording
from rocs_bt.studio.live import LivePage


def test_a_run_that_is_watched_is_the_same_run(catalog: Catalog, tmp_path: Path) -> None:
    plain = run("exp1", catalog, duration=0.5, out=tmp_path / "plain", report=False)
    with LivePage() as page:
        watched = run("exp1", catalog, duration=0.5, out=tmp_path / "live", report=False, live=page, btlog=True)
    assert watched.summary.trajectory_hash == plain.summary.trajectory_hash
    recordings = [Recording.open(tmp_path / name / "run.mcap") for name in ("plain", "live")]
    told = [[(type(e), e.t, e.agent) for e in recording.events()] for recording in recordings]
    assert told[0] == told[1]
    assert (tmp_path / "live" / "R2.btlog").read_bytes().startswith(b"BTCPP4-FileLogger2\x01")
    assert not list((tmp_path / "plain").glob("*.btlog"))


def test_a_log_of_an_earlier_run_does_not_stay_beside_another(catalog: Catalog, tmp_path: Path) -> None:
    run("exp1", catalog, duration=0.1, out=tmp_path, report=False, btlog=True)
    run("exp1", catalog, duration=0.1, out=tmp_path, report=False)
    assert not list(tmp_path.glob("*.btlog"))


def test_the_same_run_writes_the_same_log(catalog: Catalog, tmp_path: Path) -> None:
    logs = []
    for turn in ("1", "2"):
        run("exp1", catalog, duration=1.0, out=tmp_path / turn, report=False, btlog=True)
        logs.append((tmp_path / turn / "R2.btlog").read_bytes())
    assert logs[0] == logs[1]


def test_a_subtree_is_swapped_while_the_robot_drives(catalog: Catalog, tmp_path: Path) -> None:
    given: list[Mission] = []

    def build(mission: Mission) -> Behaviour:
        given.append(mission)
        with pytest.raises(InputError, match="no running tree yet"):
            mission.swap("drive", mission.wait(1.0))
        return mission.act("GoTo", goal="goal", name="drive")

    def progress(t: float) -> None:
        if abs(t - 0.4) < 1e-9:
            given[0].swap("drive", given[0].wait("0.2 s", name="rest"))

    told = ListSink()
    run(
        "exp1", catalog, missions={"R2": build}, progress=progress, sinks=[told], out=tmp_path, btlog=True, duration=1.0
    )
    (swap,) = (e for e in told.events if isinstance(e, SubtreeSwapped))
    assert (swap.node, swap.by) == ("drive", "rest")
    assert [(node.path, node.type) for node in swap.nodes] == [("rest", "Wait")]
    ended = [e for e in told.events if isinstance(e, TicketChanged) and e.priority == "NORMAL"][-1]
    assert (ended.action, ended.state, ended.by) == ("GoTo", "CANCELLED", "drive")
    assert ("rest", "SUCCESS") in [(e.node, e.status) for e in told.events if isinstance(e, NodeTicked)]
    assert sorted(p.name for p in tmp_path.glob("*.btlog")) == ["R2-2.btlog", "R2.btlog"]
