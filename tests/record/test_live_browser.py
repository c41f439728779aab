"""The live page in a browser."""

import json
import math
from contextlib import contextmanager

import msgspec
import pytest

from rocs_bt.event import (
    BlockFailed,
    BodyMoved,
    NodeTicked,
    OutcomeDecided,
    SensorRead,
    SubtreeSwapped,
    TicketChanged,
    pack,
)
from rocs_bt.record.header import AgentInfo, BodyInfo, Fan, RunHeader, TreeNode
from rocs_bt.record.live import LivePage

from . import synthetic

EVENTS = synthetic.events(4.0)


def until(browser, script: str):
    """Wait until an expression in the page is true."""
    found = browser.evaluate(
        f"new Promise((yes) => {{ const end = Date.now() + 20000; const look = () => ({script}) ? yes(true) : "
        "Date.now() > end ? yes(false) : setTimeout(look, 30); look(); })"
    )
    assert found, script


def faults(browser) -> list[str]:
    """What the page complained of; that a wrong token was refused is no fault."""
    return [error for error in browser.errors if "403 (Forbidden)" not in error]


@contextmanager
def shown(browser):
    """A live page. The browser leaves it before its server ends: who loses it goes on looking for it."""
    with LivePage() as page:
        try:
            yield page
        finally:
            browser.open("about:blank")


def row(path: str) -> str:
    return f"document.querySelector('[data-node=\"{path}\"]')"


def cell(signal: str) -> str:
    return f"document.querySelector('[data-signal={signal}] .v').textContent"


@pytest.mark.browser
def test_in_a_browser_the_run_goes_on_before_ones_eyes(browser):
    with shown(browser) as page:
        browser.open(page.url)
        assert browser.evaluate("link.textContent") == "waiting"
        page.begin(synthetic.header())
        for event in EVENTS:
            page.emit(event)
        until(browser, "link.textContent === 'live' && Number(time.textContent) >= 3.95")
        assert browser.evaluate("title.textContent") == "R2 is running"
        assert browser.evaluate(f"{row('go to/GoTo')}.innerText").startswith("RUNNING")
        assert browser.evaluate(f"{row('go to/goal known')}.innerText").startswith("SUCCESS")
        assert 'GoTo(goal="origin") Act' in browser.evaluate(f"{row('go to/GoTo')}.textContent")
        assert browser.evaluate("document.querySelector('.state [data-is=node]').textContent") == 'GoTo(goal="origin")'
        assert browser.evaluate("document.querySelector('[data-rule] .reading').textContent").startswith("min(front)")
        assert browser.evaluate(cell("wheel_speeds")).count(",") == 1
        assert "origin" in browser.evaluate("document.querySelector('.log').textContent")
        before = browser.evaluate("picture.toDataURL()"), browser.evaluate(cell("pose"))
        for event in synthetic.events(6.0)[len(EVENTS) :]:
            page.emit(event)
        page.emit(NodeTicked(t=6.0, agent="R2", node="go to/GoTo", status="FAILURE", feedback="the way is shut"))
        page.emit(BlockFailed(t=6.0, agent="R2", block="plan", kind="raised", detail="<b>no</b>"))
        until(browser, f"{row('go to/GoTo')}.innerText.startsWith('FAILURE')")
        assert "the way is shut" in browser.evaluate(f"{row('go to/GoTo')}.textContent")
        assert "<b>no</b>" in browser.evaluate("document.querySelector('.agent .faults').textContent")
        assert (browser.evaluate("picture.toDataURL()"), browser.evaluate(cell("pose"))) != before
        nodes = (("go to", "Sequence", ""), ("go to/goal known", "Known", "go to"), ("go to/Stop", "Act", "go to"))
        page.emit(
            SubtreeSwapped(t=6.1, agent="R2", node="go to/GoTo", by="go to/Stop", nodes=nodes, ports=("", "", "(x)"))
        )
        until(browser, f"{row('go to/GoTo')} === null && {row('go to/Stop')}.innerText.startsWith('idle')")
        assert "Stop(x)" in browser.evaluate(f"{row('go to/Stop')}.textContent")
        page.emit(TicketChanged(t=6.2, agent="R2", ticket=9, action="Stop", priority="NORMAL", state="RUNNING", by="x"))
        until(browser, "document.querySelector('.state [data-is=action]').textContent.includes('Stop')")
        page.emit(OutcomeDecided(t=6.3, agent="R2", outcome="success", time_to_goal=6.3))
        until(browser, "link.textContent === 'ended' && title.textContent === 'R2: success'")
        browser.open(page.url)  # who comes after the end sees it all
        until(browser, "link.textContent === 'ended' && Number(time.textContent) === 6.3")
        assert browser.evaluate(f"{row('go to/goal known')}.innerText").startswith("SUCCESS")
        assert faults(browser) == []
        assert [u for u in browser.requests if not u.startswith((page.url, "file:", "data:", "about:"))] == []


@pytest.mark.browser
def test_in_a_browser_a_scan_is_drawn(browser):
    fan = Fan(x=0.1, y=0.0, yaw=-1.0, step=0.5, rays=5, reach=3.0)
    with shown(browser) as page:
        browser.open(page.url)
        page.begin(
            msgspec.structs.replace(synthetic.header(), bodies=(BodyInfo(name="R2", hull=(), fans={"lidar": fan}),))
        )
        page.emit(BodyMoved(t=0.1, body="R2", x=0.0, y=0.0, yaw=0.0))
        until(browser, "Number(time.textContent) >= 0.1")
        before = browser.evaluate("picture.toDataURL()")
        page.emit(
            SensorRead(t=0.2, agent="R2", sensor="lidar", stamp=0.2, data=pack([1.0, 1.5, math.inf, math.nan, 2.0]))
        )
        until(browser, "Number(time.textContent) >= 0.2")
        until(browser, f"picture.toDataURL() !== {json.dumps(before)}")
    assert faults(browser) == []


@pytest.mark.browser
def test_in_a_browser_a_wrong_token_shows_nothing(browser, live):
    browser.open(live.url[:-2] + "/")
    assert "403" in browser.evaluate("document.body.textContent")
    assert browser.evaluate("document.getElementById('picture')") is None


@pytest.mark.browser
def test_in_a_browser_it_fits_a_telephone_and_the_dark(browser):
    browser.call("Emulation.setDeviceMetricsOverride", width=390, height=800, deviceScaleFactor=1, mobile=True)
    browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}])
    with shown(browser) as page:
        page.begin(synthetic.header())
        for event in EVENTS:
            page.emit(event)
        browser.open(page.url)
        until(browser, "Number(time.textContent) >= 3.95")
        assert browser.evaluate("document.documentElement.scrollWidth") <= 390
        paper = browser.evaluate("getComputedStyle(document.body).backgroundColor")
        assert sum(map(int, paper.removeprefix("rgb(").removesuffix(")").split(","))) < 100
    browser.call("Emulation.setEmulatedMedia", features=[])
    browser.call("Emulation.clearDeviceMetricsOverride")
    assert faults(browser) == []


def large(count: int) -> RunHeader:
    """A mission of `count` groups of nine leaves each."""
    groups = [f"top/group {i}" for i in range(count)]
    nodes = [TreeNode(path="top", type="Sequence", children=tuple(groups))]
    for group in groups:
        leaves = tuple(f"{group}/leaf {k}" for k in range(9))
        nodes += [
            TreeNode(path=group, type="Fallback", children=leaves),
            *(TreeNode(path=p, type="Act") for p in leaves),
        ]
    info = AgentInfo(name="R2", robot="pioneer_p3dx", mission="large", nodes=tuple(nodes))
    return msgspec.structs.replace(synthetic.header(), agents=(info,))


@pytest.mark.browser
@pytest.mark.parametrize("count", [100, 1000])
def test_in_a_browser_a_tree_of_any_size_is_drawn_and_walked_with_the_keyboard(browser, count):
    with shown(browser) as page:
        page.begin(large(count))
        browser.open(page.url)
        for i in range(count):
            page.emit(NodeTicked(t=0.1, agent="R2", node=f"top/group {i}/leaf 0", status="SUCCESS"))
        page.emit(NodeTicked(t=0.2, agent="R2", node=f"top/group {count - 2}/leaf 5", status="RUNNING"))
        until(browser, "Number(time.textContent) === 0.2")
        assert browser.evaluate("document.querySelector('[data-is=count]').textContent") == f"{10 * count + 1} nodes"
        # What runs has been scrolled into sight, and only what is in sight is in the page.
        assert browser.evaluate(f"{row(f'top/group {count - 2}/leaf 5')}.innerText").startswith("RUNNING")
        assert browser.evaluate("document.querySelectorAll('.row').length") < 60
        assert browser.evaluate("document.querySelector('.map').hidden") is False
        browser.evaluate("document.querySelector('.rows').focus()")
        for key in ("Home", "ArrowDown", "ArrowLeft", "ArrowDown"):
            for kind in ("keyDown", "keyUp"):
                browser.call("Input.dispatchKeyEvent", type=kind, key=key)
        active = "document.querySelector('.rows').getAttribute('aria-activedescendant')"
        at = f"document.getElementById({active}).dataset.node"
        assert browser.evaluate(at) == "top/group 1"  # group 0 is folded
        assert browser.evaluate(f"{row('top/group 0/leaf 0')}") is None
    assert faults(browser) == []
