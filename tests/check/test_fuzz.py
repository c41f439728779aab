"""A project with one mutated file: it is built, or refused as its check says; tests/contracts has each loader alone."""

from __future__ import annotations

import re
import shutil
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from rocs_bt.base.errors import InputError
from rocs_bt.catalog import Catalog, shipped_root
from rocs_bt.check import check_content
from rocs_bt.event import NullSink
from rocs_bt.running.simulated_stage import simulated_agents
from rocs_bt.simulation import build_world

SHIPPED = shipped_root()
ODD_VALUES = [
    "nan", "inf", "-inf", "1e400", '"1e400 m"', '"inf m"', '"-inf deg"', '"nan m"', "0", "-1", '""', '"x"', "[]", "{}",
    "[[]]", "true", '"0 Hz"', '"-20 Hz"', '"1e-300 s"', "1979-05-27", '"5 m5"', '"5 m/s/s/s/s"', '"../../etc"',
    '"a/b.py:C"',    '"own.py:Own"', "99999999999999999999", '"\\u0000"', '["0 m", 3]', '"0.5 m" # ü',
]  # fmt: skip  # short values, several on a line
NAMES = ["R1", "R2", "goal", "sonar", "wheels", "range", "pose", "base", "hull", "floor", "box", "left_motor", ""]


@st.composite
def mutations(draw, text: str) -> bytes:
    """One to three edits of a text: cut, doubled, moved, odd, or named like something else."""
    for _ in range(draw(st.integers(1, 3))):
        lines = text.splitlines(keepends=True) or ["\n"]
        at = draw(st.integers(0, len(lines) - 1))
        kind = draw(st.sampled_from(["cut", "drop", "double", "swap", "odd", "character", "insert", "clash"]))
        if kind == "cut":
            text = text[: draw(st.integers(0, len(text)))]
        elif kind == "drop":
            text = "".join(lines[:at] + lines[at + 1 :])
        elif kind == "double":
            text = "".join([*lines[:at], lines[at], *lines[at:]])
        elif kind == "swap":
            other = draw(st.integers(0, len(lines) - 1))
            lines[at], lines[other] = lines[other], lines[at]
            text = "".join(lines)
        elif kind == "odd":
            odd = draw(st.sampled_from(ODD_VALUES))
            lines[at] = re.sub(r'(=\s*)("[^"]*"|[^"\n]+)', lambda m, odd=odd: m[1] + odd, lines[at], count=1)
            text = "".join(lines)
        elif kind == "clash" and (taken := list(re.finditer(r'name ?= ?"([^"]*)"', text))):
            # One thing is called like another, of this file or of those that it must get along with.
            where, name = draw(st.sampled_from(taken)), draw(st.sampled_from([*(m[1] for m in taken), *NAMES]))
            text = text[: where.start(1)] + name + text[where.end(1) :]
        elif kind == "character" and text:
            place = draw(st.integers(0, len(text) - 1))
            text = text[:place] + draw(st.characters(codec="utf-8")) + text[place + 1 :]
        else:
            place = draw(st.integers(0, len(text)))
            text = text[:place] + draw(st.text(max_size=8)) + text[place:]
    return text.encode("utf-8", errors="surrogatepass")


def campaign(examples: int):
    """Repeatable in `make test`; `make soak` draws anew."""
    soak = examples > 1000
    return settings(
        max_examples=examples,
        deadline=None,
        derandomize=not soak,
        database=None,
        phases=[Phase.generate, Phase.shrink] if soak else [Phase.generate],
        suppress_health_check=list(HealthCheck),
    )


PROJECT = [
    "scenarios/exp1.toml",
    "scenarios/worlds/arena_box.xml",
    "rules/avoid_collision.toml",
    "planners/missions/go_to.py",
    "robots/pioneer_p3dx/robot.toml",
    "robots/pioneer_p3dx/robot.xml",
]
MUTATED = [name for name in PROJECT if not name.endswith(".py")]  # a mutated mission would be run


def fuzz_project(name: str, examples: int) -> None:
    """Mutate one file of a project that is whole otherwise, and do with it all that comes before the first period."""
    text = (SHIPPED / name).read_text(encoding="utf-8")

    @campaign(examples)
    @given(mutations(text))
    def holds(data: bytes) -> None:
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder).resolve()
            for each in PROJECT:
                (root / each).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(SHIPPED / each, root / each)
            (root / name).write_bytes(data)
            findings = check_content([root])
            assert all(fault.message and fault.file for fault in findings.faults)
            catalog = Catalog(root)
            try:
                scenario = catalog.load_scenario("exp1")
                stage = build_world(scenario, catalog, 1, NullSink())
                agents = simulated_agents(scenario, stage, catalog, NullSink())
            except InputError as error:
                assert all(fault.message and fault.file for fault in error.faults)
                assert findings.has_errors, f"a run refuses what check calls fine: {error}"
            else:
                assert agents

    holds()


@pytest.mark.parametrize("examples", [2, pytest.param(1100, marks=pytest.mark.soak)])
@pytest.mark.parametrize("name", MUTATED)
def test_a_mutated_project_is_built_or_refused_as_check_says(name, examples):
    fuzz_project(name, examples)
