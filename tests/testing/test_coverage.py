"""Coverage of trees, as an object and as the option of the pytest plugin."""

import re
import subprocess
import sys

import py_trees
import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.testing.missions import Breaks, TreeCoverage, play

CATALOG = Catalog()
TEXT = """<root BTCPP_format="4"><BehaviorTree ID="M">
  <Fallback name="top">
    <Sequence name="way"><When name="clear" expression="front > 1 m"/><GoTo name="go" goal="g"/></Sequence>
    <Speak text="no"/>
  </Fallback></BehaviorTree></root>"""


@pytest.fixture
def coverage():
    return TreeCoverage()


def test_it_counts_over_runs(coverage):
    def run(letters, front="2 m"):
        play(TEXT, leaves={"go": letters}, signals={"front": front}, coverage=coverage, catalog=CATALOG)

    run("RS")
    assert coverage.leaves() == (2, 3)
    assert coverage.branches() == (4, 9)
    assert coverage.missing() == [
        "mission: top never FAILURE",
        "mission: top/way never FAILURE",
        "mission: top/way/clear never FAILURE",
        "mission: top/way/go never FAILURE",
        "mission: top/Speak never ticked",
    ]
    run("F")
    run("S", front="0 m")
    assert coverage.leaves() == (3, 3)
    assert coverage.branches() == (8, 9)
    assert coverage.missing() == ["mission: top never FAILURE"]
    counts = coverage.trees["mission"]["top/way/go"].counts
    assert counts == {"RUNNING": 1, "SUCCESS": 1, "FAILURE": 1}


def test_the_table_marks_what_is_missing(coverage):
    play(TEXT, leaves={"go": "RS"}, signals={"front": "2 m"}, coverage=coverage, catalog=CATALOG)
    lines = coverage.table().splitlines()
    assert lines[0].split() == ["mission", "S", "F", "R", "K"]
    assert [line.split() for line in lines[1:]] == [
        ["top", "1", "!", "1", "-"],
        ["way", "1", "!", "1", "-"],
        ["clear", "1", "!", "-", "-"],
        ["go", "1", "!", "1", "-"],
        ["Speak", "!", "-", "-", "-", "never", "ticked"],
        ["leaves", "2/3", "ticked,", "branches", "4/9"],
    ]


def test_py_trees_own_nodes_are_counted_too(coverage):
    def build(mission):
        return py_trees.composites.Selector(
            "any", memory=False, children=[py_trees.behaviours.Failure("no"), mission.act("GoTo", goal="g")]
        )

    play(build, leaves={"GoTo": "S"}, coverage=coverage, catalog=CATALOG)
    assert coverage.missing() == [
        "build: any never FAILURE",
        "build: any/no never SUCCESS",
        "build: any/GoTo g never FAILURE",
    ]


def test_what_was_broken_on_purpose_counts_as_the_node_that_it_was(coverage):
    def run(**given):
        play(TEXT, leaves={"go": "S"}, signals={"front": "2 m"}, coverage=coverage, catalog=CATALOG, **given)

    run(faults={"go": lambda leaf: Breaks("jam", leaf), "way": lambda node: Breaks("never", node, at=9)})
    run()
    assert coverage.trees["mission"]["top/way/go"].counts == {"FAILURE": 1, "SUCCESS": 1}
    assert list(coverage.trees["mission"]) == ["top", "top/way", "top/way/clear", "top/way/go", "top/Speak"]


def test_the_option_prints_a_table_at_the_end(tmp_path):
    file = tmp_path / "test_mission.py"
    file.write_text('def test_it(play):\n    assert play("go_to", leaves={"GoTo": "RS"}).outcome == "SUCCESS"\n')

    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--tree-coverage", str(file)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    told = done.stdout
    assert re.search(r"tree coverage =+\ngo_to +S +F +R +K\n +GoTo goal +1 +! +1 +-\nleaves 1/1", told)
    assert "branches 1/2" in told
