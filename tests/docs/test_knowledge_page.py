"""docs/knowledge.md: its queries compile, its schema loads, its table names what there is."""

import re
from pathlib import Path

import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import NullSink
from rocs_bt.knowledge import SCHEMA, Knowledge, compile_query, find, load_schema
from rocs_bt.knowledge.query.pattern import SECTIONS
from rocs_bt.knowledge.query.scope import FORMS

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "knowledge.md").read_text("utf-8")
CHAPTER = PAGE.split("## Queries")[1].split("## History")[0]
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", PAGE.split("## History")[0], re.DOTALL)


@pytest.mark.parametrize("text", next(body for kind, body in BLOCKS if kind == "text").splitlines())
def test_each_query_of_the_page_is_one(text):
    assert compile_query(text).text == text


@pytest.mark.parametrize(
    "text", re.findall(r"^\| `([^`]+)` \| (?:things|an edge|a chain|from|over|gives|where)", CHAPTER, re.M)
)
def test_each_form_of_a_pattern_is_one(text):
    compile_query(text)


def test_the_schema_of_the_page_can_be_loaded(tmp_path):
    file = tmp_path / "charging.toml"
    file.write_text(next(body for kind, body in BLOCKS if kind == "toml"), encoding="utf-8")
    assert load_schema([file], SCHEMA).is_a("charger", "place")


def test_the_python_of_the_page_runs():
    knowledge = Knowledge("R2", SimulatedClock(0.05), NullSink())
    for i, name in enumerate(("cart", "anna", "box")):
        knowledge.graph.add(name, "object", pose=Pose2(float(i), 0.0), moves=True)
    knowledge.graph.set("R2", pose=Pose2(0.0, 0.0))
    code = next(body for kind, body in BLOCKS if kind == "python")
    names = {"knowledge": knowledge, "find": find}
    exec(compile(code, "page", "exec"), names)
    assert names["near"].names == ["cart", "anna", "box"]


def test_the_page_tells_of_all_functions_and_sections():
    for name in FORMS:
        assert f"`{name}(a" in CHAPTER
    for section in SECTIONS:
        assert f"`{section}`" in CHAPTER


def test_the_table_names_kinds_and_relations_that_there_are():
    table = PAGE.split("| what | kinds | relations |")[1].split("\n\n")[0]
    named = set(re.findall(r"`(\w+)`", table))
    columns = {"length", "width", "open", "cost", "covariance", "confidence", "time"}
    assert named - columns <= {*SCHEMA.kinds, *SCHEMA.relations}
