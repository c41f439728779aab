"""The process that answers an editor: of the newest text and Python files, within a time limit."""

import os
import threading
import time

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.studio.editing import complete, faults
from rocs_bt.studio.editing.worker import Superseded, Worker

from ..waiting import until
from .conftest import MISSION

BUILD = """from .steps import leaf


def build(mission, *, goal: str = "goal"):
    return leaf(mission, goal)
"""
STEPS = """def leaf(mission, goal):
    return mission.act("GoTo", goal=goal)
"""
NODE = """from typing import Annotated
from rocs_bt.trees.nodes import SUCCESS, Instant


class Shine(Instant):
    \"\"\"Shines.\"\"\"

    colour: Annotated[str, "colour"] = "red"

    def update(self):
        return SUCCESS
"""
SCENARIO = """base = "exp1"
[[agent]]
name = "R2"
mission = "own"
[agent.parameters]
goal = "goal"
"""


@pytest.fixture(scope="module")
def worker():
    worker = Worker()
    yield worker
    worker.close()


@pytest.fixture
def project(tmp_path):
    """A project with a mission in Python, its sibling, and a node."""
    planners = tmp_path / "own" / "planners"
    for folder in (planners / "missions", planners / "nodes", tmp_path / "own" / "scenarios"):
        folder.mkdir(parents=True)
    (planners / "missions" / "own.py").write_text(BUILD)
    (planners / "missions" / "steps.py").write_text(STEPS)
    (planners / "nodes" / "shine.py").write_text(NODE)
    return tmp_path / "own"


def edit(file, old, new):
    """Replace a text by one of the same length, and leave the time of the change within the same second."""
    before = file.stat()
    assert len(old) == len(new)
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new))
    os.utime(file, ns=(before.st_atime_ns, before.st_mtime_ns + 1))


@pytest.mark.parametrize(
    ("file", "old", "new", "message"),
    [
        ("missions/own.py", "goal: str", "gaol: str", "'goal'"),
        ("missions/own.py", "return leaf", "return 1/0#", "division"),
        ("missions/steps.py", '"GoTo"', '"GoTi"', "'GoTi'"),
        ("missions/steps.py", "def leaf", "def lead", "leaf"),
        ("nodes/shine.py", "    colour:", "    shades:", "'colour'"),
    ],
)
def test_a_changed_python_file_is_seen_at_once_and_so_is_its_correction(worker, project, file, old, new, message):
    text = MISSION % '<Shine colour="red"/>'
    path = project / "planners" / "missions" / "mine.xml"
    if file.startswith("missions"):
        path, text = project / "scenarios" / "mine.toml", SCENARIO

    def errors():
        return [mark.message for mark in worker.ask("check", faults, path, text) if mark.level == "error"]

    assert not [each for each in errors() if message in each]
    edit(project / "planners" / file, old, new)
    assert [each for each in errors() if message in each]
    edit(project / "planners" / file, new, old)
    assert not [each for each in errors() if message in each]


def test_a_changed_node_is_completed(worker, project):
    path, text = project / "planners" / "missions" / "mine.xml", MISSION % "<Shine "
    at = text.index("<Shine ") + 7

    def ports():
        return {item.label for item in worker.ask("complete", complete, path, text, at)}

    assert "colour" in ports()
    edit(project / "planners" / "nodes" / "shine.py", "    colour:", "    shades:")
    assert "shades" in ports()
    assert "colour" not in ports()


def test_what_takes_too_long_or_dies_is_an_answer_and_the_next_question_is_answered():
    worker = Worker(limit=0.3)
    try:
        with pytest.raises(InputError, match=r"longer than 0\.3 s and was stopped"):
            worker.ask("slow", time.sleep, 600)
        with pytest.raises(InputError, match=r"ended the process.*exit code 7"):
            worker.ask("dead", os._exit, 7)
        with pytest.raises(InputError, match="no such"):
            worker.ask("wrong", _raise, "no such")
        assert worker.ask("good", abs, -1) == 1
    finally:
        worker.close()


def _hold(path):
    while not path.exists():
        time.sleep(0.01)


def _raise(text):
    raise InputError(text)


def test_of_questions_that_wait_only_the_newest_is_answered(worker, tmp_path):
    answers, started = {}, []

    def ask(name, key, *given):
        try:
            answers[name] = worker.ask(key, *given)
        except Superseded as error:
            answers[name] = error

    def start(name, key, *given):
        count = len(started)
        started.append(threading.Thread(target=ask, args=(name, key, *given)))
        before = worker._newest.get(key)
        started[count].start()
        until(lambda: worker._newest.get(key) is not before)

    worker.ask("first", abs, 1)
    start("holds", "other", _hold, tmp_path / "go")
    for number in range(1, 5):
        start(number, "same", abs, -number)
    start("another", "different", abs, -9)
    (tmp_path / "go").write_text("go")
    for thread in started:
        thread.join()
    assert answers.pop("holds") is None
    assert answers.pop("another") == 9
    assert answers.pop(4) == 4
    assert all(isinstance(each, Superseded) for each in answers.values())
    assert len(answers) == 3
