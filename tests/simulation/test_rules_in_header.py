"""Rules in the header: file and line, action, priority, and the thresholds of the conditions with their values."""

import re
from pathlib import Path

import pytest

from rocs_bt import run
from rocs_bt.base.units import parse_quantity
from rocs_bt.catalog import Catalog
from rocs_bt.record import Recording

RULES = Path(__file__).resolve().parents[2] / "rules"


@pytest.mark.parametrize("scenario", ["exp1", "exp1_quadruped", "patrol_charge"])
def test_each_rule_is_found_in_its_file_with_the_values_of_its_thresholds(scenario, tmp_path):
    run(scenario, Catalog(), duration=0.1, report=False, out=tmp_path / "run")
    guards = [guard for agent in Recording.open(tmp_path / "run").header.agents for guard in agent.guards]
    assert guards
    for guard in guards:
        name, _, line = guard.place.partition(":")
        lines = (RULES / name).read_text("utf-8").splitlines()
        assert lines[int(line) - 1].strip() == f"[rule.{guard.rule.partition('/')[2]}]"
        block = re.split(r"\n\[rule\.\w+\]", "\n".join(lines[int(line) :]))[0]
        assert f'name = "{guard.action}"' in block
        assert f"priority = {guard.priority}" in block
        assert guard.doc in block
        declared = {found[1] for each in lines if (found := re.match(r"(\w+) = \"", each))}
        named = {word for word in re.findall(r"\w+", guard.when + " " + guard.until) if word in declared}
        assert set(guard.thresholds) <= named
        for value in guard.thresholds.values():
            assert parse_quantity(value)
