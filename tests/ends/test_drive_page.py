"""`rocs-bt drive --live` in a browser: its page pauses the robot, and only Enter at the terminal lets it go on.

The time of the drive stops while the machine does (tests/awake.py), and each wait is for a state, so a busy machine
fails nothing here.
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from rocs_bt.event import MotionHeld, MotionReleased, RunControlled
from rocs_bt.record import Recording

from ..isolated import AWAKE
from ..studio.test_door import arrives
from ..studio.test_page import faults, press, text
from .test_drive_ends import NEUTRAL, ends_in_neutral

MAIN = "import sys\nfrom rocs_bt.cli.main import call\nsys.exit(call(sys.argv[1:]))\n"
ENTER = "press Enter at the robot's terminal"


@contextmanager
def shown(*options: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A drive with a terminal to type at, and the URL of its page."""
    Path("main.py").write_text(MAIN)
    command = [sys.executable, AWAKE, "main.py", "drive", "real", "--live", "--no-report", "--for", "3600", *options]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, text=True) as process:
        try:
            while not (line := process.stderr.readline()).startswith("Live: "):
                assert process.poll() is None
            yield process, line.removeprefix("Live: ").strip()
        finally:
            process.kill()


def buttons(browser) -> list[str]:
    """Texts of the buttons that control the run."""
    script = "JSON.stringify([...document.querySelectorAll('.control button')].filter((b) => !b.hidden)"
    return json.loads(browser.evaluate(f"{script}.map((b) => b.textContent))"))


def logged(browser, words: str) -> None:
    """Wait until the page's log has these words."""
    arrives(browser, f"document.querySelector('.log')?.innerText.includes({json.dumps(words)})")


def send(browser, kind: str, **more: str) -> None:
    """Send a command as the page sends it, whether or not it has a button for it."""
    asked = {"method": "POST", "headers": {"Content-Type": "application/json"}}
    body = json.dumps({"kind": kind, **more})
    browser.evaluate(f"fetch('control', {{...{json.dumps(asked)}, body: {json.dumps(body)}}}).then((a) => a.status)")


@pytest.mark.browser
@pytest.mark.parametrize("control", [False, True])
def test_a_pause_from_the_page_lasts_until_enter_at_the_terminal(browser, creep, robot, control):
    creep(isolated=False)
    with shown(*["--control"] * control) as (process, url):
        robot.wait_until_moving()
        browser.open(url)
        arrives(browser, "document.querySelector('.control') && !document.querySelector('.control').hidden")
        assert buttons(browser) == ["❚❚ pause", *(["swap …", "reload"] if control else [])]

        press(browser, "p")
        robot.wait_until_neutral()
        arrives(browser, "document.querySelector('.control button').disabled")
        assert (buttons(browser)[0], text(browser, ".control output")) == ("paused", ENTER)
        since = len(robot.commands)
        press(browser, "p")  # does nothing more

        send(browser, "continue")
        logged(browser, "continue refused: robots on hardware go on only when a person presses Enter at the terminal")
        send(browser, "reload", agent="R2", rules="avoid_collision")
        needs = "reload 'avoid_collision' refused: 'reload' on hardware needs rocs-bt drive --control."
        logged(browser, "avoid_collision: active rules (" if control else needs)
        robot.wait_until_neutral()
        assert robot.commands[since:].count(NEUTRAL) == len(robot.commands[since:])

        while "R2 held: paused by the page, waiting for go; press Enter to go\n" not in process.stderr.readline():
            assert process.poll() is None
        process.stdin.write("\n")
        process.stdin.flush()
        robot.wait_until_moving()
        arrives(browser, "!document.querySelector('.control button').disabled")
        assert (buttons(browser)[0], text(browser, ".control output")) == ("❚❚ pause", "")

        browser.open("about:blank")
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate(timeout=120.0)
    assert process.returncode == 128 + signal.SIGTERM
    assert "R2 goes on\n" in err
    assert ends_in_neutral(robot)
    assert faults(browser) == []
    events = list(Recording.open(Path("runs/real-1")).events())
    controlled = [(e.command, e.by, bool(e.refusal)) for e in events if isinstance(e, RunControlled)]
    assert controlled == [(kind, "the page", refused) for kind, refused in EXPECTED[control]]
    holds = [
        e.reason if isinstance(e, MotionHeld) else e.by for e in events if isinstance(e, MotionHeld | MotionReleased)
    ]
    assert holds == ["paused by the page, waiting for go", "the terminal"]


EXPECTED = {
    False: [("pause", False), ("continue", True), ("reload", True)],
    True: [("pause", False), ("continue", True), ("reload", False)],
}
