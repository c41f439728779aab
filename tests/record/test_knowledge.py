"""What an agent knew, as a change log, a picture and a page."""

from __future__ import annotations

import json
import re
import sqlite3
import xml.etree.ElementTree as ET

import pytest

from rocs_bt.clock import SimulatedClock
from rocs_bt.errors import InputError, RecordingError
from rocs_bt.event import BodyMoved, KnowledgeChanged, NullSink
from rocs_bt.geometry import Pose2
from rocs_bt.knowledge import KnowledgeGraph
from rocs_bt.knowledge.history import History, Journal, State, log_of
from rocs_bt.record.knowledge import draw, learnt, recorded_log, render_knowledge
from rocs_bt.record.knowledge.drawing import CROWD, layout, picture
from rocs_bt.record.knowledge.page import thinned
from rocs_bt.record.recorder import Recorder
from rocs_bt.record.recording import Recording

from .. import synthetic

EVIL = "</script><b>&'\""


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """A recording and a journal of the same graph, which changes for two seconds; and the graph."""
    folder = tmp_path_factory.mktemp("told")
    clock, recorder = SimulatedClock(0.05), Recorder(folder / "run.mcap", synthetic.header())
    graph = KnowledgeGraph(clock, recorder, "R2")
    with Journal(folder / "knowledge.sqlite", "exp1-7", blocking=True) as journal:
        journal.attach(graph)
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
    return folder, graph


@pytest.fixture(scope="module")
def logs(told):
    folder, _ = told
    with History(folder / "knowledge.sqlite") as history:
        return recorded_log(Recording.open(folder)), history


def everything(state):
    nodes = {n: (state.kind(n), state.attributes(n)) for n in state.nodes()}
    return nodes, {e: state.edge(*e) for e in state.edges()}


def test_a_recording_and_a_journal_hold_the_same(told, logs):
    _, graph = told
    one, two = logs
    for t in (0.0, 0.49, 0.5, 1.0, 1.5, 2.0, None):
        assert everything(one.as_of(t)) == everything(two.as_of(t))
    assert everything(one.as_of()) == everything(graph)


def test_a_recorded_log_ends_with_the_run_and_not_with_its_newest_change(tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", synthetic.header())
    KnowledgeGraph(SimulatedClock(0.05), recorder, "R2").add("R2", "robot")
    recorder.emit(BodyMoved(t=7.5, agent="R2", body="R2", x=0.0, y=0.0, yaw=0.0, wheels=b""))
    recorder.close()
    log = recorded_log(Recording.open(tmp_path))
    assert (log.begin, log.end) == (0.0, 7.5)


def test_a_gap_in_a_journal_is_told_and_the_state_after_it_is_right(tmp_path):
    graph = KnowledgeGraph(SimulatedClock(0.05), NullSink(), "R2")
    graph.add("R2", "robot")
    path = tmp_path / "k.sqlite"
    with Journal(path, limit=2, every=0.001) as journal:
        journal.attach(graph)
        graph.add("gone", "object")
        journal.flush()
        other = sqlite3.connect(path, isolation_level=None)
        other.execute("BEGIN IMMEDIATE")
        for count in range(20):
            graph.add(f"o{count}", "object")
        graph.remove("gone")
        other.execute("COMMIT")
        other.close()
    with History(path) as history:
        assert history.gaps
    assert everything(history.as_of()) == everything(graph)
    after = State("R2")
    for change in history.all_changes():
        after.apply(change)
    assert everything(after) == everything(graph)
    assert "are missing" in render_knowledge(history)


def test_who_is_meant_must_be_said_and_exist(recording, tmp_path):
    with pytest.raises(InputError, match=r"'R7'.*R2"):
        recorded_log(recording, "R7")
    nothing = Recorder(tmp_path / "run.mcap", synthetic.header())
    nothing.close()
    with pytest.raises(RecordingError, match="no changes of the knowledge of R2"):
        recorded_log(Recording.open(tmp_path))


def test_a_state_alone_is_a_log_too(told):
    _, graph = told
    log = log_of(State.of(graph), "export")
    assert everything(log.as_of()) == everything(graph)
    assert learnt(log.all_changes(), log.begin) == []


def test_what_was_learnt_is_told_once_with_its_beginning_and_its_end(logs):
    rows = {(r.subject, r.what): r for r in learnt(logs[0].all_changes(), 0.0)}
    assert ("origin", "pose") not in rows
    assert ("R2", "pursues origin") not in rows
    box = rows["box", "object"]
    assert (box.first, box.last, box.count, box.begin, box.end) == ("exists", "exists", 3, 0.5, 1.5)
    near = rows["R2", "near box"]
    assert (near.first, near.last, near.count) == ("distance 1", "no", 2)
    distance = rows["box", "distance"]
    assert (distance.first, distance.last, distance.count) == ("1.5", "4", 6)


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
    _, graph = told
    root = ET.fromstring(draw(graph, "R2"))
    space = {"s": "http://www.w3.org/2000/svg"}
    assert len(root.findall(".//s:g[@class='node']", space)) == len(graph.nodes())
    assert len(root.findall(".//s:g[@class='edge']", space)) == len(graph.edges())
    assert "crowd" not in root.get("class", "")
    many = {f"n{i}": "object" for i in range(CROWD + 1)}
    loop = [("n1", "near", "n1"), ("n1", "near", "n2"), ("n2", "near", "n1")]
    assert "crowd" in ET.fromstring(picture(many, loop, "nobody")).get("class", "")


def test_the_page_is_one_file_and_no_text_breaks_out_of_it(logs):
    page = render_knowledge(logs[1])
    assert not re.search(r"<(link|script|img|iframe)[^>]*\s(src|href)=\"(?!data:)", page)
    assert "</script><b>" not in page
    data = json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)[1])
    assert [name for name, _ in data["nodes"]] == ["R2", "origin", "box", EVIL]
    assert data["units"]["object"]["distance"] == "m"


def test_thinning_leaves_out_only_what_was_overwritten_soon():
    changes = [
        KnowledgeChanged(t=i * 1e-3, agent="R2", what="attribute", subject="box", name="radius", value=i, revision=i)
        for i in range(20_000)
    ]
    node = KnowledgeChanged(t=5.0, agent="R2", what="node added", subject="x", name="object", revision=5001)
    few = thinned([*changes[:5000], node, *changes[5000:]], 1000)
    assert 400 < len(few) < 1000
    assert node in few
    assert few[-1] == changes[-1]
    assert [c.revision for c in few if c is not node] == sorted(c.revision for c in few if c is not node)
    assert thinned(changes, 20_000) == changes


@pytest.mark.browser
def test_in_a_browser_one_searches_and_moves_in_time(browser, logs, tmp_path):
    page = tmp_path / "knowledge.html"
    page.write_text(render_knowledge(logs[1]), encoding="utf-8")
    browser.open(page.as_uri())
    shown = "[...document.querySelectorAll('.node:not(.gone) title')].map((t) => t.textContent.split(',')[0])"
    assert browser.evaluate(shown)[:3] == ["R2", "origin", "box"]

    def at(t: float) -> None:
        browser.evaluate(f"window.slider.value = {t}; window.slider.dispatchEvent(new Event('input'))")

    at(0.3)
    assert browser.evaluate(shown) == ["R2", "origin"]
    assert browser.evaluate("document.querySelectorAll('.edge:not(.gone)').length") == 1
    at(0.6)
    assert browser.evaluate(shown) == ["R2", "origin", "box"]
    assert browser.evaluate("document.querySelectorAll('.edge:not(.gone)').length") == 2
    browser.evaluate("window.search.value = 'radius 0.2'; window.search.dispatchEvent(new Event('input'))")
    assert browser.evaluate("document.querySelectorAll('.node.hit').length") == 1
    browser.evaluate("document.querySelector('#hits button').click()")
    card = browser.evaluate("document.getElementById('card').textContent")
    assert card.startswith("boxobjectradius0.2 m0.50 s")
    assert "near R2 (distance 1)" in card
    at(2.0)
    assert "radius" not in browser.evaluate("document.getElementById('card').textContent")
    browser.evaluate("document.querySelector('[data-kind=goal]').click()")
    assert "origin" not in browser.evaluate(shown)
    assert browser.errors == []
    assert [r for r in browser.requests if not r.startswith(("file:", "data:"))] == []
