"""The pages on missions: every mission runs and prints what the page says, and every test that is named exists.

`python tests/docs/test_missions_course.py` writes the new outputs into the pages, after a change that is meant.
"""

import contextlib
import io
import re
from pathlib import Path

import pytest

from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.testing import missions

ROOT = Path(__file__).resolve().parents[2]
COURSE = ROOT / "docs" / "missions-course.md"
RULES = ROOT / "docs" / "missions-rules.md"
LESSONS = re.split(r"^(?=## \d)", COURSE.read_text("utf-8"), flags=re.MULTILINE)[1:]
FORM = re.compile(r"```(xml|python)\n(.*?)```\n\n```python\n(.*?)```\n\n```text\n(.*?)```", re.DOTALL)


def printed(language, mission, call):
    """What a lesson prints."""
    names = {"Pose2": Pose2, "mission": mission, **{name: getattr(missions, name) for name in missions.__all__}}
    names["play"] = lambda *args, **given: missions.play(*args, catalog=Catalog(), **given)
    if language == "python":
        exec(mission, names)
    with contextlib.redirect_stdout(io.StringIO()) as out:
        exec(call, names)
    return out.getvalue()


def test_there_are_eight_lessons_in_order():
    assert [lesson.split(".")[0] for lesson in LESSONS] == [f"## {i}" for i in range(1, 9)]
    assert all(len(FORM.findall(lesson)) == 1 for lesson in LESSONS)


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.split("\n")[0][3:])
def test_a_lesson_prints_what_it_says(lesson):
    ((language, mission, call, said),) = FORM.findall(lesson)
    assert printed(language, mission, call) == said
    assert said


@pytest.mark.parametrize("example", FORM.findall(RULES.read_text("utf-8")), ids=("ports", "names", "conditions"))
def test_an_example_of_the_rules_prints_what_it_says(example):
    language, mission, call, said = example
    assert printed(language, mission, call) == said
    assert said


def test_every_rule_names_tests_that_exist():
    tables = re.findall(r"^\|.*\| test \|\n\|[-|]+\|\n((?:\|.*\n)+)", RULES.read_text("utf-8"), re.MULTILINE)
    rows = [row for table in tables for row in table.splitlines()]
    assert len(rows) > 40
    for row in rows:
        named = re.findall(r"`([\w/]+\.py)::([\w:]+)`", row.rsplit(" | ", 1)[1])
        assert named, row
        for file, names in named:
            text = (ROOT / "tests" / file).read_text("utf-8")
            for name in names.split("::"):
                assert re.search(rf"^ *(def|class) {name}\b", text, re.MULTILINE), f"{file} has no {name}"


def _renewed(match):
    language, mission, call, _ = match.groups()
    return f"```{language}\n{mission}```\n\n```python\n{call}```\n\n```text\n{printed(language, mission, call)}```"


if __name__ == "__main__":
    for page in (COURSE, RULES):
        page.write_text(FORM.sub(_renewed, page.read_text("utf-8")), "utf-8")
