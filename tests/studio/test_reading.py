"""Reading a run in the page: a planted fault, a large mission, many robots, two runs, and pages without a run."""

import itertools
import json
import re

import pytest

import rocs_bt
from rocs_bt.base.errors import Fault
from rocs_bt.event import BlackboardChanged, KnowledgeChanged, NodeTicked, OutcomeDecided, RuleChanged, TreeNode
from rocs_bt.record.explanation.diverge import first_differences
from rocs_bt.record.file.header import AgentInfo, BodyInfo, RunHeader
from rocs_bt.record.file.recorder import Recorder
from rocs_bt.record.file.recording import Recording
from rocs_bt.record.fold.tracks import Tracks
from rocs_bt.studio.report import render_knowledge, render_tree, write_report

from ..pages import data_of, resize
from .test_page import click, faults, go, press, show, text, until

pytestmark = [pytest.mark.browser, pytest.mark.usefixtures("screen")]


def explained(browser):
    """Whether the page says which comparison kept the rule from firing, in its unit."""
    return "'speed > 0.6 m/s' does not hold by 0.1 m/s" in text(browser, ".inspector")


def each(browser, selector, expression="e.innerText"):
    """Value of an expression of each element `e`."""
    return browser.evaluate(f"[...document.querySelectorAll({json.dumps(selector)})].map((e) => {expression})")


class TestPlantedFault:
    def test_it_is_explained_where_the_page_opens_and_in_two_clicks_in_full(self, browser, touched):
        show(browser, touched)
        assert text(browser, ".inspector h3") == "R2: collision"
        assert explained(browser)
        click(browser, ".row.link", "TurnAway")
        assert text(browser, ".inspector h3") == "TurnAway"
        assert explained(browser)
        lanes = each(browser, ".label.inner")
        assert any("speed > 0.6 m/s" in lane and "0.5 | 0.6 m/s" in lane for lane in lanes)
        assert "0.1 m/s off" in browser.evaluate("document.querySelector('.label.selected').innerText")
        assert faults(browser) == []

    def test_the_keyboard_alone_finds_it(self, browser, touched):
        show(browser, touched)
        press(browser, "Home")
        press(browser, "f")
        each(browser, ".row.link", "e.innerText.includes('TurnAway') && e.focus()")
        browser.call("Input.dispatchKeyEvent", type="keyDown", key="Enter")
        assert text(browser, ".inspector h3") == "TurnAway"
        assert explained(browser)
        press(browser, "?")
        assert "decisive moment" in text(browser, "dialog[open]")
        browser.evaluate("document.querySelector('dialog[open]').close()")
        assert faults(browser) == []

    @pytest.mark.parametrize(("width", "height", "scale"), [(390, 844, 2), (683, 384, 2), (1920, 1080, 1)])
    def test_nothing_overflows_on_any_screen(self, browser, touched, width, height, scale):
        """Of a screen of 1366 by 768 pixels, 683 by 384 are seen at 200 % zoom."""
        resize(browser, width, height, scale)
        show(browser, touched)
        assert explained(browser)
        assert browser.evaluate("document.documentElement.scrollWidth") <= width
        right = "e.getClientRects().length ? e.getBoundingClientRect().right : 0"
        assert max(each(browser, "header *, .tabs, .tools, .row, .label, .inspector h3", right)) <= width + 1
        assert min(each(browser, "#app *", "parseFloat(getComputedStyle(e).fontSize)")) >= 11
        assert faults(browser) == []

    def test_each_thing_has_one_sentence_and_no_line_twice(self, browser, touched):
        """Also things that have no track, such as a node that was never ticked."""
        show(browser, touched)
        browser.evaluate("history.replaceState = () => {}; true")  # the page must not change the address between two
        tracks = data_of(touched)["tracks"]
        addresses = {track[0].rsplit("|", 1)[0]: track[0] for track in tracks}.values()  # one of each topic
        for address in [*addresses, "R2|rule|avoid_collision/None", "R2|node|none", "R2|alternation|", "R1|pose|", ""]:
            for t in (0.0, 1.3):
                browser.evaluate(
                    f"location.hash = new URLSearchParams({{ t: {t}, agent: 'R2', select: {json.dumps(address)} }})"
                )
                until(browser, f"document.querySelector('.clock').textContent === '{t:.2f} s'")
                assert len(each(browser, ".inspector .cause")) == 1, address
                assert text(browser, ".inspector h3").strip()
                rows = [*each(browser, ".inspector .row", "e.textContent"), text(browser, ".inspector .cause")]
                assert len(rows) == len(set(rows)), (address, t)
                assert not any(word in row for row in rows for word in ("undefined", "NaN", "[object"))
        assert faults(browser) == []

    def test_on_a_telephone_the_reason_timeline_and_arena_are_on_the_first_screen(self, browser, touched):
        resize(browser, 390, 844, 2)
        show(browser, touched)
        assert explained(browser)
        tops = [
            each(browser, part, "e.getBoundingClientRect().top")[0] for part in (".inspector", ".timeline", ".stage")
        ]
        assert tops == sorted(tops)
        assert tops[1] < 844 / 2
        assert tops[2] < 844 * 0.8

    def test_what_a_reader_takes_along(self, browser, touched):
        show(browser, touched)
        browser.evaluate("URL.createObjectURL = (blob) => { window.saved = blob; return 'data:,'; }; true")
        press(browser, "s")
        lines = browser.evaluate("window.saved.text()").splitlines()
        assert lines[0].startswith('"t [s]","R2 goal_distance","R2 speed"')
        assert len(lines) > 20
        press(browser, "i")
        copied = browser.evaluate("document.querySelector('dialog[open] textarea').value")
        for part in ("rocs-bt run", "R2 collision: it ran into box", "does not hold by 0.1 m/s", "collision with box"):
            assert part in copied
        browser.evaluate("document.querySelector('dialog[open]').close()")
        browser.evaluate("document.querySelector('.log .bad .raw').click()")
        assert (
            json.loads(browser.evaluate("document.querySelector('dialog[open] textarea').value"))["text"]
            == "collision with box"
        )


@pytest.fixture
def recorded(tmp_path):
    """Function that records events as a report."""

    def report(header, events):
        recorder = Recorder(tmp_path / "run.mcap", header)
        for event in events:
            recorder.emit(event)
        recorder.close()
        write_report(Recording.open(recorder.path), None, tmp_path / "report.html")
        return tmp_path / "report.html"

    return report


@pytest.mark.parametrize("width", [1366, 640])
def test_of_a_large_mission_only_the_running_path_and_the_failing_leaf_are_open(browser, recorded, width):
    resize(browser, width, width * 9 // 16)  # of a telephone that is turned, so that the tree is below the screen
    groups = [f"root/g{i}" for i in range(20)]
    nodes = [TreeNode(path="root", type="Sequence", children=tuple(groups))]
    for group in groups:
        leaves = tuple(f"{group}/leaf{k}" for k in range(5))
        nodes.append(TreeNode(path=group, type="Fallback", children=leaves))
        nodes += [
            TreeNode(path=leaf, type="GoTo", ports='(goal="{place}")', keys={"goal": "\nplace"}) for leaf in leaves
        ]
    agent = AgentInfo(name="R", robot="pioneer_p3dx", mission="big", nodes=tuple(nodes))
    ticks = [
        (0.0, "root", "RUNNING"), (0.0, "root/g3", "RUNNING"), (0.0, "root/g3/leaf1", "RUNNING"),
        (1.0, "root/g3/leaf1", "SUCCESS"), (1.0, "root/g3", "SUCCESS"),
        (2.0, "root/g7/leaf4", "FAILURE"), (2.0, "root/g7", "FAILURE"), (2.0, "root", "FAILURE"),
    ]  # fmt: skip  # ticks of one instant share a line
    events = [NodeTicked(t=t, agent="R", node=node, status=status) for t, node, status in ticks]
    events += [
        BlackboardChanged(t=0.0, agent="R", subtree="", key="place", value="kitchen"),
        BlackboardChanged(t=1.5, agent="R", subtree="", key="place", value="garden"),
        OutcomeDecided(t=2.0, agent="R", outcome="failed", reason="the mission failed"),
    ]
    header = RunHeader(scenario="big", seed=1, agents=(agent,), bodies=(BodyInfo(name="R", hull=()),))
    show(browser, recorded(header, sorted(events, key=lambda e: e.t)))
    shown = ".tree li:not([hidden]) b"
    groups = [f"g{i}" for i in range(20)]
    assert each(browser, shown) == ["root", *groups[:8], *(f"leaf{k}" for k in range(5)), *groups[8:]]
    assert text(browser, ".inspector h3") == "leaf4"
    inside = "((at, of) => at.top >= of.top - 1 && at.bottom <= of.bottom + 1)"
    rect = "document.querySelector('{}').getBoundingClientRect()"
    assert browser.evaluate(f"{inside}({rect.format('.tree .selected')}, {rect.format('.tree')})")
    assert browser.evaluate("scrollY") == 0
    assert each(browser, ".tree .path b") == ["root", "g7", "leaf4"]
    assert "goal garden" in text(browser, ".tree .selected")
    assert "garden" in text(browser, ".board")
    go(browser, 0.5)
    assert each(browser, shown)[4:6] == ["g3", "leaf0"]
    each(browser, ".mission input", "(e.value = 'g19/leaf2', e.dispatchEvent(new Event('input')))")
    assert each(browser, shown) == ["root", "g19", "leaf2"]
    assert "goal kitchen" in text(browser, ".tree .found")
    for node, cause in (
        ("root/g19", "It has not been ticked: 'g7' before it is FAILURE."),
        ("root/g19/leaf2", "It has not been ticked, because 'g19' has not."),
        ("root/g3", "SUCCESS for 1.00 s: 'leaf1'."),
        ("root", "FAILURE: 'leaf4'."),
    ):
        browser.evaluate(f"location.hash = new URLSearchParams({{ t: 2, select: 'R|node|{node}' }})")
        until(browser, f"document.querySelector('.inspector h3').textContent === '{node.rpartition('/')[2]}'")
        assert text(browser, ".inspector .cause") == cause
    assert faults(browser) == []


def test_it_opens_at_the_last_leaf_that_said_why_if_the_failing_one_says_nothing(browser, recorded):
    leaves = ("root/look", "root/drive", "root/end")
    nodes = [TreeNode(path="root", type="Fallback", children=leaves), *(TreeNode(path=p, type="Go") for p in leaves)]
    agent = AgentInfo(name="R", robot="r", mission="m", nodes=tuple(nodes))
    ticks = [(1.0, "root/drive", "no room"), (1.0, "root/look", "dark"), (2.0, "root/end", ""), (2.0, "root", "")]
    events = [NodeTicked(t=t, agent="R", node=node, status="FAILURE", feedback=text) for t, node, text in ticks]
    end = OutcomeDecided(t=2.0, agent="R", outcome="failed", reason="the mission failed")
    header = RunHeader(scenario="s", seed=1, agents=(agent,), bodies=(BodyInfo(name="R", hull=()),))
    show(browser, recorded(header, [*events, end]))
    assert text(browser, ".inspector h3") == "drive"
    assert "no room" in text(browser, ".inspector")
    assert faults(browser) == []


def test_above_8_robots_the_page_opens_with_a_table_of_them(browser, recorded):
    names = [f"P{i}" for i in range(9)]
    agents = tuple(AgentInfo(name=n, robot="pioneer_p3dx", mission="go_to") for n in names)
    header = RunHeader(scenario="many", seed=1, agents=agents, bodies=tuple(BodyInfo(name=n, hull=()) for n in names))
    ends = [
        OutcomeDecided(t=1.0, agent=n, outcome="collision" if n == "P5" else "success", reason="", time_to_goal=None)
        for n in names
    ]
    show(browser, recorded(header, ends))
    rows = each(browser, ".fleet tbody tr")
    assert len(rows) == 9
    assert rows[0].startswith("P5\tcollision")
    assert text(browser, ".badge") == "8 of 9 success"
    browser.evaluate("document.querySelectorAll('.fleet tbody tr')[3].click()")
    assert text(browser, ".inspector h3").startswith("P2")
    assert faults(browser) == []


FRAMES = """
performance.now = () => 0;  // [ms]
window.next = null;
window.requestAnimationFrame = (draw) => { next = draw; return 1; };
true"""
"""Frames are drawn by the test, because those of the browser depend on the load of the machine."""


@pytest.mark.parametrize("frames", [[100, 300, 550, 9000], [9000], [399.95, 450, 9000], [399.999, 400.01, 9000], [400]])
def test_playing_pauses_when_a_node_with_a_stop_fails_whichever_frames_are_drawn(browser, recorded, frames):
    agent = AgentInfo(name="R", robot="r", mission="m", nodes=(TreeNode(path="go", type="GoTo"),))
    header = RunHeader(scenario="s", seed=1, agents=(agent,), bodies=(BodyInfo(name="R", hull=()),))
    states = [(0.0, "RUNNING"), (0.4, "FAILURE"), (0.6, "RUNNING"), (9.0, "SUCCESS")]
    show(browser, recorded(header, [NodeTicked(t=t, agent="R", node="go", status=s) for t, s in states]))
    browser.evaluate("document.querySelector('.tree li').click()")
    press(browser, "Home")
    until(browser, "document.querySelector('.clock').textContent === '0.00 s'")
    press(browser, "b")
    until(browser, "document.querySelector('.stops').textContent.includes('pauses at go')")
    browser.evaluate(FRAMES)
    press(browser, " ")
    until(browser, "document.querySelector('[title^=play]').textContent !== '▶'")
    browser.evaluate(f"for (const t of {frames}) {{ const draw = next; next = null; if (draw) draw(t); }}")
    assert text(browser, ".clock") == "0.40 s"
    assert text(browser, "[title^=play]") == "▶"
    assert faults(browser) == []


def copied(recording, folder, keep, *more):
    """A recording with some events of another one, and more events at its end."""
    recorder = Recorder(folder / "run.mcap", recording.header)
    for event in recording.events():
        if keep(event):
            recorder.emit(event)
    for event in more:
        recorder.emit(event)
    recorder.close()
    return Recording.open(recorder.path)


def test_two_runs_are_drawn_over_each_other_with_their_first_differences(browser, recording, tmp_path):
    last = NodeTicked(t=19.9, agent="R2", node="go to", status="FAILURE")
    other = copied(recording, tmp_path, lambda event: not isinstance(event, NodeTicked) or event.t < 3.0, last)
    write_report(recording, recording.summary, tmp_path / "both.html", other)
    show(browser, tmp_path / "both.html")
    assert browser.evaluate("document.querySelector('dialog[open]')") is None
    assert "decisions" in text(browser, ".differences")
    for i, moment in enumerate(each(browser, ".differences time")):
        browser.evaluate(f"document.querySelectorAll('.differences a')[{i}].click()")
        assert text(browser, ".clock") == moment
        assert browser.evaluate(f"document.querySelectorAll('.differences a')[{i}].getClientRects().length") == 1
    assert "R2′" in text(browser, "select[aria-label=robot]")
    one = (tmp_path / "both.html").read_text("utf-8")
    write_report(recording, recording.summary, tmp_path / "report.html")
    show(browser, tmp_path / "report.html")
    assert browser.evaluate("document.querySelector('select[aria-label=robot]')") is None
    browser.evaluate(
        "HTMLInputElement.prototype.click = function () { const files = new DataTransfer(); "
        f"files.items.add(new File([{json.dumps(one)}], 'b.html')); this.files = files.files; "
        "this.dispatchEvent(new Event('change')); }; true"
    )
    press(browser, "o")
    until(browser, "document.querySelector('select[aria-label=robot]')")
    assert "differs" in text(browser, ".differences li.empty")
    assert faults(browser) == []


def test_the_page_and_the_command_find_the_same_differences(browser, recording, tmp_path):
    runs = [rocs_bt.run(name, seed=1, duration=2.0, out=tmp_path / name, report=False) for name in ("exp1", "exp3")]
    recordings = [recording, *(Recording.open(run.recording) for run in runs)]
    for first, second in itertools.permutations(recordings, 2):
        write_report(first, first.summary, tmp_path / "both.html", second)
        show(browser, tmp_path / "both.html")
        found = first_differences(Tracks.of_recording(first), Tracks.of_recording(second))
        lines = each(browser, ".differences a", "e.innerText.replaceAll('\u2032', '').split(': ')[0].split('\\n')")
        said = [re.fullmatch(r"First difference of (\w+) at t = (.* s), (.*?): .*", str(one)) for one in found]
        assert lines == [[one[2], f"{one[1]} {one[3]}"] for one in said]


def test_what_only_one_of_two_runs_has_is_a_difference_in_both_orders(browser, recording, tmp_path):
    only = RuleChanged(t=recording.header.start + 1e3, agent="R2", rule="new/Only", phase="fired", priority=1)
    other = copied(recording, tmp_path, lambda event: True, only)
    for first, second in ((recording, other), (other, recording)):
        write_report(first, recording.summary, tmp_path / "both.html", second)
        show(browser, tmp_path / "both.html")
        assert "new/Only" in text(browser, ".differences")
    assert faults(browser) == []


def test_two_runs_open_at_the_failure_of_the_second_if_the_first_succeeded(browser, recording, tmp_path):
    end = OutcomeDecided(t=5.0, agent="R2", outcome="collision", reason="it ran into box")
    second = copied(recording, tmp_path, lambda event: not isinstance(event, OutcomeDecided) and event.t < 5.0, end)
    for one, other, title in ((recording, second, "R2′: collision"), (second, recording, "R2: collision")):
        write_report(one, one.summary, tmp_path / "both.html", other)
        show(browser, tmp_path / "both.html")
        assert text(browser, ".inspector h3") == title
    assert faults(browser) == []


def test_knowledge_at_the_cursor_marks_what_is_new_changed_and_removed(browser, tmp_path):
    from rocs_bt.knowledge.history import ChangeLog, GraphState

    changes = [
        KnowledgeChanged(t=t, agent="R", what=what, subject="box", name=name, value=value, revision=i)
        for i, (t, what, name, value) in enumerate(
            [
                (1.0, "node added", "object", None),
                (2.0, "attribute", "radius", 0.2),
                (4.0, "attribute", "radius", 0.3),
                (6.0, "node removed", "object", None),
            ],
            1,
        )
    ]
    log = ChangeLog(GraphState("R"), "run", changes, end=8.0)
    page = tmp_path / "knowledge.html"
    page.write_text(render_knowledge(log), encoding="utf-8")
    show(browser, page)
    assert browser.evaluate("document.querySelector('.graph').hidden") is False
    found = []
    for t in (2.1, 3.5, 4.2, 6.1, 7.9):
        go(browser, t)
        facts = each(browser, ".fact:not([hidden])", "`${e.className} ${e.innerText.replaceAll('\\n', ' ')}`")
        found.append(facts)
    marked = ["fact new radius 0.2", "fact radius 0.2", "fact changed radius 0.3", "fact removed radius removed"]
    assert found == [*([one] for one in marked), []]
    assert faults(browser) == []


def test_the_tree_of_a_mission_without_a_run(browser, tmp_path):
    nodes = [TreeNode(path="a", type="Sequence", children=("a/<b>x",)), TreeNode(path="a/<b>x", type="GoTo")]
    page = tmp_path / "tree.html"
    fault = Fault("no port 'gaol'", tmp_path / "a.xml", 3)
    page.write_text(render_tree("tour", "Visit all.", nodes, [fault]), encoding="utf-8")
    show(browser, page)
    assert each(browser, ".tree b") == ["a", "<b>x"]
    assert "no port 'gaol'" in text(browser, ".log")
    assert "Visit all." in text(browser, ".inspector")
    assert faults(browser) == []
