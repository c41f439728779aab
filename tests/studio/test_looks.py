"""Looks of the page: one meaning for each colour, labels beside curves, panels that use the window's height."""

import re

import msgspec
import pytest

from rocs_bt import run
from rocs_bt.event import BodyMoved, NodeTicked, RuleChanged, TicketChanged
from rocs_bt.record.explanation.why import Why
from rocs_bt.record.file.header import BodyInfo
from rocs_bt.record.file.recorder import Recorder
from rocs_bt.record.file.recording import Recording
from rocs_bt.record.fold.tracks import Tracks
from rocs_bt.studio.page import WEB
from rocs_bt.studio.report import write_report
from rocs_bt.testing.faults import DeadSensor, break_sensor

from .. import synthetic
from ..pages import resize
from .test_page import STYLE, faults, go, press, show, text
from .test_reading import each

NEUTRAL = {"paper", "raised", "ink", "muted", "line", "track", "wall", "curve"}
EDITOR = {"note"}  # warnings, which only the editor shows


def test_the_legend_names_each_colour_that_is_used_once():
    legend = (WEB / "legend.js").read_text("utf-8")
    named = re.findall(r'tint: "(\w+)"', legend)
    declared = set(re.findall(r"--(\w+): #", STYLE))
    sources = "".join(path.read_text("utf-8") for path in WEB.iterdir() if path.name != "legend.js")
    used = {name for name in declared if re.search(rf'"{name}"|var\(--{name}\)', sources)}
    assert len(named) == len(set(named)) > 10
    assert declared == used == set(named) | NEUTRAL | EDITOR
    light, dark = (dict(re.findall(r"--(\w+): (#\w+)", part)) for part in STYLE.split(":root {")[1:])
    for tints in (light, dark):
        assert len({tints[name] for name in named}) == len(named), "two meanings have the same colour"


def test_no_line_of_script_or_style_is_longer_than_160_characters():
    files = [path for path in WEB.iterdir() if path.suffix in (".js", ".css", ".html")]
    long = [
        (path.name, i)
        for path in files
        for i, line in enumerate(path.read_text("utf-8").split("\n"), 1)
        if len(line) > 160
    ]
    assert len(files) > 25
    assert long == []


OVERLAPS = """
(() => {
  const boxes = (query) => [...document.querySelectorAll(query)]
    .filter((e) => e.textContent && e.getClientRects().length)
    .map((e) => ({ text: e.textContent, box: e.getBoundingClientRect() }));
  const plot = document.querySelector(".plot canvas").getBoundingClientRect(), found = [];
  const over = (a, b) => a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1;
  const scales = boxes(".scale i"), names = boxes(".label span, .label output");
  scales.forEach(({ text, box }, i) => {
    if (over(box, plot)) found.push(`${text} is on the curves`);
    const others = [...scales.slice(i + 1), ...names].filter((other) => over(box, other.box));
    for (const other of others) found.push(`${text} on ${other.text}`);
  });
  return { found, count: scales.length };
})()
"""


@pytest.mark.browser
@pytest.mark.usefixtures("screen")
class TestTimeAxis:
    @pytest.mark.parametrize("width", [1366, 2560, 390])
    def test_no_label_of_a_scale_is_on_a_curve_or_on_another_label(self, browser, touched, width):
        resize(browser, width, 844)
        show(browser, touched)
        browser.evaluate(
            "[...document.querySelectorAll('.label')].find((e) => e.textContent == 'TurnAwayactive' "
            "|| e.innerText.startsWith('TurnAway')).click()"
        )
        seen = browser.evaluate(OVERLAPS)
        assert seen["found"] == []
        assert seen["count"] >= 6
        assert faults(browser) == []

    def test_the_selected_curve_is_taller_and_the_limit_is_in_the_middle_of_its_scale(self, browser, touched):
        show(browser, touched)
        browser.evaluate(
            "[...document.querySelectorAll('.label')].find((e) => e.innerText.startsWith('TurnAway')).click()"
        )
        before = each(browser, ".label.inner", "e.offsetHeight")
        browser.evaluate("document.querySelector('.label.inner').click()")
        after = each(browser, ".label.inner", "e.offsetHeight")
        assert after[0] > 2 * before[0] - 10
        part = "e.innerText ? (e.offsetTop + e.offsetHeight / 2) / e.closest('.label').offsetHeight : 0.5"
        places = each(browser, ".label.inner .limit", part)
        assert places
        assert all(0.1 < place < 0.9 for place in places), places

    def test_rules_actions_and_signals_have_headings_and_the_legend_opens_the_help(self, browser, touched):
        show(browser, touched)
        assert each(browser, ".label.heading", "e.innerText.trim()") == ["rules", "actions", "signals"]
        line = text(browser, ".legend")
        assert "mission" in line
        browser.evaluate("document.querySelector('.legend').click()")
        swatches = each(browser, "dialog[open] .swatch", "getComputedStyle(e).backgroundColor")
        assert len(swatches) == len(re.findall(r'tint: "', (WEB / "legend.js").read_text("utf-8")))
        assert "rgba(0, 0, 0, 0)" not in swatches
        press(browser, "Escape")


SPARE = """
(() => {
  const box = (query) => document.querySelector(query), rows = [...document.querySelectorAll(".label")];
  const list = box(".tree"), cut = list.scrollHeight > list.clientHeight + 2;
  const spare = box(".legend").getBoundingClientRect().top - rows.at(-1).getBoundingClientRect().bottom;
  const panels = [".stage", ".inspect", ".side", "#app > .time"];
  const heights = Object.fromEntries(panels.map((query) => [query, box(query).clientHeight]));
  return { cut, spare, heights, over: document.documentElement.scrollHeight - innerHeight };
})()
"""


@pytest.mark.browser
@pytest.mark.usefixtures("screen")
@pytest.mark.parametrize(("width", "height"), [(1366, 768), (1920, 1080), (2560, 1440)])
def test_panels_use_the_height_of_the_window(browser, touched, width, height):
    resize(browser, width, height)
    show(browser, touched)
    seen = browser.evaluate(SPARE)
    assert seen["spare"] < 0.06 * height, seen
    assert seen["over"] <= 0
    assert min(seen["heights"].values()) > 0.25 * height
    browser.evaluate("[...document.querySelectorAll('.label')].find((e) => e.innerText.startsWith('TurnAway')).click()")
    assert browser.evaluate(SPARE)["heights"] == seen["heights"], "a selection moves the panels"


@pytest.mark.browser
@pytest.mark.usefixtures("screen")
def test_nothing_moves_while_the_time_goes_on(browser, touched):
    show(browser, touched)
    boxes = set()
    for t in (0.0, 0.4, 0.8, 1.2, 1.5):
        go(browser, t)
        rects = each(browser, "#app > *, .mission .tree, .label, .tabs", "JSON.stringify(e.getBoundingClientRect())")
        boxes.add(tuple(rects))
    assert len(boxes) == 1
    assert not re.search(r"\b(transition|animation)\b", STYLE)


@pytest.fixture(scope="module")
def gated(tmp_path_factory):
    """Report of a run with a door that shuts between 2 and 3.5 s."""
    folder, known = tmp_path_factory.mktemp("gate"), synthetic.header()
    leaf = ((-0.5, -0.03), (0.5, -0.03), (0.5, 0.03), (-0.5, 0.03))
    states = {"open": (1.2, 1.0, 0.0), "shut": (0.0, 1.0, 0.0)}
    bodies = (*known.bodies, BodyInfo(name="gate", hull=leaf, script="slide", states=states))
    recorder = Recorder(folder / "run.mcap", msgspec.structs.replace(known, bodies=bodies))
    for i in range(200):
        x = 1.2 - 0.04 * max(0, min(i - 40, 30))
        recorder.emit(BodyMoved(t=i * 0.05, body="gate", x=x, y=1.0, yaw=0.0))
    recorder.close(synthetic.summary())
    write_report(Recording.open(recorder.path), synthetic.summary(), folder / "report.html")
    return folder / "report.html"


@pytest.mark.browser
@pytest.mark.usefixtures("screen")
def test_each_movement_of_a_door_is_in_the_log_and_on_the_axis(browser, gated):
    show(browser, gated)
    assert each(browser, ".log .actor span") == ["gate begins to move (scripted)", "gate is shut since 3.50 s"]
    blue = browser.evaluate("getComputedStyle(document.documentElement).getPropertyValue('--actor')")
    assert blue not in STYLE.split("--actor")[0]  # the colour of nothing else
    assert "scripted" in text(browser, ".legend")
    press(browser, "Home")
    press(browser, ".")
    assert text(browser, ".log .here span") == "gate begins to move (scripted)"
    browser.evaluate("document.querySelector('.log .actor:last-child').click()")
    assert "gate|actor|" in browser.evaluate("new Promise((r) => setTimeout(() => r(unescape(location.hash)), 250))")
    assert faults(browser) == []


BESIDE = """
import("./arena.js").then(({ beside }) => {
  let over = 0, outside = 0, none = 0;
  let seed = 7;
  const random = () => (seed = (seed * 16807) % 2147483647) / 2147483647;
  for (let run = 0; run < 200; run++) {
    const boxes = [];
    const placed = Array.from({ length: 6 }, () => {
      const wide = 30 + 60 * random(), place = beside(boxes, [400 * random(), 300 * random()], wide, [400, 300]);
      if (!place) none++;
      return place && [place[0], place[1] - 12, place[0] + wide, place[1]];
    }).filter(Boolean);
    placed.forEach(([left, top, right, bottom], i) => {
      if (left < 0 || top < 0 || right > 400 || bottom > 300) outside++;
      over += placed.slice(i + 1).filter((b) => left < b[2] && b[0] < right && top < b[3] && b[1] < bottom).length;
    });
  }
  return { over, outside, none };
})
"""


@pytest.mark.browser
def test_labels_of_the_arena_are_beside_each_other_and_inside(browser, live):
    browser.open(live.url)
    seen = browser.evaluate(BESIDE)
    assert seen["outside"] == 0
    assert seen["over"] == 0
    assert seen["none"] < 12  # of 1,200: in a crowd there is not always room


def alternating(path, step):
    """A run in which two rules take turns 16 times, and the robot moves by a step each time [m]."""
    recorder = Recorder(path / "run.mcap", synthetic.header())
    place = {"agent": "R2", "body": "R2", "y": 0.0, "yaw": 0.0}
    for i in range(20):
        rule = ("a/Flinch", "a/Turn")[i % 2] if i < 16 else f"a/Other{i}"
        ticket = {"agent": "R2", "ticket": i, "action": rule[2:], "priority": "HIGH", "by": rule}
        recorder.emit(BodyMoved(t=float(i), x=step * i, **place))
        recorder.emit(RuleChanged(t=float(i), agent="R2", rule=rule, phase="fired", priority=1))
        recorder.emit(TicketChanged(t=float(i), state="RUNNING", **ticket))
        recorder.emit(TicketChanged(t=i + 0.5, state="SUCCEEDED", **ticket))
        recorder.emit(RuleChanged(t=i + 0.5, agent="R2", rule=rule, phase="ended", priority=1))
    recorder.close(synthetic.summary())
    recording = Recording.open(recorder.path)
    write_report(recording, synthetic.summary(), path / "report.html")
    return Tracks.of_recording(recording)


@pytest.mark.browser
@pytest.mark.usefixtures("screen")
def test_two_rules_that_take_turns_are_one_line_of_the_log_with_the_words_of_the_recording(browser, tmp_path):
    tracks = alternating(tmp_path, 0.001)
    show(browser, tmp_path / "report.html")
    visible = ".log li:not([hidden])"
    assert len(each(browser, visible)) == 5
    said = [each for each in tracks.get("R2", "alternation").v if each][-1].text
    assert "alternate 15 times from 0.00 s to 15.00 s" in said
    assert said in text(browser, ".log .turns")
    go(browser, 7.2)
    assert "here" in browser.evaluate("document.querySelector('.log .turns').className")
    browser.evaluate("document.querySelector('.log .turns').click()")
    assert len(each(browser, visible)) == 21
    go(browser, 3.2)
    assert "a/Turn fired" in text(browser, ".log .here")
    browser.evaluate("document.querySelector('.log .turns').click()")
    assert len(each(browser, visible)) == 5
    assert faults(browser) == []


@pytest.mark.browser
@pytest.mark.usefixtures("screen")
def test_turns_of_a_robot_that_makes_progress_are_not_folded(browser, tmp_path):
    assert alternating(tmp_path, 0.6).get("R2", "alternation") is None
    show(browser, tmp_path / "report.html")
    assert len(each(browser, ".log li:not([hidden])")) == 20
    assert each(browser, ".log .turns") == []


LABEL = "[...document.querySelectorAll('.label')].find((each) => each.textContent.startsWith('Flinch')).click()"


@pytest.mark.browser
@pytest.mark.usefixtures("screen")
def test_an_action_of_a_reflex_that_fails_again_and_again_is_seen_as_such(browser, tmp_path):
    """Its failures are one line of the log, marks in its row, and counted where its rule is explained."""
    recorder = Recorder(tmp_path / "run.mcap", synthetic.header())
    rule = {"agent": "R2", "rule": "a/Back", "priority": 1, "reading": "min(front) = 0.1 m"}
    about = {"agent": "R2", "action": "Flinch", "priority": "HIGH", "by": "a/Back", "parameters": {"speed": -0.25}}
    for i in range(12):
        t, phase = 1.0 + 0.25 * i, "fired again" if i else "fired"
        recorder.emit(RuleChanged(t=t, phase=phase, refirings=i, **rule))
        states = ("QUEUED", "RUNNING", "FAILED") if i % 2 else ("QUEUED", "FAILED")  # some fail before they run
        for k, state in enumerate(states):
            reason = "BLOCKED: a wall" if state == "FAILED" else ""
            recorder.emit(TicketChanged(t=t + 0.05 * k, ticket=i + 1, state=state, reason=reason, **about))
    recorder.close(synthetic.summary())
    write_report(Recording.open(recorder.path), synthetic.summary(), tmp_path / "report.html")
    show(browser, tmp_path / "report.html")
    phrase = "the rule Back is active, and its action Flinch failed 6 times since t = 1.05 s: BLOCKED: a wall."
    answer = Why(Tracks.of_recording(Recording.open(recorder.path)), 2.4).answer
    assert answer.endswith(phrase)
    browser.evaluate("location.hash = new URLSearchParams({ t: 2.4, select: 'R2|pose|' })")
    assert text(browser, ".inspector .cause") == answer
    assert "Back: its action Flinch failed 12 times since t = 1.05 s: BLOCKED: a wall" in text(browser, ".log .turns")
    assert len(each(browser, ".log .inner[hidden]")) == 23  # 12 failures, and the firings between them
    for t, number in ((2.2, 5), (2.4, 6), (3.9, 12)):  # the last one at the time, also one that did not run
        go(browser, t)
        browser.evaluate(LABEL)
        assert text(browser, ".inspector h3") == f"Flinch #{number}"
    assert "min(front) = 0.1 m" in text(browser, ".inspector")
    assert "−0.25" in text(browser, ".inspector")
    browser.evaluate("location.hash = new URLSearchParams({ t: 2.4, select: 'R2|rule|a/Back' })")
    assert "12 times, 11 of them again while it was latched" in text(browser, ".inspector")
    assert text(browser, ".inspector .cause") == answer
    assert "undefined" not in text(browser, "body")
    assert faults(browser) == []


@pytest.mark.browser
def test_of_many_marks_of_events_those_that_matter_most_are_drawn(browser, live):
    browser.open(live.url)
    seen = browser.evaluate("""
      import("./lanes.js").then(({ Lanes }) => {
        const drawn = [], g = { beginPath() {}, fill() {}, lineTo(x) { drawn.push([this.fillStyle, x]); } };
        const lanes = new Lanes({ start: 0, end: 100 }, new EventTarget());
        lanes.wide = 100;
        const tint = (i) => (i === 503 ? "bad" : i % 2 ? "ink" : "reactive");
        const marks = Array.from({ length: 1000 }, (_, i) => ({ t: i / 10, fill: tint(i) }));
        lanes.points(g, { y: 0, high: 10, marks });
        return drawn;
      })""")
    assert 20 * 4 <= len(seen) <= 26 * 4
    assert len({tint for tint, _ in seen}) == 2


@pytest.mark.browser
@pytest.mark.usefixtures("screen")
def test_a_sensor_that_fails_says_since_when_and_its_last_values(browser, tmp_path):
    run(
        "exp1",
        seed=1,
        duration=4.0,
        out=tmp_path,
        prepare=lambda world: break_sensor(world, "sonar", DeadSensor, at=2.0),
    )
    show(browser, tmp_path / "report.html")
    go(browser, 3.0)
    line = "[...document.querySelectorAll('.log li')].find((each) => each.innerText.includes('sensor sonar failed'))"
    browser.evaluate(f"{line}.click()")
    assert text(browser, ".inspector h3") == "sensor sonar"
    browser.evaluate("location.hash = new URLSearchParams({ t: 3, select: 'R2|sensor|sonar' })")
    assert text(browser, ".inspector .cause").startswith(
        "It has given no data for 1.00 s: sensor 'sonar' does not answer."
    )
    assert re.search(r"last min\(front\)\s+[\d.]+ m since 1\.95 s", text(browser, ".inspector"))
    facts = browser.evaluate("[...document.querySelectorAll('.fact')].map((each) => each.textContent)")
    assert "failuresensor 'sonar' does not answer." in facts
    for address in ("R2|rule|avoid_collision/Blind", "R2|rule|avoid_collision/Flinch", "R2|outcome|", "R2|pose|"):
        browser.evaluate(f"location.hash = new URLSearchParams({{ t: 3, select: '{address}' }})")
        assert not re.search("undefined|NaN", browser.evaluate("document.getElementById('app').textContent")), address
    assert faults(browser) == []


@pytest.mark.browser
@pytest.mark.usefixtures("screen")
def test_each_attempt_of_a_node_can_be_gone_to(browser, tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", synthetic.header())
    ticks = [(1.0, "RUNNING"), (2.0, "FAILURE"), (4.0, "RUNNING"), (5.0, "INVALID"), (6.0, "RUNNING")]
    for t, status in [*ticks, (7.5, "SUCCESS")]:
        said = "no way" if status == "FAILURE" else ""
        recorder.emit(NodeTicked(t=t, agent="R2", node="go to/GoTo", status=status, feedback=said))
    recorder.close(synthetic.summary())
    write_report(Recording.open(recorder.path), synthetic.summary(), tmp_path / "report.html")
    show(browser, tmp_path / "report.html")
    browser.evaluate("location.hash = new URLSearchParams({ t: 3.5, select: 'R2|node|go to/GoTo' })")
    attempts = "[...document.querySelectorAll('.inspector .row')].filter((e) => e.innerText.includes('attempt '))"
    words = [" ".join(row.split()) for row in browser.evaluate(f"{attempts}.map((e) => e.innerText)")]
    assert words == [
        "▸ attempt 1 of 3 2.00 s FAILURE after 1.00 s: no way",
        "attempt 2 of 3 4.00 s RUNNING",
        "attempt 3 of 3 7.50 s SUCCESS after 1.50 s",
    ]
    assert each(browser, ".tree .tries")[-1] == "1/3"
    for i, t in enumerate(("2.00 s", "4.00 s", "7.50 s")):
        browser.evaluate(f"{attempts}[{i}].click()")
        assert (text(browser, ".clock"), each(browser, ".tree .tries")[-1]) == (t, f"{i + 1}/3")
    assert faults(browser) == []
