"""What an agent knew, as a change log, a picture and a page."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError, RecordingError
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import BodyMoved, Fanout
from rocs_bt.knowledge import KnowledgeGraph
from rocs_bt.knowledge.history import ChangeLog, GraphState
from rocs_bt.record.file.recorder import Recorder
from rocs_bt.record.file.recording import Recording
from rocs_bt.record.knowledge import draw, recorded_log
from rocs_bt.record.knowledge.drawing import CROWD, layout, picture

from .. import synthetic

EVIL = "</script><b>&'\""


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """A recording of a graph that changes for two seconds; and the graph."""
    folder = tmp_path_factory.mktemp("told")
    clock, recorder = SimulatedClock(0.05), Recorder(folder / "run.mcap", synthetic.header())
    log = ChangeLog(GraphState("R2"))
    graph = KnowledgeGraph(clock, Fanout(recorder, log), "R2")
    graph.add("R2", "robot")
    graph.add("origin", "goal", pose=Pose2(0.0, 0.0))
    graph.relate("R2", "pursues", "origin")
    for count in range(41):
        if count == 10:
            graph.add("box", "object", radius=0.2)
            graph.relate("R2", "near", "box", distance=1.0)
        if count > 10 and count % 5 == 0:
            graph.set("box", distance=count * 0.1)
        if count == 30:
            graph.remove("box")
            graph.add("box", "object")
        clock.advance()
    graph.add(EVIL, "object")
    recorder.close()
    return folder, graph, log


def everything(state):
    nodes = {n: (state.kind(n), state.attributes(n)) for n in state.nodes()}
    return nodes, {e: state.edge(*e) for e in state.edges()}


def test_a_recording_holds_what_the_log_of_the_run_held(told):
    folder, graph, log = told
    recorded = recorded_log(Recording.open(folder))
    for t in (0.0, 0.49, 0.5, 1.0, 1.5, 2.0, None):
        assert everything(recorded.as_of(t)) == everything(log.as_of(t))
    assert everything(recorded.as_of()) == everything(graph)


def test_a_recorded_log_ends_with_the_run_and_not_with_its_newest_change(tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", synthetic.header())
    KnowledgeGraph(SimulatedClock(0.05), recorder, "R2").add("R2", "robot")
    recorder.emit(BodyMoved(t=7.5, agent="R2", body="R2", x=0.0, y=0.0, yaw=0.0, wheels=b""))
    recorder.close()
    log = recorded_log(Recording.open(tmp_path))
    assert (log.begin, log.end) == (0.0, 7.5)


def test_who_is_meant_must_be_said_and_exist(recording, tmp_path):
    with pytest.raises(InputError, match=r"'R7'.*R2"):
        recorded_log(recording, "R7")
    nothing = Recorder(tmp_path / "run.mcap", synthetic.header())
    nothing.close()
    with pytest.raises(RecordingError, match="no changes of the knowledge of R2"):
        recorded_log(Recording.open(tmp_path))


def test_a_state_alone_is_a_log_too(told):
    _, graph, _ = told
    state = GraphState.of(graph)
    log = ChangeLog(state, "export")
    assert everything(log.as_of()) == everything(graph)
    assert (log.begin, log.end) == (state.t, state.t)
    assert log.all_changes()[0].what == "node added"
    assert {c.t for c in log.all_changes()} == {state.t}


def test_every_node_stands_apart_from_every_other():
    kinds = {"R2": "robot", **{f"n{i}": f"k{i % 7}" for i in range(300)}}
    places = layout(kinds, [("R2", f"n{i}") for i in range(0, 300, 2)], "R2")
    assert places.keys() == kinds.keys()
    points = [*places.values()]
    nearest = min((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 for i, a in enumerate(points) for b in points[:i])
    assert nearest**0.5 > 40.0
    assert places["R2"] == (0.0, 0.0)
    assert layout(kinds, [("R2", f"n{i}") for i in range(0, 300, 2)], "R2") == places


def test_the_picture_is_well_formed_and_has_everything(told):
    _, graph, _ = told
    root = ET.fromstring(draw(graph, "R2"))
    space = {"s": "http://www.w3.org/2000/svg"}
    assert len(root.findall(".//s:g[@class='node']", space)) == len(graph.nodes())
    assert len(root.findall(".//s:g[@class='edge']", space)) == len(graph.edges())
    assert "crowd" not in root.get("class", "")
    many = {f"n{i}": "object" for i in range(CROWD + 1)}
    loop = [("n1", "near", "n1"), ("n1", "near", "n2"), ("n2", "near", "n1")]
    assert "crowd" in ET.fromstring(picture(many, loop, "nobody")).get("class", "")
