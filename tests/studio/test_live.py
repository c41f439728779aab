"""The live page: one more sink, whose process shows a run in browsers and serves nobody else."""

import http.client
import json
import math
import re
import socket
from urllib.parse import urlsplit

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt import run
from rocs_bt.base.errors import InputError
from rocs_bt.event import (
    KnowledgeChanged,
    NodeTicked,
    OutcomeDecided,
    SensorRead,
    SignalsWritten,
    SubtreeSwapped,
    TreeNode,
    pack,
)
from rocs_bt.record import Recording
from rocs_bt.record.explanation.comparisons import Comparisons
from rocs_bt.record.file.header import BodyInfo, Fan
from rocs_bt.record.fold.tracks import Tracks
from rocs_bt.studio import frames
from rocs_bt.studio import live as live_module
from rocs_bt.studio import pack as packing
from rocs_bt.studio.feed import Feed, Seen
from rocs_bt.studio.live import LivePage
from rocs_bt.studio.server import Server

from .. import synthetic
from ..pages import steps as steps_of
from ..pages import unpacked
from ..waiting import GUARD, until

EVENTS = synthetic.events(4.0)


def fold(known, message):
    """What a page makes of a message: the page's own rules, written anew."""
    known["end"], news = message["end"], message["tracks"]
    known["log"] += message["log"]
    known["decisive"] = message.get("decisive", known["decisive"])
    for address, first, t, v, width, ray in news:
        times, values = known["tracks"].setdefault(address, ([], [], width, ray))[:2]
        del times[first:], values[first:]
        times += t
        values += v
    return known


def heard(feed, seen, known):
    message = feed.fresh(seen)
    return known if message is None else fold(known, json.loads(message))


def empty():
    return {"end": 0.0, "log": [], "tracks": {}, "decisive": []}


@given(st.lists(st.integers(0, len(EVENTS)), max_size=8).map(sorted))
def test_the_first_browser_and_the_last_one_get_the_same(cuts):
    swap = SubtreeSwapped(
        t=2.0, agent="R2", node="go to/GoTo", by="go to/Stop", nodes=(TreeNode(path="go to", type="Sequence"),)
    )
    events = [*EVENTS[:900], swap, *EVENTS[900:]]
    feed, seen, known = Feed(), Seen(), empty()
    feed.begin(synthetic.header())
    for begin, end in zip([0, *cuts], [*cuts, len(events)], strict=True):
        feed.take(events[begin:end])
        known = heard(feed, seen, known)
    feed.close()
    known = heard(feed, seen, known)
    assert known == heard(feed, Seen(), empty())
    (node,) = known["tracks"]["R2|tree|"][1][-1]
    assert (node["path"], node["type"], node["children"]) == ("go to", "Sequence", [])


def test_scans_that_are_thinned_arrive_as_in_the_tracks():
    fan = Fan(x=0.1, y=0.0, yaw=-1.0, step=1.0, rays=3, reach=10.0)
    bodies = (BodyInfo(name="R2", hull=(), fans={"lidar": fan}),)
    feed, seen, known = Feed(), Seen(), empty()
    feed.begin(msgspec.structs.replace(synthetic.header(), bodies=bodies))
    for k in range(5_000):
        values = pack([float(k), math.inf, math.nan])
        feed.take([SensorRead(t=0.05 * k, agent="R2", sensor="lidar", stamp=0.0, data=values)])
        if k % 7 == 0:
            known = heard(feed, seen, known)
            assert known["tracks"]["R2|scan|lidar"][1][-1] == [float(k), "∞", "NaN"]
    assert heard(feed, seen, known)["tracks"] == heard(feed, Seen(), empty())["tracks"]
    assert json.loads(feed.head())["header"]["bodies"][0]["fans"]["lidar"]["rays"] == 3


def test_what_is_sent_is_what_the_run_has_to_tell():
    feed = Feed()
    assert feed.head() == b"null"
    feed.begin(synthetic.header())
    feed.take(EVENTS)
    tracks = heard(feed, Seen(), empty())["tracks"]
    assert tracks["R2|node|go to"][1][-1] == "RUNNING"
    assert len(tracks["R2|signal|pose"][1][-1]) == 3
    assert any("∞" in row for row in tracks["R2|signal|front"][1])
    assert tracks["R2|rule|avoid_collision/AvoidCollision"][1][-1]["fired"] >= 1
    assert tracks["R2|fact|origin"][1] == ["goal"]
    assert len(tracks["R2|scan|sonar"][1][-1]) == len(synthetic.ANGLES)
    assert {"deliberative", "reactive"} <= set(tracks["R2|route|"][1])
    assert len(tracks["R1|pose|"][0]) == len(tracks["R2|pose|"][0])


def test_numbers_that_json_lacks_are_texts():
    values = pack([math.inf, -math.inf, math.nan, 1 / 3])
    event = SignalsWritten(t=0.0, agent="R2", monitor="m", signals=("s",), sizes=(4,), data=values)
    known = KnowledgeChanged(t=0.0, agent="R2", what="attribute", subject="n", name="a", value=[math.nan, 1.0])
    feed = Feed()
    feed.begin(synthetic.header())
    feed.take([event, known])
    tracks = heard(feed, Seen(), empty())["tracks"]
    assert tracks["R2|signal|s"][1] == [["∞", "−∞", "NaN", 0.33333]]
    assert tracks["R2|fact|n\na"][1] == [["NaN", 1.0]]


def at(times, values, t):
    """Values of a step function at times; None before its first."""
    found = np.searchsorted(times, t + 1e-3, side="right") - 1
    return [values[i] if i >= 0 else None for i in found]


def real(row):
    return [{"NaN": math.nan, "∞": math.inf, "−∞": -math.inf}.get(value, value) for value in row]


def events_of(name, tmp_path):
    """Header and events of a run; of `dead`, a sensor that ends, one that stops for a while, and one that is late."""
    run("exp1" if name == "dead" else name, seed=1, duration=4.0, out=tmp_path, report=False)
    recording = Recording.open(tmp_path)
    events = list(recording.events())
    if name == "dead":
        lost = {"range": lambda t: t > 2.0, "wheels": lambda t: 0.5 < t < 1.2, "pose": lambda t: t > 3.8}
        events = [
            e for e in events if not isinstance(e, SignalsWritten) or not lost.get(e.monitor, lambda t: False)(e.t)
        ]
    return recording.header, events


@pytest.mark.parametrize("name", ["exp1", "exp3", "exp1_quadruped", "dead"])
def test_the_live_page_has_at_the_end_what_the_report_has(name, tmp_path):
    header, events = events_of(name, tmp_path)
    whole = Tracks(header)
    whole.take(events)
    Comparisons(whole).update(over=True)
    about, column = unpacked(packing.pack(whole, {"decisive": packing.opens_at(whole)}))
    feed, seen, known = Feed(), Seen(), empty()
    feed.begin(header)
    for i in range(0, len(events), 173):
        feed.take(events[i : i + 173])
        known = heard(feed, seen, known)
    feed.close()
    known = heard(feed, seen, known)
    head = json.loads(feed.head())
    assert {name: head[name] for name in ("header", "inactive")} == {
        name: about[name] for name in ("header", "inactive")
    }
    assert known["log"] == about["log"]
    assert known["decisive"] == about["decisive"]
    assert known["tracks"].keys() == {address for address, *_ in about["tracks"]}
    for address, kind, t, v, *_ in about["tracks"]:
        (times, rows), values = steps_of(column, t, v), known["tracks"][address]
        when = np.linspace(0.0, known["end"], 101)
        got = at(np.array(values[0]), values[1], when)
        if kind == "text":
            texts = [about["texts"][int(i)] for i in rows[:, 0]]
            shared = (
                [{**text, "parameters": texts[0]["parameters"]} for text in texts] if "|ticket|" in address else texts
            )
            assert got == at(times, shared, when), address
            continue
        for a, b in zip(got, at(times, rows, when), strict=True):
            assert (a is None) == (b is None), address
            assert a is None or np.allclose(real(a), b, rtol=1e-3, atol=1.1e-2, equal_nan=True), (address, a, b)


def test_an_event_that_is_no_data_is_left_out():
    wrong = KnowledgeChanged(t=0.0, agent="R2", what="attribute", subject="n", name="a", value=object())
    data = frames.encode_events([EVENTS[0], wrong, EVENTS[1]])[4:]
    assert frames.decode_events(data) == EVENTS[:2]


def get(url: str, *, method: str = "GET", path: str | None = None, host: str | None = None):
    """One request: its status and text, and its headers."""
    parts = urlsplit(url)
    connection = http.client.HTTPConnection(parts.hostname, parts.port, timeout=GUARD)
    connection.putrequest(method, parts.path if path is None else path, skip_host=True)
    connection.putheader("Host", parts.netloc if host is None else host)
    connection.endheaders()
    answer = connection.getresponse()
    return answer.status, answer.read().decode() if answer.length != 0 else "", dict(answer.headers)


def test_the_page_refers_to_its_own_server_only(live):
    status, page, headers = get(live.url)
    assert status == 200
    assert "http:" not in page
    assert "https:" not in page
    assert re.findall(r'(?:src|href)="([^"]+)"', page) == ["studio.css", "app.js"]
    policy = headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "script-src 'self'" in policy
    assert "frame-ancestors 'none'" in policy
    assert headers["Referrer-Policy"] == "no-referrer"
    assert headers["Cache-Control"] == "no-store"


@pytest.mark.parametrize("host", ["0.0.0.0", "192.168.1.7", "::"])
def test_it_is_served_on_loopback_only(host):
    with pytest.raises(InputError, match=rf"{host} is no loopback address"):
        Server(host, 0, "token", {})
    with pytest.raises(InputError, match="other machines could reach"), LivePage(host=host):
        pass


def test_a_port_that_is_taken_is_told(live):
    port = urlsplit(live.url).port
    with pytest.raises(InputError, match=rf"port {port} is not available.*--port"), LivePage(port):
        pass


def test_a_live_page_shows_one_run(live):
    with pytest.raises(InputError, match="shows one run"):
        live.begin(synthetic.header())
    with pytest.raises(InputError, match="shows one run"):
        LivePage().begin(synthetic.header())


def messages(url: str):
    """Messages of a stream."""
    parts = urlsplit(url)
    connection = http.client.HTTPConnection(parts.hostname, parts.port, timeout=GUARD)
    connection.request("GET", parts.path + "events")
    lines = connection.getresponse()
    while line := lines.readline().decode():
        if line.startswith("data: ") and line != "data: {}\n":
            yield json.loads(line.removeprefix("data: "))


def test_a_browser_hears_everything_at_first_and_then_what_is_new():
    with LivePage() as page:
        page.begin(synthetic.header())
        page.emit(NodeTicked(t=0.5, agent="R2", node="go to", status="RUNNING"))
        stream, known = messages(page.url), empty()
        while "R2|node|go to" not in known["tracks"]:
            fold(known, next(stream))
        page.emit(NodeTicked(t=0.7, agent="R2", node="go to", status="SUCCESS"))
        while known["end"] < 0.7:
            news = next(stream)
            fold(known, news)
        assert [track[:4] for track in news["tracks"]] == [["R2|node|go to", 1, [0.7], ["SUCCESS"]]]


def test_what_was_emitted_last_is_sent_before_the_page_ends():
    with LivePage() as page:
        page.begin(synthetic.header())
        stream = messages(page.url)
        known = fold(empty(), next(stream))
        page.emit(OutcomeDecided(t=3.0, agent="R2", outcome="success"))
    for message in stream:
        fold(known, message)
    assert known["tracks"]["R2|outcome|"][1][-1]["outcome"] == "success"


def test_a_page_that_dies_holds_nobody_up():
    with LivePage() as page:
        page.begin(synthetic.header())
        page._process.kill()
        page._process.wait()
        for event in EVENTS:
            page.emit(event)
        until(lambda: not page._waiting)


def test_a_page_that_reads_nothing_for_long_is_given_up(monkeypatch):
    monkeypatch.setattr(live_module, "_BACKLOG", 5)
    with LivePage() as page:
        for event in EVENTS[:7]:
            page.emit(event)
        assert list(page._waiting) == EVENTS[2:7]
        page.begin(synthetic.header())
        assert page.wait() is False  # its process was ended


def test_a_browser_that_reads_nothing_does_not_keep_the_page_open():
    with LivePage() as page, socket.create_connection(("127.0.0.1", urlsplit(page.url).port)) as deaf:
        page.begin(synthetic.header())
        parts = urlsplit(page.url)
        deaf.sendall(f"GET {parts.path}events HTTP/1.1\r\nHost: {parts.netloc}\r\n\r\n".encode())
        assert deaf.recv(1)
        text = "x" * 16_000_000  # more than both ends of the connection can hold
        page.emit(KnowledgeChanged(t=0.1, agent="R2", what="attribute", subject="box", name="text", value=text))
        process = page._process
        page.__exit__(None, None, None)
        assert process.poll() is not None
