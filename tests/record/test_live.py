"""The live page: one more sink, whose process shows a run in browsers and serves nobody else."""

import http.client
import json
import math
import re
import socket
from urllib.parse import urlsplit

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.errors import InputError
from rocs_bt.event import (
    Event,
    KnowledgeChanged,
    NodeTicked,
    OutcomeDecided,
    RuleChanged,
    SensorRead,
    SignalsWritten,
    SubtreeSwapped,
    pack,
)
from rocs_bt.record.header import BodyInfo, Fan
from rocs_bt.record.live import LivePage, frames
from rocs_bt.record.live import page as page_module
from rocs_bt.record.live.picture import Picture
from rocs_bt.record.live.server import Feed, Server

from ..waiting import GUARD, until
from . import synthetic

EVENTS = synthetic.events(4.0)


def fold(known: dict, news: dict) -> dict:
    """What a page makes of news: the page's own rules, written anew."""
    known["t"] = news.get("t", 0.0)
    for name, told in news.get("bodies", {}).items():
        body = known.setdefault("bodies", {}).setdefault(name, {})
        body["pose"] = told["pose"]
        body.setdefault("trail", []).extend(told.get("trail", []))
    for name, told in news.get("agents", {}).items():
        agent = known.setdefault("agents", {}).setdefault(name, {})
        if gone := told.pop("swapped", None):
            kept = agent.get("nodes", {})
            agent["nodes"] = {p: s for p, s in kept.items() if p != gone and not p.startswith(gone + "/")}
        for key, value in told.items():
            if isinstance(value, dict):
                agent.setdefault(key, {}).update(value)
            elif key in ("knowledge", "faults"):
                agent.setdefault(key, []).extend(value)
            else:
                agent[key] = value
        done = {n for n, k in agent.get("tickets", {}).items() if k[1] not in ("QUEUED", "RUNNING")}
        agent["tickets"] = {n: k for n, k in agent.get("tickets", {}).items() if n not in done}
    return known


def without_empty(agents: dict) -> dict:
    return {name: {k: v for k, v in agent.items() if v} for name, agent in agents.items()}


def shown(events: list[Event]) -> dict:
    picture = Picture()
    picture.begin(synthetic.header())
    picture.take(events)
    return json.loads(picture.whole())


@given(st.lists(st.integers(0, len(EVENTS)), max_size=8).map(sorted))
def test_whoever_comes_first_and_whoever_comes_last_see_the_same(cuts):
    swap = SubtreeSwapped(t=2.0, agent="R2", node="go to/GoTo", by="go to/Stop", nodes=(("go to", "Sequence", ""),))
    events = [*EVENTS[:900], swap, *EVENTS[900:]]
    picture = Picture()
    picture.begin(synthetic.header())
    known = json.loads(picture.whole())
    for begin, end in zip([0, *cuts], [*cuts, len(events)], strict=True):
        picture.take(events[begin:end])
        known = fold(known, json.loads(picture.delta()))
    whole = json.loads(picture.whole())
    assert without_empty(known["agents"]) == without_empty(whole["agents"])
    assert (known["bodies"], known["t"]) == (whole["bodies"], whole["t"])


def test_it_shows_what_a_run_has_to_tell():
    agent = shown(EVENTS)["agents"]["R2"]
    assert agent["nodes"]["go to"][0] == "RUNNING"
    assert len(agent["signals"]["pose"]) == 3
    assert "∞" in agent["signals"]["front"]
    assert agent["rules"]["avoid_collision/AvoidCollision"]["fired"] >= 1
    assert agent["knowledge"][0][2] == "origin"
    assert len(agent["ranges"]["sonar"]) == len(synthetic.ANGLES)
    assert agent["route"] in ("deliberative", "reactive")
    bodies = shown(EVENTS)["bodies"]
    assert {route for *_, route in bodies["R2"]["trail"]} == {"deliberative", "reactive"}
    assert {route for *_, route in bodies["R1"]["trail"]} == {""}


def test_the_last_scan_of_a_scanner_is_shown_too():
    fan = Fan(x=0.1, y=0.0, yaw=-1.0, step=1.0, rays=3, reach=10.0)
    picture = Picture()
    bodies = (BodyInfo(name="R2", hull=(), fans={"lidar": fan}),)
    picture.begin(msgspec.structs.replace(synthetic.header(), bodies=bodies))
    for values in ([1.0, 2.0, 3.0], [math.inf, 1.234, math.nan]):
        picture.take([SensorRead(t=1.0, agent="R2", sensor="lidar", stamp=1.0, data=pack(values))])
    told = json.loads(picture.whole())
    assert told["agents"]["R2"]["ranges"]["lidar"] == [None, 1.23, -1.0]
    assert told["run"]["bodies"][0]["fans"]["lidar"]["rays"] == 3


@pytest.mark.parametrize(
    ("phases", "latched", "active", "fired"),
    [
        (["latched"], True, False, 0),
        (["latched", "waits"], True, False, 0),
        (["latched", "fired"], True, True, 1),
        (["latched", "fired", "released"], False, True, 1),
        (["latched", "fired", "released", "ended"], False, False, 1),
        (["latched", "fired", "fired again"], True, True, 1),
        (["latched", "fired", "released", "latched"], True, True, 1),
    ],
)
def test_a_rules_latch_and_its_action_are_two_things(phases, latched, active, fired):
    events = [RuleChanged(t=1.0, agent="R2", rule="a/B", phase=p, priority=1, reading=f"r {p}") for p in phases]
    rule = shown(events)["agents"]["R2"]["rules"]["a/B"]
    assert (rule["latched"], rule["active"], rule["fired"]) == (latched, active, fired)


def test_numbers_that_json_lacks_are_shown_as_text():
    values = pack([math.inf, -math.inf, math.nan, 1 / 3])
    event = SignalsWritten(t=0.0, agent="R2", monitor="m", signals=("s",), sizes=(4,), data=values)
    known = KnowledgeChanged(t=0.0, agent="R2", what="attribute", subject="n", name="a", value=[math.nan, 1.0])
    agent = shown([event, known])["agents"]["R2"]
    assert agent["signals"]["s"] == ["∞", "−∞", "–", 0.33333]
    assert agent["knowledge"][0][4] == ["–", 1.0]


def test_a_trail_that_grows_for_hours_stays_small():
    moves = [msgspec.structs.replace(EVENTS[-1], t=float(i), x=0.02 * i) for i in range(20_000)]
    trail = shown(moves)["bodies"]["R1"]["trail"]
    assert 1000 < len(trail) <= 4001
    assert trail[-1][0] == pytest.approx(0.02 * 19_999)


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


def test_the_page_is_one_file_that_refers_to_nothing_outside(live):
    status, page, headers = get(live.url)
    assert status == 200
    assert "http:" not in page
    assert "https:" not in page
    assert "src=" not in page
    policy = headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "frame-ancestors 'none'" in policy
    nonce = re.search(r'<script nonce="([^"]+)"', page)[1]
    assert f"'nonce-{nonce}'" in policy
    assert headers["Referrer-Policy"] == "no-referrer"
    assert headers["Cache-Control"] == "no-store"


def test_only_who_has_the_token_gets_anything(live):
    token = urlsplit(live.url).path.strip("/")
    assert len(token) >= 20
    for path in ("/", "", "/events", f"/{token[:-1]}/", f"/{token}x/", f"/{token[:-1]}/events", "/%C3%A9/"):
        assert get(live.url, path=path)[0] == 403, path
    assert get(live.url, path=f"/{token}/other")[0] == 404
    assert get(live.url, path=f"/{token}/../events")[0] == 404
    assert get(live.url, method="POST")[0] == 501


def test_a_foreign_host_is_refused(live):
    port = urlsplit(live.url).port
    for host in ("evil.example", f"evil.example:{port}", "127.0.0.1", f"0.0.0.0:{port}", ""):
        assert get(live.url, host=host)[0] == 421, host
    assert get(live.url, host=f"localhost:{port}")[0] == 200


@pytest.mark.parametrize("host", ["0.0.0.0", "192.168.1.7", "::"])
def test_it_is_served_on_loopback_only(host):
    with pytest.raises(InputError, match=rf"{host} is no loopback address"):
        Server(host, 0, "token", Feed())
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
    """A stream's messages: kind and data."""
    parts = urlsplit(url)
    connection = http.client.HTTPConnection(parts.hostname, parts.port, timeout=GUARD)
    connection.request("GET", parts.path + "events")
    lines = connection.getresponse()
    while kind := lines.readline().decode():
        data = lines.readline().decode()
        lines.readline()
        yield kind.removeprefix("event: ").strip(), json.loads(data.removeprefix("data: "))


def whole_run(stream):
    """The first message that knows of the run: who comes at once may hear of it a moment later."""
    return next(data for kind, data in stream if kind == "whole" and "run" in data)


def test_a_browser_hears_everything_at_first_and_then_what_is_new():
    with LivePage() as page:
        page.begin(synthetic.header())
        page.emit(NodeTicked(t=0.5, agent="R2", node="go to", status="RUNNING"))
        stream = messages(page.url)
        whole = whole_run(stream)
        assert whole["run"]["scenario"] == "exp1"
        page.emit(NodeTicked(t=0.7, agent="R2", node="go to", status="SUCCESS"))
        while True:
            kind, news = next(stream)
            assert kind == "message"
            if news["agents"]["R2"]["nodes"]["go to"][0] == "SUCCESS":
                break
        assert news["t"] == 0.7


def test_what_was_emitted_last_is_sent_before_the_page_ends():
    with LivePage() as page:
        page.begin(synthetic.header())
        stream = messages(page.url)
        whole_run(stream)
        page.emit(OutcomeDecided(t=3.0, agent="R2", outcome="success"))
    ended = [data for _, data in stream if "outcome" in data.get("agents", {}).get("R2", {})]
    assert [data["agents"]["R2"]["outcome"] for data in ended] == [["success", "", None]]


def test_a_page_that_dies_holds_nobody_up():
    with LivePage() as page:
        page.begin(synthetic.header())
        page._process.kill()
        page._process.wait()
        for event in EVENTS:
            page.emit(event)
        until(lambda: not page._waiting)


def test_a_page_that_reads_nothing_for_long_is_given_up(monkeypatch):
    monkeypatch.setattr(page_module, "_BACKLOG", 5)
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


def test_a_browser_that_is_far_behind_is_let_go_and_gets_everything_when_it_comes_back():
    feed = Feed()
    feed.update(lambda picture: picture.begin(synthetic.header()), whole=True)
    slow, quick = feed.join(), feed.join()
    for event in EVENTS[:150]:
        feed.update(lambda picture, event=event: picture.take([event]))
        while not quick.empty():
            assert quick.get() is not None
    heard = [slow.get() for _ in range(slow.qsize())]
    assert heard[-1] is None
    assert json.loads(feed.join().get().split(b"data: ")[1]) == shown(EVENTS[:150])
