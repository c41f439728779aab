"""The address of the page: a link, a bookmark and a step back show the same picture."""

import random
import urllib.parse

import pytest

from rocs_bt.studio.report import write_report

from .test_page import faults, press, show, text
from .test_page import until as shown

pytestmark = pytest.mark.browser

PICTURE = """(() => {
  const drawn = (name) => document.querySelector(`${name} canvas`).toDataURL(), checked = (e) => e.checked;
  return JSON.stringify([
    document.querySelector('.clock').innerText, document.querySelector('.inspector').innerText, drawn('.stage'),
    [...document.querySelectorAll('.layers input')].map(checked),
    [...document.querySelectorAll('.signals input[type=checkbox]')].map(checked),
    document.querySelector('.log').innerText, [...document.querySelectorAll('.labels .label')].map((e) => e.innerText),
  ]);
})()"""


@pytest.fixture(scope="module")
def page(recording, tmp_path_factory):
    path = tmp_path_factory.mktemp("address") / "report.html"
    write_report(recording, recording.summary, path)
    return path


def written(browser):
    """Address of the page, after it has been written."""
    browser.evaluate("new Promise((done) => setTimeout(done, 250))")
    return browser.evaluate("location.href")


def act(browser, some):
    """Change a part of the view by what a person can do."""
    kind = some.choice(["time", "row", "pin", "zoom", "whole", "layer", "filter", "level", "robot"])
    n = some.randrange(1000)
    any_of = f"(all => all[{n} %% all.length].click())([...document.querySelectorAll('%s')])"
    script = {
        "row": any_of % ".labels .label:not(:nth-child(2))",
        "pin": any_of % ".signals input[type=checkbox]",
        "layer": any_of % ".layers input, .layers button",
        "filter": f"(e => {{ e.value = {some.choice(['', 'go', 'R2'])!r}; e.dispatchEvent(new Event('input')); }})"
        "(document.querySelector('input[aria-label=\"filter the log\"]'))",
        "level": f"(e => {{ e.value = {some.choice('1234')!r}; e.dispatchEvent(new Event('change')); }})"
        "(document.querySelector('select[aria-label=\"least level\"]'))",
    }.get(kind)
    if script:
        browser.evaluate(f"{script}; true")
    else:
        keys = {"time": some.choice([".", ",", "ArrowRight"]), "zoom": "+", "whole": "0", "robot": "Escape"}
        press(browser, keys[kind])


def test_a_link_shows_the_same_picture(browser, page):
    some = random.Random(7)
    show(browser, page)
    for _ in range(8):
        for _ in range(5):
            act(browser, some)
        address, picture = written(browser), browser.evaluate(PICTURE)
        browser.open("about:blank")
        browser.open(address)
        shown(browser, "document.querySelector('.clock')?.innerText")
        written(browser)
        assert browser.evaluate(PICTURE) == picture, address
        assert browser.evaluate("location.href") == address
    assert faults(browser) == []


def test_the_steps_of_the_browser_go_through_what_was_selected(browser, page):
    show(browser, page)
    written(browser)
    pictures = []
    for n in (1, 2, 0, 2):
        browser.evaluate(f"document.querySelectorAll('.labels .label, .tree li')[{n}].click()")
        press(browser, ".")
        if n == 2:
            press(browser, "+")
        written(browser)
        pictures.append(browser.evaluate(PICTURE))
    for which, step in ((2, -1), (1, -1), (2, 1), (3, 1), (2, -1), (0, -2)):
        browser.evaluate(f"history.go({step})")
        written(browser)
        assert browser.evaluate(PICTURE) == pictures[which]
    assert faults(browser) == []


@pytest.mark.parametrize(
    ("part", "names"),
    [
        ("t=3&agent=R9", ["R9"]),
        ("t=3&select=R2|rule|no+such+rule", ["R2 rule no such rule"]),
        ("t=3&select=<img src=x onerror=alert(1)>", ["<img src=x onerror=alert(1)>"]),
        ("t=3&pin=R2|signal|gone&pin=R2|signal|rear", ["R2 signal gone"]),
        ("t=nothing&agent=&select=%00&window=5&window=x&layers=fog&log=%FF", []),
        ("t=1e999&window=9e9&window=1e12", []),
        ("", []),
    ],
)
def test_an_address_with_names_that_the_run_does_not_have_opens_and_says_so(browser, page, part, names):
    parts = urllib.parse.quote(part, safe="=&%+")
    browser.open("about:blank")
    browser.open(f"{page.as_uri()}#{parts}")
    shown(browser, "document.querySelector('.clock')?.innerText")
    assert text(browser, ".inspector h3")
    said = text(browser, ".cut")
    assert all(name in said for name in names)
    if names:
        assert said.startswith("Not in this run: ")
        assert text(browser, ".clock") == "3.00 s"
        assert "rear" not in said
    assert faults(browser) == []
