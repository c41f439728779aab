"""The editor in a real browser: typing, completion, drag and drop, the form, undo, saving, a conflict, rule tests."""

from __future__ import annotations

import time

import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.cli.main import call
from rocs_bt.studio.authoring import edit_routes
from rocs_bt.studio.editing.worker import Worker
from rocs_bt.studio.server import Server

pytestmark = pytest.mark.browser

FILE = "planners/missions/mine.xml"
MISSION = """<root BTCPP_format="4">
  <!-- <b id="evil">names are text</b> -->
  <BehaviorTree ID="Main">
    <Sequence name="&lt;img src=x onerror=alert(1)&gt;">
      <!-- first -->
      <GoTo goal="gate"/>
      <Fallback>
        <GoTo goal="dock"/>
      </Fallback>
    </Sequence>
  </BehaviorTree>
</root>
"""
KEYS = {"Tab": 9, "Delete": 46, "ArrowUp": 38, "ArrowDown": 40}


@pytest.fixture(scope="module")
def yard(tmp_path_factory):
    folder = tmp_path_factory.mktemp("editor") / "yard"
    assert call(["new", str(folder)]) == 0
    return folder


@pytest.fixture(scope="module")
def site(yard):
    """Address of a server of the editor's files and requests."""
    worker = Worker()
    server = Server("127.0.0.1", 0, "token", edit_routes(Catalog(yard), worker))
    server.start()
    yield server.url
    worker.close()
    server.end()


class Page:
    """Page of the editor, with the hands of a person."""

    def __init__(self, browser, url):
        self.browser = browser
        browser.errors.clear()
        browser.call("Emulation.setDeviceMetricsOverride", width=1300, height=800, deviceScaleFactor=1, mobile=False)
        browser.evaluate("onbeforeunload = null; globalThis.editor && (editor.saved = editor.code.text)")
        browser.open(url)

    def __call__(self, script):
        return self.browser.evaluate(script)

    def until(self, script, seconds=30.0):
        """Wait until an expression is true."""
        end = time.monotonic() + seconds
        while not (value := self(script)):
            assert time.monotonic() < end, (script, self("document.body.innerText"), self.browser.errors)
            time.sleep(0.03)
        return value

    def drawn(self):
        """Wait until the tree is that of the text."""
        self.until("editor.drawn === editor.code.text")

    def key(self, key, *, alt=False, ctrl=False):
        code = {"Enter": 13, "Tab": 9, "Escape": 27, "Delete": 46, "ArrowUp": 38, "ArrowDown": 40}.get(
            key, ord(key[0].upper())
        )
        parameters = {"key": key, "windowsVirtualKeyCode": code, "modifiers": alt + 2 * ctrl}
        self.drawn()
        self.browser.call("Input.dispatchKeyEvent", type="keyDown", **parameters)
        self.browser.call("Input.dispatchKeyEvent", type="keyUp", key=key, modifiers=alt + 2 * ctrl)

    def type(self, text):
        self.browser.call("Input.insertText", text=text)

    def drag(self, start, end, part):
        """Drag one element to a height of another: 0 is its upper edge, 1 its lower one."""
        self.drawn()
        self(f"""(() => {{
          const from = document.querySelector({start!r}), to = document.querySelector({end!r});
          const box = to.getBoundingClientRect(), clientX = box.left + 30, clientY = box.top + {part} * box.height;
          const at = {{ bubbles: true, cancelable: true, dataTransfer: new DataTransfer(), clientX, clientY }};
          from.dispatchEvent(new DragEvent("dragstart", at));
          to.dispatchEvent(new DragEvent("dragover", at));
          to.dispatchEvent(new DragEvent("drop", at));
        }})()""")


@pytest.fixture
def page(browser, site, yard):
    (yard / FILE).write_text(MISSION, "utf-8")
    page = Page(browser, f"{site}edit?file={FILE}")
    page.until("document.querySelectorAll('.nodes li').length === 5 && editor.nodes.known")
    yield page
    assert browser.errors == []


TEXT = "editor.code.text"


def cursor(page, before):
    page(f"editor.code.area.focus(), editor.code.area.setSelectionRange(...Array(2).fill({TEXT}.indexOf({before!r})))")


def test_a_person_types_and_completes_and_faults_come_and_go(page, yard):
    assert page("document.querySelector('#evil, .nodes img')") is None
    cursor(page, '<GoTo goal="gate"')
    page.type("<Tu")
    page("editor.code.complete(null)")
    page.until("!document.querySelector('.proposals').hidden")
    assert page("document.querySelector('.proposals [aria-selected=true]').textContent").startswith("Turn")
    page.key("ArrowDown")
    page.key("Tab")
    assert page(f"/<Turn\\w+ /.test({TEXT})")
    page.until(f"editor.step(editor.past, editor.future), {TEXT} === {MISSION!r}")
    cursor(page, 'dock"')
    page.type("x ")
    page.until("!!document.querySelector('.nodes').textContent.includes('x dock')")
    page(f"editor.code.set({TEXT}.replace('x dock', 'dock').replaceAll('Fallback>', 'Falback>')), editor.change()")
    page.until("document.querySelector('.faults .error')?.textContent.includes(\"no node is named 'Falback'\")")
    assert page("document.querySelector('.nodes .wrong b').textContent") == "Falback"
    assert page("document.querySelector('.under mark.error').textContent") == "<Falback"
    page("document.querySelector('.faults .fix').click()")
    page.until(f"{TEXT}.includes('<Fallback>')")
    page("editor.saved = editor.code.text")
    assert (yard / FILE).read_text("utf-8") == MISSION


def test_the_tree_is_edited_by_drag_and_drop_and_by_keys(page):
    page.drag("[data-path='0/0/0/0']", "[data-path='0/0/0/1']", 0.5)
    moved = page.until(f"{TEXT} !== {MISSION!r} && {TEXT}")
    assert '<Fallback>\n        <GoTo goal="dock"/>\n        <!-- first -->\n        <GoTo goal="gate"/>\n' in moved
    page.key("z", ctrl=True)
    page.until(f"{TEXT} === {MISSION!r}")
    page.drag("[data-node='Sequence']", "[data-path='0/0/0/1']", 0.05)
    added = page.until(f"{TEXT} !== {MISSION!r} && {TEXT}")
    assert '<GoTo goal="gate"/>\n      <Sequence/>\n      <Fallback>' in added
    page("editor.step(editor.past, editor.future)")
    page.until(f"{TEXT} === {MISSION!r}")
    page("document.querySelector('.nodes').focus(), editor.nodes.choose('0/0/0/0')")
    page.key("ArrowDown", alt=True)
    page.until(f"{TEXT}.indexOf('gate') > {TEXT}.indexOf('dock')")
    page.key("ArrowUp", alt=True)
    page.until(f"{TEXT} === {MISSION!r}")
    page.key("Delete")
    page.until(f"!{TEXT}.includes('gate') && !{TEXT}.includes('first')")


def test_a_port_is_set_in_the_form_and_only_its_line_changes(page):
    page("document.querySelector(\"[data-path='0/0/0/0']\").click()")
    page.until("!!document.querySelector('.ports [name=cruise]')")
    assert page("document.querySelector('.ports [name=cruise]').placeholder") == "0.5 m/s"
    page("document.querySelector('.ports [name=cruise]').focus()")
    page.type('1 "m/s"')
    page.key("Tab")
    page.until(f"{TEXT}.includes('cruise=')")
    was, now = MISSION.split("\n"), page(TEXT).split("\n")
    assert [i for i, (a, b) in enumerate(zip(was, now, strict=True)) if a != b] == [5]
    page.until("!!document.querySelector('.faults .error')")


def test_saving_and_a_conflict(page, yard):
    cursor(page, "<GoTo goal")
    page.type("<Wait/>")
    page.key("s", ctrl=True)
    page.until("document.querySelector('output').textContent === 'saved'")
    mine = (yard / FILE).read_text("utf-8")
    assert mine == MISSION.replace("<GoTo goal", "<Wait/><GoTo goal", 1)
    (yard / FILE).write_text(MISSION + "<!-- theirs -->\n", "utf-8")
    page.type("<Wait/>")
    page.key("s", ctrl=True)
    page.until("!!document.querySelector('dialog')")
    assert "theirs" in page("[...document.querySelectorAll('dialog ins')].map((e) => e.textContent).join()")
    assert (yard / FILE).read_text("utf-8").endswith("<!-- theirs -->\n")
    page(
        "[...document.querySelectorAll('dialog button')].find((b) => b.textContent === 'Take that of the disk').click()"
    )
    page.until(f"{TEXT}.endsWith('<!-- theirs -->\\n')")
    page.until("document.querySelector('output').textContent === 'saved'")


def test_rule_tests_run_as_one_types_and_a_phone_shows_all(page, site, yard):
    page.browser.open(f"{site}edit?file=rules/keep_clear.toml")
    page.until("!!document.querySelector('.tests .passed')")
    page("editor.code.set(editor.code.text.replace('0.25 m, max', '0.2 m, max')), editor.change()")
    page.until("!!document.querySelector('.tests .failed')")
    page("editor.saved = editor.code.text")
    for file in ("rules/keep_clear.toml", FILE):
        page.browser.call(
            "Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=1, mobile=False
        )
        page.browser.open(f"{site}edit?file={file}")
        page.until("!!document.querySelector('.faults li')")
        assert page("document.documentElement.scrollWidth") <= 390
        sizes = "[...document.querySelectorAll('body *')].map((e) => parseFloat(getComputedStyle(e).fontSize))"
        assert page(f"Math.min(...{sizes})") >= 11
