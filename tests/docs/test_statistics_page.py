"""docs/statistics.md: it names every function there is, and no other; its numbers are those of the code."""

import inspect
import re
from pathlib import Path

import pytest

from rocs_bt.compare import statistics
from rocs_bt.compare.statistics import rate, upper_bound
from rocs_bt.testing import comparing
from rocs_bt.testing.claims import Claims

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "statistics.md").read_text("utf-8")


def test_every_function_is_in_the_table_and_no_other():
    (rows,) = re.findall(r"\| what \| how \| in \|\n.*?\n(.*?)\n\n", PAGE, re.DOTALL)
    cells = [row.strip("| ").split(" | ")[-1] for row in rows.splitlines()]
    named = {name for cell in cells for name in re.findall(r"`(\w+)`", cell)}
    assert named == {name for name in statistics.__all__ if inspect.isfunction(getattr(statistics, name))}


@pytest.mark.parametrize("name", [name for name in vars(Claims) if name.startswith("assert_")])
def test_every_assertion_is_told(name):
    assert f"| `{name}(" in PAGE


def test_the_options_are_those_that_there_are():
    source = inspect.getsource(comparing.pytest_addoption)
    options = set(re.findall(r'"(--[\w-]+)"', source))
    assert options == set(re.findall(r"(--(?:compare-\w+|inconclusive))", PAGE))


def test_149_scenes_without_a_collision():
    import numpy as np

    assert upper_bound(np.zeros((149, 1))) <= 0.02 < upper_bound(np.zeros((148, 1)))
    assert "149 scenes" in PAGE
    assert rate(np.ones((2, 1))).high == 1.0
