"""Looks of the page: one meaning for each colour, labels beside curves, panels that use the window's height."""

import re

import pytest

from rocs_bt.studio.page import WEB

from .test_page import STYLE, faults, press, show, text
from .test_reading import each, resize, screen, touched  # noqa: F401  # fixtures

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
    def test_no_label_of_a_scale_is_on_a_curve_or_on_another_label(self, browser, touched, width):  # noqa: F811
        resize(browser, width, 844)
        show(browser, touched)
        browser.evaluate("[...document.querySelectorAll('.label')].find((e) => e.textContent == 'TurnAwayactive' "
                         "|| e.innerText.startsWith('TurnAway')).click()")  # fmt: skip
        seen = browser.evaluate(OVERLAPS)
        assert seen["found"] == []
        assert seen["count"] >= 6
        assert faults(browser) == []

    def test_the_selected_curve_is_taller_and_the_limit_is_in_the_middle_of_its_scale(self, browser, touched):  # noqa: F811
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

    def test_rules_actions_and_signals_have_headings_and_the_legend_opens_the_help(self, browser, touched):  # noqa: F811
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
def test_panels_use_the_height_of_the_window(browser, touched, width, height):  # noqa: F811
    resize(browser, width, height)
    show(browser, touched)
    seen = browser.evaluate(SPARE)
    assert seen["spare"] < 0.06 * height, seen
    assert seen["over"] <= 0
    assert min(seen["heights"].values()) > 0.25 * height
    browser.evaluate("[...document.querySelectorAll('.label')].find((e) => e.innerText.startsWith('TurnAway')).click()")
    assert browser.evaluate(SPARE)["heights"] == seen["heights"], "a selection moves the panels"
