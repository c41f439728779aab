"""The report: one file that needs nothing else, and says what happened."""

import json
import math
import re
from collections import Counter

import msgspec
import pytest
from msgspec.structs import replace

from rocs_bt.event import (
    BlockFailed,
    ContactBegan,
    NodeTicked,
    OutcomeDecided,
    SensorFailed,
    SensorRead,
    SubtreeSwapped,
    pack,
)
from rocs_bt.record.header import BodyInfo, Fan
from rocs_bt.record.recorder import Recorder
from rocs_bt.record.recording import Recording
from rocs_bt.record.report import render_report, write_report

from . import synthetic


@pytest.fixture(scope="module")
def page(recording):
    return render_report(recording, recording.summary)


def data_of(page):
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)[1])


def test_it_is_one_file_that_refers_to_nothing_outside(page):
    without_names = re.sub(r'xmlns(:\w+)?="[^"]*"', "", page)
    assert "http:" not in without_names
    assert "https:" not in without_names
    assert not re.search(r"<(link|script|img|iframe)[^>]*\s(src|href)=\"(?!data:)", page)
    assert "@import" not in page
    assert not re.search(r"url\((?!#)", page)


def test_ids_exist_and_exist_once(page):
    ids = Counter(re.findall(r'\sid="([^"]+)"', page))
    assert [i for i, n in ids.items() if n > 1] == []
    wanted = set(re.findall(r'(?:xlink:)?href="#([^"]+)"', page)) | set(re.findall(r"url\(#([^)]+)\)", page))
    assert wanted
    assert wanted <= set(ids)


def test_it_says_what_happened_in_plain_words(page):
    assert "R2 reached its goal after 12.3 s." in page
    assert "The mission succeeded, and R2 stands 0.08 m from origin." in page
    assert page.count("<svg") == 4
    assert page.count("avoid_collision/AvoidCollision</td>") >= 2
    assert "rocs-bt run exp1 --seed 7" in page
    assert "mujoco 4.0.1" in page
    assert 'class="status SUCCESS"' in page
    assert "Faults of" not in page
    assert "cut off" not in page


def test_who_was_sent_to_no_goal_has_reached_none(recording):
    agents = {"R2": replace(recording.summary.agents["R2"], goals_reached=0)}
    page = render_report(recording, replace(recording.summary, agents=agents))
    assert "R2 fulfilled its mission after 12.3 s." in page
    assert "reached its goal" not in page


def test_the_animation_has_every_body_beam_and_route(page):
    data = data_of(page)
    assert [b["name"] for b in data["bodies"]] == ["R2", "R1"]
    assert all(len(b["t"]) == len(b["x"]) == len(b["yaw"]) == 400 for b in data["bodies"])
    (agent,) = data["agents"]
    (beams,) = agent["beams"]
    assert len(beams["beams"]) == 16
    assert len(beams["ranges"]) == len(beams["t"]) == 400
    assert len(agent["switches"]) == 4
    assert data["bounds"] == pytest.approx([-2.5, -2.5, 2.525, 2.525])


def test_a_scanners_scans_are_thinned_evenly(tmp_path):
    fan = Fan(x=0.12, y=0.0, yaw=-2.0, step=4.0 / 719, rays=720, reach=10.0)
    header = msgspec.structs.replace(
        synthetic.header(), bodies=(BodyInfo(name="R2", hull=synthetic.HULL, fans={"lidar": fan}),)
    )
    recorder = Recorder(tmp_path / "run.mcap", header)
    for k in range(1500):
        values = [math.inf, math.nan, *(float(ray) + 0.001 * k for ray in range(2, 720))]
        recorder.emit(SensorRead(t=0.05 * k + 0.01, agent="R2", sensor="lidar", stamp=0.05 * k, data=pack(values)))
    recorder.emit(SensorRead(t=80.0, agent="R2", sensor="lidar", stamp=80.0, data=pack([1.0] * 3)))  # of other rays
    recorder.close()
    data = data_of(render_report(Recording.open(tmp_path / "run.mcap"), None))
    (scans,) = data["agents"][0]["scans"]
    assert scans["fan"] == pytest.approx([0.12, 0.0, -2.0, 4 * 4.0 / 719, 10.0], abs=1e-6)
    assert scans["t"] == [round(0.05 * k, 3) for k in range(0, 1500, 3)]
    assert [len(row) for row in scans["ranges"]] == [180] * 500
    assert scans["ranges"][2][:3] == [None, 4.01, 8.01]
    assert data["agents"][0]["beams"] == []


def test_the_same_recording_gives_the_same_page(recording, page):
    assert render_report(recording, recording.summary) == page


def test_faults_and_a_cut_off_run_are_told(tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", synthetic.header())
    for event in [
        *synthetic.events(2.0),
        SensorFailed(t=2.0, agent="R2", sensor="sonar", detail="no answer"),
        BlockFailed(t=2.0, agent="R2", block="R2/analyze ranges", kind="hung", detail="0.2 s without a beat"),
        ContactBegan(t=2.0, agent="R2", other="R1", kind="struck"),
        NodeTicked(t=2.0, agent="R2", node="go to", status="FAILURE", feedback="</script><b>LOST_SENSOR"),
        SensorRead(t=2.0, agent="R2", sensor="sonar", stamp=2.0, data=pack([float("nan")] * 16)),
    ]:
        recorder.emit(event)
    recorder.close()
    path = tmp_path / "cut.mcap"
    path.write_bytes(recorder.path.read_bytes()[:-100])
    write_report(Recording.open(path), None, tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text()
    assert "The run ended without an outcome of R2" in page
    assert "this report, ends at 2.00 s" in page
    for text in ("sensor sonar failed: no answer", "block R2/analyze ranges hung", "struck by R1"):
        assert text in page
    assert "&lt;/script&gt;&lt;b&gt;LOST_SENSOR" in page
    assert "<b>LOST_SENSOR" not in page
    assert data_of(page)["agents"][0]["beams"][0]["ranges"][-1] == [-1] * 16


def test_after_a_swap_the_tree_that_came_is_shown(tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", synthetic.header())
    nodes = (("go to", "Sequence", ""), ("go to/goal known", "Known", "go to"), ("go to/Stop", "Act", "go to"))
    recorder.emit(NodeTicked(t=0.0, agent="R2", node="go to/GoTo", status="RUNNING"))
    ports = ("", '(node="a <b>")', "")
    recorder.emit(SubtreeSwapped(t=0.5, agent="R2", node="go to/GoTo", by="go to/Stop", nodes=nodes, ports=ports))
    recorder.emit(NodeTicked(t=0.6, agent="R2", node="go to/Stop", status="SUCCESS"))
    recorder.close()
    page = render_report(Recording.open(recorder.path), None)
    assert [n for n in ("GoTo", "Stop", "goal known") if f'data-node="go to/{n}"' in page] == ["Stop", "goal known"]
    assert data_of(page)["agents"][0]["leaves"] == [
        ["go to/goal known", 'goal known(node="a <b>")'],
        ["go to/Stop", "Stop"],
    ]
    assert '<b>goal known</b><span class="ports">(node=&#34;a &lt;b&gt;&#34;)</span>' in page


def test_without_a_summary_the_outcome_is_what_was_judged(tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", synthetic.header())
    recorder.emit(OutcomeDecided(t=9.0, agent="R2", outcome="stuck", reason="0.01 m in 15 s"))
    recorder.close()
    page = render_report(Recording.open(recorder.path), None)
    assert "R2 got stuck." in page
    assert "0.01 m in 15 s." in page


@pytest.mark.browser
def test_in_a_browser_the_slider_moves_the_picture_and_no_error_is_logged(browser, recording, tmp_path):
    write_report(recording, recording.summary, tmp_path / "report.html")
    browser.open((tmp_path / "report.html").as_uri())
    assert browser.evaluate("[...document.querySelectorAll('figure svg')].map(s => s.clientWidth > 200)") == [True] * 4

    def move(t):
        browser.evaluate(f"slider.value = {t}; slider.dispatchEvent(new Event('input'))")
        told = browser.evaluate(
            "[time.textContent, ...[...document.querySelectorAll('.state dd')].map(d => d.textContent)]"
        )
        return browser.evaluate("picture.toDataURL()"), told

    pictures, told = zip(*(move(t) for t in (0.0, 2.0, 6.0, 20.0)), strict=True)
    assert len(set(pictures)) == 4
    assert [row[0] for row in told] == ["0.00", "2.00", "6.00", "20.00"]
    assert [row[1] for row in told] == ['GoTo(goal="origin")'] * 3 + ["–"]
    assert [row[2] for row in told] == ["GoTo", "AvoidCollision", "GoTo", "–"]
    assert told[1][3].startswith("AvoidCollision: min(front) = 0.")
    assert [row[3] == "–" for row in told] == [True, False, True, True]
    assert browser.evaluate("document.querySelector('.state h3 span').textContent") == "idle"

    browser.evaluate("document.querySelector('.firings button.t').click()")
    assert browser.evaluate("time.textContent") == browser.evaluate(
        "document.querySelector('.firings button.t').textContent.split(' ')[0]"
    )
    browser.evaluate("slider.value = 0; slider.dispatchEvent(new Event('input')); play.click()")
    assert browser.evaluate("new Promise(r => setTimeout(() => r(Number(time.textContent)), 400))") > 0.0
    browser.evaluate("play.click()")
    stopped = browser.evaluate("time.textContent")
    assert browser.evaluate("new Promise(r => setTimeout(() => r(time.textContent), 100))") == stopped
    assert browser.errors == []
    assert [u for u in browser.requests if not u.startswith(("file:", "data:"))] == []


@pytest.mark.browser
def test_in_a_browser_a_scan_is_dots_where_its_echoes_are(browser, recording, tmp_path):
    """Of a robot that looks west, its eye 0.5 m ahead: to its right no echo, ahead a broken ray, to its left one."""
    write_report(recording, recording.summary, tmp_path / "report.html")
    browser.open((tmp_path / "report.html").as_uri())
    drawn = browser.evaluate("""(() => {
      const canvas = document.createElement("canvas"), holder = document.createElement("div");
      holder.style.width = "400px"; holder.append(canvas); document.body.append(holder);
      const arena = makeArena(canvas), dpr = devicePixelRatio || 1;
      arena.fit([-3, -3, 3, 3]);
      arena.drawScan([0.5, 0, -1, 1, 2], [null, -1, 1.25], { x: 0, y: 0, yaw: Math.PI });
      const seen = arena.g.getImageData(0, 0, canvas.width, canvas.height);
      const place = (x, y) => Math.round(dpr * arena.Y(y)) * seen.width + Math.round(dpr * arena.X(x));
      const inked = (yaw) => seen.data[4 * place(-0.5 + 1.25 * Math.cos(yaw), 1.25 * Math.sin(yaw)) + 3];
      return [inked(Math.PI + 1), inked(Math.PI - 1), inked(Math.PI)];
    })()""")
    echo, opposite, broken = drawn
    assert echo > 200
    assert opposite < 50
    assert broken == 0
    assert browser.errors == []


@pytest.mark.browser
def test_in_a_browser_it_fits_a_telephone_and_the_dark(browser, recording, tmp_path):
    write_report(recording, recording.summary, tmp_path / "report.html")
    browser.call("Emulation.setDeviceMetricsOverride", width=390, height=800, deviceScaleFactor=1, mobile=True)
    browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}])
    browser.open((tmp_path / "report.html").as_uri())
    assert browser.evaluate("document.documentElement.scrollWidth") <= 390
    paper, ink = browser.evaluate(
        "[getComputedStyle(document.body).backgroundColor, getComputedStyle(document.body).color]"
    )
    brightness = [sum(map(int, re.findall(r"\d+", c)[:3])) for c in (paper, ink)]
    assert brightness[0] < 150 < 600 < brightness[1]
    tick = browser.evaluate("getComputedStyle(document.querySelector('figure svg text')).fill")
    assert sum(map(int, re.findall(r"\d+", tick)[:3])) > 600
    browser.call("Emulation.setEmulatedMedia", features=[])
    browser.call("Emulation.clearDeviceMetricsOverride")
    assert browser.errors == []


@pytest.mark.browser
def test_in_a_browser_an_empty_run_is_no_error(browser, tmp_path):
    Recorder(tmp_path / "run.mcap", synthetic.header()).close()
    write_report(Recording.open(tmp_path / "run.mcap"), None, tmp_path / "report.html")
    browser.open((tmp_path / "report.html").as_uri())
    assert browser.evaluate("time.textContent") == "0.00"
    assert browser.errors == []


@pytest.mark.browser
def test_in_a_browser_the_play_button_is_on_the_first_screen(browser, recording, tmp_path):
    write_report(recording, recording.summary, tmp_path / "report.html")
    browser.call("Emulation.setDeviceMetricsOverride", width=1366, height=768, deviceScaleFactor=1, mobile=False)
    browser.open((tmp_path / "report.html").as_uri())
    assert browser.evaluate("document.querySelector('#play').getBoundingClientRect().bottom") < 768
    browser.call("Emulation.clearDeviceMetricsOverride")
    assert browser.errors == []
