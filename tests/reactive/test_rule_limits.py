"""Hostile rule files: the absurd is refused with the limit, within a second of CPU time, and nothing of a file is run.

Mutated rule files are read in `test_fuzz_values` and in `tests/contracts/test_loaders.py`.
"""

import builtins
import re
import time

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.expression import MAX_DEPTH, MAX_LENGTH, MAX_SIZE
from rocs_bt.expression.parser import MAX_WINDOW
from rocs_bt.reactive import load_rules
from rocs_bt.reactive.analysis import examine_rules

from .examined import ACTIONS, ENVIRONMENT

CALLED = []


@pytest.fixture
def canary(monkeypatch):
    """Where nobody may come: a builtin that tells when it is called."""
    monkeypatch.setattr(builtins, "canary", lambda: CALLED.append(1), raising=False)
    CALLED.clear()


def rule(when):
    return f'format = "reflex/1"\n[rule.A]\nwhen = "{when}"\npriority = 1\n[rule.A.action]\nname = "Turn"\n'


ABSURD = {
    "length": (rule("speed > 0 m/s or " * 100 + "speed > 1 m/s"), f"at most {MAX_LENGTH} characters"),
    "brackets": (rule("(" * 60 + "speed" + ")" * 60 + " > 0 m/s"), f"at most {MAX_DEPTH} deep"),
    "minuses": (rule("-" * 60 + "speed > 0 m/s"), f"at most {MAX_DEPTH} deep"),
    "nots": (rule("not " * 60 + "speed > 0 m/s"), f"at most {MAX_DEPTH} deep"),
    "calls": (rule("min(" * 60 + "speed" + ")" * 60 + " > 0 m/s"), f"at most {MAX_DEPTH} deep"),
    "aliases": (
        'format = "reflex/1"\n[alias]\na0 = "speed + speed"\n'
        + "".join(f'a{i + 1} = "a{i} + a{i}"\n' for i in range(20))
        + rule("a20 > 0 m/s").partition("\n")[2],
        f"at most {MAX_SIZE} operations",
    ),
    "number": (rule("speed > " + "9" * 400 + " m/s"), "too large"),
    "index": (rule("front[" + "9" * 100 + "] > 0 m"), "has 4 values"),
    "window": (rule("held(speed > 0 m/s, 99999 h)"), f"{MAX_WINDOW:g} s"),
    "priority": (rule("speed > 0 m/s").replace("= 1\n", "= " + "9" * 18 + "\n"), "priority must be between"),
    "integer": (rule("speed > 0 m/s").replace("= 1\n", "= " + "9" * 30 + "\n"), "more than 64 bits"),
}


@pytest.mark.parametrize("what", ABSURD)
def test_the_absurd_is_refused_with_the_limit(tmp_path, what):
    text, limit = ABSURD[what]
    file = tmp_path / "absurd.toml"
    file.write_text(text, encoding="utf-8")
    start = time.process_time()
    faults = examine_rules(file, ENVIRONMENT, ACTIONS).faults
    assert time.process_time() - start < 1.0
    assert limit in " ".join(str(fault) for fault in faults)
    with pytest.raises(InputError, match=re.escape(limit)):
        load_rules(file, ENVIRONMENT, ACTIONS)


ATTACKS = [
    "__import__('os').system('x')", "canary()", "(lambda: canary())()", "front.__class__", "[canary() for x in front]",
    "speed if canary() else speed", "f'{canary()}'", "speed > canary", "min(*front)", "(x := canary())", "canary",
]  # fmt: skip  # attacks, several on a line


@pytest.mark.usefixtures("canary")
@pytest.mark.parametrize("attack", ATTACKS)
def test_nothing_of_a_rule_file_is_run(tmp_path, attack):
    file = tmp_path / "attack.toml"
    file.write_text(rule(attack), encoding="utf-8")
    assert any(not fault.warning for fault in examine_rules(file, ENVIRONMENT, ACTIONS).faults)
    with pytest.raises(InputError):
        load_rules(file, ENVIRONMENT, ACTIONS)
    assert not CALLED


def test_the_greatest_numbers_are_numbers(tmp_path):
    file = tmp_path / "great.toml"
    file.write_text(rule("speed < 1e307 m/s"), encoding="utf-8")
    assert not any(fault.message.startswith("cannot") for fault in examine_rules(file, ENVIRONMENT, ACTIONS).faults)
