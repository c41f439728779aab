"""For all tests of this room: a live page that shows a run like EXP1, a report, and a window of a size."""

import contextlib
import textwrap

import pytest

import rocs_bt
from rocs_bt.studio.live import LivePage

from .. import synthetic
from ..pages import resize

LATE = """
    format = "reflex/1"
    doc = "Turns away, too late."

    [rule.TurnAway]
    doc = "Turn away from what is ahead."
    when = "min(front) < 0.12 m and speed > 0.6 m/s"
    until = "min(front) > 0.3 m"
    trigger = "edge"
    priority = 50

    [rule.TurnAway.action]
    name = "AvoidCollision"
    turn = "60 deg"
    speed = "0.3 m/s"
    duration = "1.5 s"
    rate = "2.5 rad/s"
"""
TOUCH = """
    format = "scenario/2"
    base = "exp1"
    end_on_collision = true

    [[agent]]
    name = "R2"
    rules = ["late"]
"""


@pytest.fixture(scope="module")
def live():
    with LivePage() as page:
        page.begin(synthetic.header())
        yield page


@pytest.fixture
def screen(browser):
    resize(browser)
    yield
    browser.call("Emulation.clearDeviceMetricsOverride")


@pytest.fixture(scope="session")
def touched(tmp_path_factory):
    """Report of EXP1 with a rule that fires too late, so that the robot touches the box."""
    project = tmp_path_factory.mktemp("project")
    for name, content in (("rules/late.toml", LATE), ("scenarios/touch.toml", TOUCH)):
        (project / name).parent.mkdir()
        (project / name).write_text(textwrap.dedent(content))
    with contextlib.chdir(project):
        result = rocs_bt.run("touch", out=project / "out")
    assert result.summary.agents["R2"].outcome == "collision"
    return project / "out/report.html"
