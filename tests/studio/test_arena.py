"""The arena in a browser: bodies and their links in space, layers, a camera that follows, and no WebGL."""

import json

import msgspec
import pytest

from rocs_bt.event import BodyMoved, KnowledgeChanged, MapChanged, PathPlanned
from rocs_bt.record.file.header import BodyLink, BodyShape
from rocs_bt.record.file.recorder import Recorder
from rocs_bt.record.file.recording import Recording
from rocs_bt.studio.report import write_report

from .. import synthetic
from .test_page import click, faults, go, press, show, text, until

STILL, LEVEL, GREY = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), (0.5, 0.5, 0.5, 1.0)


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """Report of a walking robot: a box with a leg, a path, and a map that grows."""
    folder = tmp_path_factory.mktemp("arena")
    header = synthetic.header()
    shapes = (
        BodyShape(kind="box", size=(0.3, 0.2, 0.1), position=STILL, quaternion=LEVEL, tint=GREY),
        BodyShape(kind="capsule", size=(0.1, 0.6, 0.0), position=(0.0, 0.0, 0.6), quaternion=LEVEL, tint=GREY, link=1),
    )
    leg = BodyLink(parent=0, position=(0.3, 0.0, 0.0), quaternion=LEVEL, axis=(0.0, 1.0, 0.0))
    bodies = [
        msgspec.structs.replace(body, shapes=shapes, links=(leg,), beams={}, fans={}) if body.name == "R2" else body
        for body in header.bodies
    ]
    recorder = Recorder(folder / "run.mcap", msgspec.structs.replace(header, bodies=tuple(bodies)))
    recorder.emit(PathPlanned(t=0.0, agent="R2", points=((0.0, 0.0), (1.0, 1.0))))
    for step in range(4):
        recorder.emit(
            BodyMoved(t=step, body="R2", x=0.0, y=0.0, yaw=0.0, height=0.3, roll=0.0, pitch=0.0, joints=(step,))
        )
        cells = tuple((20 + i, 4 * step) for i in range(8))
        recorder.emit(MapChanged(t=step, agent="R2", cell=0.05, occupied=cells))
    recorder.close(synthetic.summary())
    write_report(Recording.open(recorder.path), synthetic.summary(), folder / "report.html")
    return folder / "report.html"


def picture(browser):
    """The stage as it is on the screen: the canvas of WebGL cannot be read after it was drawn."""
    box = browser.evaluate("JSON.stringify(document.querySelector('.stage').getBoundingClientRect())")
    clip = {key: value for key, value in json.loads(box).items() if key in ("x", "y", "width", "height")}
    browser.evaluate("document.querySelector('.layers').style.visibility = 'hidden'")
    browser.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    found = browser.call("Page.captureScreenshot", clip=clip | {"scale": 1})["data"]
    browser.evaluate("document.querySelector('.layers').style.visibility = ''")
    return found


def still(browser):
    """The picture when two in a row are alike: a busy machine draws a frame late."""
    last, now = "", picture(browser)
    while now != last:
        last, now = now, picture(browser)
    return now


@pytest.fixture
def wide(browser):
    browser.call("Emulation.setDeviceMetricsOverride", width=1366, height=768, deviceScaleFactor=1, mobile=False)
    yield browser
    browser.call("Emulation.clearDeviceMetricsOverride")


@pytest.mark.browser
def test_layers_joints_and_the_camera_change_the_picture(wide, file):
    browser = wide
    show(browser, file)
    until(browser, "document.querySelector('.flip')?.textContent")
    flipped = text(browser, ".flip")
    browser.evaluate("document.querySelector('.layers summary').click()")
    for flat in (True, False):
        if flat != (text(browser, ".flip") == "3D"):
            press(browser, "3")
        if browser.evaluate("document.querySelector('.flip').disabled"):
            continue  # this browser has no WebGL
        go(browser, 2.0)
        before = still(browser)
        for layer in ("planned path", "its own map"):
            click(browser, ".layers label", layer)
            assert still(browser) != before
            click(browser, ".layers label", layer)
            assert still(browser) == before
        press(browser, "c")
        assert browser.evaluate("document.querySelector('.layers button').getAttribute('aria-pressed')") == "true"
        assert still(browser) != before
        press(browser, "c")
        assert still(browser) == before
        go(browser, 3.0)
        assert still(browser) != before
    assert flipped == "2D"  # a robot that walks begins in space
    assert faults(browser) == []


@pytest.mark.browser
def test_without_webgl_the_arena_is_flat(browser, file, tmp_path):
    page = file.read_text("utf-8")
    crippled = tmp_path / "report.html"
    crippled.write_text(page, "utf-8")
    script = "const get = HTMLCanvasElement.prototype.getContext; HTMLCanvasElement.prototype.getContext = "
    script += "function (kind, ...rest) { return kind === 'webgl2' ? null : get.call(this, kind, ...rest); };"
    found = browser.call("Page.addScriptToEvaluateOnNewDocument", source=script)
    try:
        show(browser, crippled)
        until(browser, "document.querySelector('.flip')?.disabled")
        assert text(browser, ".flip") == "3D"
        assert "WebGL" in browser.evaluate("document.querySelector('.flip').title")
        assert browser.evaluate("document.querySelectorAll('.stage canvas:not([hidden])').length") == 1
    finally:
        browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=found["identifier"])


@pytest.mark.browser
def test_a_believed_mover_has_an_outline_and_an_arrow(wide, tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", synthetic.header())
    facts = {"pose": (1.0, 0.5, 0.4), "radius": 0.25, "speed": 0.6, "covariance": (0.01, 0.0, 0.0, 0.02)}
    recorder.emit(KnowledgeChanged(t=0.0, agent="R2", what="node added", subject="mover_1", name="object"))
    for name, value in facts.items():
        recorder.emit(KnowledgeChanged(t=0.0, agent="R2", what="attribute", subject="mover_1", name=name, value=value))
    for t, moves in ((0.0, False), (2.0, True)):
        recorder.emit(KnowledgeChanged(t=t, agent="R2", what="attribute", subject="mover_1", name="moves", value=moves))
    for step in range(4):
        recorder.emit(BodyMoved(t=step, body="R2", x=0.0, y=0.0, yaw=0.0, height=0.3, roll=0.0, pitch=0.0))
    recorder.close(synthetic.summary())
    write_report(Recording.open(recorder.path), synthetic.summary(), tmp_path / "report.html")
    show(wide, tmp_path / "report.html")
    until(wide, "document.querySelector('.flip')?.textContent")
    if text(wide, ".flip") == "2D":
        press(wide, "3")
    go(wide, 0.5)
    first = still(wide)
    go(wide, 1.5)
    assert still(wide) == first
    go(wide, 2.5)
    assert still(wide) != first
    assert faults(wide) == []
