"""docs/reuse.md: its tables are what the command and measurements.md give now."""

import re

from . import reuse

TEXT = reuse.PAGE.read_text("utf-8")


def test_every_table_is_as_the_command_gives_it():
    assert reuse.written(TEXT) == TEXT, "run: python tests/docs/reuse.py"


def test_all_three_questions_are_answered_and_no_table_is_written_by_hand():
    assert re.findall(r"^## (Q\d)", TEXT, re.MULTILINE) == ["Q1", "Q2", "Q3"]
    assert re.findall(r"<!-- benchmarks.paper.diff (\w+) (\w+) --markdown -->", TEXT) == [
        ("exp1", "exp2"),
        ("exp2", "exp3"),
        ("exp1", "exp3"),
    ]
    outside = re.sub(r"<!-- (benchmarks.paper.diff|measurements.md:) .*?<!-- end -->", "", TEXT, flags=re.DOTALL)
    assert "|---" not in outside


def test_the_answer_to_q1_has_its_figures():
    answer = TEXT.split("## Q1")[1].split("## Q2")[0]
    for row in (
        "| successes |",
        "| both routes active |",
        "| share of time with the reactive route in control, median |",
    ):
        assert row in answer
