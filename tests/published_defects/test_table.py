"""benchmarks/paper/README.md: each defect's test exists, and each test of a defect is in the table."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "benchmarks" / "paper" / "README.md").read_text("utf-8")
TABLE = PAGE.partition("## Defects of the published program\n")[2].partition("\n## ")[0]
ROWS = [
    line for line in TABLE.splitlines() if line.startswith("|") and not re.match(r"\| published program \||\|---", line)
]


def ids_of(file):
    """The ids of all tests of a file, without parameters."""
    name = file.relative_to(ROOT).as_posix()
    for node in ast.parse(file.read_text("utf-8")).body:
        if isinstance(node, ast.ClassDef):
            yield from (f"{name}::{node.name}::{f.name}" for f in node.body if isinstance(f, ast.FunctionDef))
        elif isinstance(node, ast.FunctionDef):
            yield f"{name}::{node.name}"


def named():
    return [re.fullmatch(r"\| (.+) \| (.+) \| `(tests/[^`]+)` \|", row).group(3) for row in ROWS]


def test_every_row_names_a_test_that_exists():
    existing = {test for file in (ROOT / "tests").rglob("test_*.py") for test in ids_of(file)}
    assert len(ROWS) >= 40
    assert [test for test in named() if test not in existing] == []


def test_every_test_of_a_defect_is_in_the_table():
    files = [*(ROOT / "tests").rglob("test_published_defects.py"), ROOT / "tests/published_defects/test_agent.py"]
    tests = {t for f in files for t in ids_of(f) if t.rpartition("::")[2].startswith("test_")}
    assert tests - set(named()) == set()
