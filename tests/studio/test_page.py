"""The page in a browser: one cursor and one selection for everything; as a report, and while a run goes on."""

import json
import math
import re
import subprocess

import numpy as np
import pytest

from rocs_bt.event import BlockFailed, ContactBegan, NodeTicked, OutcomeDecided, SensorFailed, SensorRead, pack
from rocs_bt.record.explanation.comparisons import Comparisons
from rocs_bt.record.file.recorder import Recorder
from rocs_bt.record.file.recording import Recording
from rocs_bt.record.fold.track import Curve, Scans
from rocs_bt.record.fold.tracks import Tracks
from rocs_bt.running import summary_of
from rocs_bt.studio import pack as packing
from rocs_bt.studio.live import LivePage
from rocs_bt.studio.page import WEB
from rocs_bt.studio.report import render_report, write_report

from .. import needs, synthetic
from ..pages import steps, unpacked

NOT_FAULTS = ("403 (Forbidden)", "WebGL", "GPU stall")  # of the browser, not of the page


def faults(browser):
    return [error for error in browser.errors if not any(text in error for text in NOT_FAULTS)]


def test_what_is_packed_is_what_the_tracks_have(recording):
    tracks = Tracks(recording.header)
    tracks.take(recording.events())
    Comparisons(tracks).update(over=True)
    about, column = unpacked(packing.pack(tracks, {}))
    packed = {address: rest for address, *rest in about["tracks"]}
    assert set(packed) == {packing.address(key) for key, _ in tracks.items() if key.topic not in packing.HIDDEN}
    for key, track in tracks.items():
        if key.topic in packing.HIDDEN:
            continue
        kind, t, v, *rest = packed[packing.address(key)]
        times, rows = steps(column, t, v)
        for when in np.linspace(0.0, tracks.end, 23):
            i = np.searchsorted(times, when + 1e-6, side="right") - 1
            if i < 0:
                continue
            if kind == "text":
                first, found = (about["texts"][int(rows[k, 0])] for k in (0, i))
                if key.topic == "ticket":  # the first value has the parameters of all
                    found = found | {"parameters": first["parameters"]}
                assert found == json.loads(packing.text(track.at(when)))
                continue
            assert isinstance(track, Curve)
            assert rows.shape[1] == rest[0]
            exact, span = np.array(track.at(when)), np.ptp(np.append(rows[np.isfinite(rows)], 0.0))
            close = max(1e-3 * span, 1.1e-2 if isinstance(track, Scans) else 6e-4)
            assert np.allclose(rows[i], exact, rtol=0.0, atol=close, equal_nan=True), key


def test_a_report_is_one_file_that_refers_to_nothing_outside_and_the_same_each_time(recording):
    page = render_report(recording, recording.summary)
    assert page == render_report(recording, recording.summary)
    assert not re.search(r"<(link|script|img|iframe)[^>]*\s(src|href)=", page)
    assert not re.findall(r"https?://|@import|url\(", page)
    assert page.count("<script") == 4
    assert "$" not in re.search(r"<title>(.*)</title>", page)[1]


STYLE = (WEB / "studio.css").read_text("utf-8")
TEXTS = ("ink", "muted", "good", "bad", "reactive", "deliberative", "note", "belief", "actor", "twin")
GROUNDS = ("paper", "raised", "select", "fresh")


def luminance(tint):
    digits = tint.lstrip("#")
    parts = [int(digits[i : i + n], 16) / (16**n - 1) for n in [len(digits) // 3] for i in range(0, 3 * n, n)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


@pytest.mark.parametrize("theme", [0, 1], ids=["light", "dark"])
def test_every_text_has_enough_contrast_on_every_ground(theme):
    tints = dict(re.findall(r"--([a-z]+): (#[0-9a-f]+)", STYLE.split(":root {")[1 + theme].split("}")[0]))
    assert len(tints) > 20
    for text, ground in [(t, g) for t in TEXTS for g in GROUNDS]:
        low, high = sorted((luminance(tints[text]), luminance(tints[ground])))
        least = 4.5 if ground in ("paper", "raised") or text in ("ink", "muted", "bad") else 4.0
        assert (high + 0.05) / (low + 0.05) >= least, f"{text} on {ground}"


def test_text_has_sizes_of_the_scale_only_and_none_below_11_pixels():
    scale = re.findall(r"--(?:small|text|large): (\d+)px", STYLE)
    assert sorted(map(int, scale)) == [11, 13, 15]
    assert all(size.startswith(("var(--", "inherit")) for size in re.findall(r"\bfont(?:-size)?: ([^;}]*)", STYLE))
    for module in WEB.glob("*.js"):
        assert all(int(size) >= 11 for size in re.findall(r"face\(g, (\d+)", module.read_text("utf-8")))


def test_no_key_has_two_meanings():
    modules = "".join((WEB / name).read_text("utf-8") for name in ("app.js", "control.js"))
    keys = re.findall(r'"([^"]+)"', "".join(re.findall(r"keys: \[(.*?)\]", modules)))
    assert len(keys) > 20
    assert sorted(set(keys)) == sorted(keys)


def test_the_types_of_every_module_are_checked():
    assert [m.name for m in WEB.glob("*.js") if not m.read_text("utf-8").startswith("// @ts-check")] == []


def test_modules_have_the_types_that_they_declare():
    tsc = needs.program("tsc", "checks the types of TypeScript")
    found = subprocess.run([tsc, "-p", WEB / "jsconfig.json"], capture_output=True, text=True, timeout=120)
    assert found.stdout == ""


@pytest.fixture
def opened(browser, recording, tmp_path):
    write_report(recording, recording.summary, tmp_path / "report.html")
    show(browser, tmp_path / "report.html")
    yield browser
    assert faults(browser) == []
    assert [url for url in browser.requests if not url.startswith(("file:", "data:"))] == []


def until(browser, script):
    """Wait until an expression in the page is true."""
    found = browser.evaluate(
        f"new Promise((yes) => {{ const end = Date.now() + 20000; const look = () => ({script}) ? yes(true) : "
        "Date.now() > end ? yes(false) : setTimeout(look, 30); look(); })"
    )
    assert found, script


def show(browser, file):
    """Open a report, and wait until it is shown."""
    browser.open(file.as_uri())
    until(browser, "document.querySelector('header')")


def click(browser, selector, beginning):
    """Click the first of some elements whose text begins like this."""
    script = f"[...document.querySelectorAll({json.dumps(selector)})].find((e) => e.innerText.trim().startsWith"
    browser.evaluate(f"{script}({json.dumps(beginning)})).click()")


def go(browser, t):
    browser.evaluate(f"location.hash = 't={t}'; new Promise((r) => setTimeout(r, 60))")


def text(browser, selector):
    return browser.evaluate(f"document.querySelector({json.dumps(selector)}).innerText")


def picture(browser):
    return browser.evaluate("document.querySelector('.stage canvas:not([hidden])').toDataURL()")


def press(browser, key):
    for kind in ("keyDown", "keyUp"):
        browser.call("Input.dispatchKeyEvent", type=kind, key=key, text=key if len(key) == 1 else "")


@pytest.mark.browser
class TestReport:
    def test_one_cursor_moves_arena_tree_inspector_and_log(self, opened):
        pictures, told = set(), []
        for t in (0.0, 2.0, 6.0, 20.0):
            go(opened, t)
            pictures.add(picture(opened))
            told.append((text(opened, ".clock"), text(opened, ".tree li:last-child").split()[0]))
        assert len(pictures) == 4
        assert [clock for clock, _ in told] == ["0.00 s", "2.00 s", "6.00 s", "20.00 s"]
        assert told[0][1] == "▶"

    def test_it_opens_at_the_first_reflex_with_its_rule_selected(self, opened):
        fired = opened.evaluate("document.querySelector('.inspector h3').textContent")
        assert fired == "AvoidCollision"
        assert "because the rule AvoidCollision fired" in text(opened, ".inspector .cause")
        assert opened.evaluate("document.querySelector('.label.selected').innerText").startswith("AvoidCollision")

    def test_a_click_selects_everywhere(self, opened):
        opened.evaluate("document.querySelector('.tree li:last-child').click()")
        assert text(opened, ".inspector h3") == "GoTo"
        assert "selected" in opened.evaluate("document.querySelector('.tree li:last-child').className")
        click(opened, ".row.link", "sent")
        assert text(opened, ".inspector h3").startswith("GoTo #")

    def test_the_keyboard_is_enough(self, opened):
        press(opened, "Home")
        start = text(opened, ".clock")
        press(opened, "ArrowRight")
        assert (start, text(opened, ".clock")) == ("0.00 s", "0.05 s")
        press(opened, ".")
        assert opened.evaluate("document.querySelector('.log .here time').textContent") + " s" == text(opened, ".clock")
        press(opened, " ")
        until(opened, "parseFloat(document.querySelector('.clock').textContent) > 1")
        press(opened, " ")
        press(opened, "/")
        assert opened.evaluate("document.activeElement.placeholder").startswith("search signals")

    def test_knowledge_and_signals_are_those_of_the_cursor(self, opened):
        click(opened, ".tabs button", "knowledge")
        go(opened, 20)
        assert "origin" in text(opened, ".knowledge")
        click(opened, ".tabs button", "signals")
        click(opened, ".signals label", "pose")
        assert "pose" in text(opened, ".labels")

    def test_a_telephone_and_the_dark(self, browser, recording, tmp_path):
        write_report(recording, recording.summary, tmp_path / "report.html")
        browser.call("Emulation.setDeviceMetricsOverride", width=390, height=800, deviceScaleFactor=1, mobile=True)
        browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}])
        show(browser, tmp_path / "report.html")
        wide = browser.evaluate("document.documentElement.scrollWidth")
        style = "getComputedStyle(document.body)"
        paper, ink = browser.evaluate(f"[{style}.backgroundColor, {style}.color]")
        browser.call("Emulation.setEmulatedMedia", features=[])
        browser.call("Emulation.clearDeviceMetricsOverride")
        brightness = [sum(map(int, re.findall(r"\d+", c)[:3])) for c in (paper, ink)]
        assert brightness[0] < 150 < 600 < brightness[1]
        assert wide <= 390
        assert faults(browser) == []


@pytest.mark.browser
def test_a_run_that_failed_opens_on_the_cause_and_names_are_text(browser, tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", synthetic.header())
    for event in [
        *synthetic.events(2.0),
        SensorFailed(t=2.0, agent="R2", sensor="sonar", detail="no answer"),
        BlockFailed(t=2.0, agent="R2", block="R2/analyze ranges", kind="hung", detail="0.2 s without a beat"),
        ContactBegan(t=2.0, agent="R2", other="R1", kind="struck"),
        NodeTicked(t=2.0, agent="R2", node="go to/GoTo", status="FAILURE", feedback="</script><b>LOST_SENSOR"),
        SensorRead(t=2.0, agent="R2", sensor="sonar", stamp=2.0, data=pack([math.nan] * 16)),
        OutcomeDecided(t=2.0, agent="R2", outcome="failed", reason="the mission failed"),
    ]:
        recorder.emit(event)
    recorder.close()
    path = tmp_path / "cut.mcap"
    path.write_bytes(recorder.path.read_bytes()[:-100])
    write_report(Recording.open(path), None, tmp_path / "report.html")
    show(browser, tmp_path / "report.html")
    assert text(browser, ".inspector h3") == "GoTo"
    assert "FAILURE" in text(browser, ".inspector")
    assert "</script><b>LOST_SENSOR" in text(browser, ".inspector")
    assert text(browser, ".badge") == "failed"
    browser.evaluate("document.querySelector('.badge').click()")
    assert text(browser, ".inspector h3") == "R2: failed"
    assert "killed" in text(browser, ".cut")
    for line in ("sensor sonar failed: no answer", "block R2/analyze ranges hung", "struck by R1"):
        assert line in text(browser, ".log")
    assert faults(browser) == []


@pytest.mark.browser
def test_an_outcome_that_only_the_summary_has_is_shown(browser, tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", synthetic.header())
    for event in synthetic.events(2.0):
        recorder.emit(event)
    recorder.close()
    recording = Recording.open(recorder.path)
    write_report(recording, summary_of(recording), tmp_path / "report.html")
    show(browser, tmp_path / "report.html")
    assert text(browser, ".badge") == "interrupted"
    browser.evaluate("document.querySelector('.badge').click()")
    assert text(browser, ".inspector h3") == "R2: interrupted"
    assert "without an outcome" in text(browser, ".inspector")
    assert faults(browser) == []


@pytest.mark.browser
def test_a_run_without_an_event_is_no_error(browser, tmp_path):
    Recorder(tmp_path / "run.mcap", synthetic.header()).close()
    write_report(Recording.open(tmp_path / "run.mcap"), None, tmp_path / "report.html")
    show(browser, tmp_path / "report.html")
    assert text(browser, ".clock") == "0.00 s"
    assert faults(browser) == []


@pytest.mark.browser
def test_the_arena_is_wide_enough_for_places(browser):
    run = "{ header: { places: [{ x: 3, y: -4, radius: 0.5 }, { x: 0, y: 0 }] }, get: () => null }"
    with LivePage() as page:
        browser.open(page.url)
        bounds = browser.evaluate(f"import('./arena.js').then((m) => m.Arena.prototype.bounds.call({{ run: {run} }}))")
        browser.open("about:blank")
    assert bounds == [0.0, -4.5, 3.5, 0.0]


@pytest.mark.browser
def test_a_run_that_goes_on_is_followed_and_can_be_scrubbed_back(browser):
    events = synthetic.events(4.0)
    with LivePage() as page:
        browser.open(page.url)
        assert "Waiting" in text(browser, "#app")
        page.begin(synthetic.header())
        for event in events[: len(events) // 2]:
            page.emit(event)
        until(browser, "parseFloat(document.querySelector('.clock')?.textContent) > 1.5")
        assert text(browser, ".head") == "live"
        press(browser, "Home")
        assert text(browser, ".clock") == "0.00 s"
        for event in events[len(events) // 2 :]:
            page.emit(event)
        until(browser, "document.querySelector('.time').textContent.endsWith(' 4.0 s')")
        assert text(browser, ".clock") == "0.00 s"  # it stays where its reader is
        browser.evaluate("document.querySelector('.head').click()")
        until(browser, "parseFloat(document.querySelector('.clock').textContent) > 3.9")
        assert text(browser, ".tree li:last-child").startswith("▶")
        browser.open("about:blank")
    assert faults(browser) == []
