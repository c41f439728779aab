"""Control of a run from its page, in a browser: swap of a subtree, reload of a rule file."""

import json
import shutil

import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.event import NodeTicked
from rocs_bt.studio.live import LivePage

from .. import synthetic
from ..waiting import until
from .test_door import Studio, arrives
from .test_page import click, faults, press
from .test_page import until as shown

pytestmark = pytest.mark.browser

TREE = '<root BTCPP_format="4"><BehaviorTree ID="own"><Sleep name="%s" msec="900000"/></BehaviorTree></root>'
SCENARIO = """base = "exp1"
[[agent]]
name = "R2"
mission = "first"
parameters = {}
"""


def test_following_pauses_at_a_failure_that_comes_behind_the_head(browser):
    with LivePage() as page:
        page.begin(synthetic.header())
        page.emit(NodeTicked(t=1.0, agent="R2", node="go to", status="RUNNING"))
        page.emit(NodeTicked(t=1.2, agent="R2", node="", status="RUNNING"))
        browser.open(page.url)
        arrives(browser, "document.querySelector('.clock')?.textContent === '1.20 s'")
        browser.evaluate("document.querySelector('.tree li').click()")
        press(browser, "b")
        shown(browser, "document.querySelector('.stops').textContent.includes('pauses at')")
        browser.evaluate("document.querySelector('.head').click()")
        page.emit(NodeTicked(t=1.1, agent="R2", node="go to", status="FAILURE"))
        shown(browser, "document.querySelector('.clock').textContent === '1.10 s'")
        assert browser.evaluate("document.querySelector('.head').classList.contains('on')") is False
        browser.open("about:blank")
    assert faults(browser) == []


@pytest.fixture
def going(browser, tmp_path):
    """A run in the studio, paused, and its project."""
    for folder in ("planners/missions", "rules", "scenarios"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "planners/missions/first.xml").write_text(TREE % "nap")
    (tmp_path / "planners/missions/second.xml").write_text(TREE % "doze")
    (tmp_path / "scenarios/mine.toml").write_text(SCENARIO)
    shutil.copy(Catalog().find("rules", "avoid_collision").path, tmp_path / "rules")
    with Studio(tmp_path) as studio:
        name = studio.post("start", scenario="mine", duration=600)["run"]
        browser.open(f"{studio.url}run?run={name}")
        arrives(browser, "document.querySelector('.control') && !document.querySelector('.control').hidden")
        press(browser, "p")
        shown(browser, "document.querySelector('.control button').textContent.includes('continue')")
        yield tmp_path
        studio.post(f"stop?run={name}")
        until(lambda: studio.state(name) == "over")
    browser.open("about:blank")
    assert faults(browser) == []


def wait_for_log(browser, words):
    shown(browser, f"document.querySelector('.log').innerText.includes({json.dumps(words)})")


def test_a_subtree_is_swapped_by_the_dialog(browser, going):
    browser.evaluate("[...document.querySelectorAll('.tree *')].find((e) => e.textContent.trim() === 'nap').click()")
    for mission, answer in (("none", "refused: no mission is named 'none'"), ("second", "swap 'R2:nap' by second")):
        click(browser, ".control button", "swap")
        shown(browser, "document.querySelector('dialog[open] form')")
        assert browser.evaluate("document.querySelector('dialog input').value") == "nap"
        browser.evaluate(f"document.querySelectorAll('dialog input')[1].value = {mission!r}")
        browser.evaluate("document.querySelector('dialog form').requestSubmit()")
        shown(browser, "!document.querySelector('dialog')")
        wait_for_log(browser, answer)
    browser.evaluate("document.querySelector('.head').click()")
    click(browser, ".control button", "▶ continue")
    shown(browser, "[...document.querySelectorAll('.tree *')].some((e) => e.textContent.trim() === 'doze')")


def test_a_rule_file_with_a_fault_is_refused_with_its_place_and_the_old_rules_stay(browser, going):
    rules = going / "rules" / "avoid_collision.toml"
    before = rules.read_text()
    rules.write_text(before.replace("min(front)", "min(frond)"))
    click(browser, ".control button", "reload")
    wait_for_log(browser, "no signal or alias is named 'frond'")
    wait_for_log(browser, "the old rules stay active")
    rules.write_text(before + "# the same\n")
    click(browser, ".control button", "reload")
    wait_for_log(browser, "avoid_collision: active rules (")
