"""What loading a rule set costs, counted in parsed texts and compiled functions, and what is ready afterwards."""

import math
from pathlib import Path

import numpy as np

from rocs_bt.base.toml_table import read_toml
from rocs_bt.expression import evaluator
from rocs_bt.reactive import RuleModel, arguments, load_rules

from .examined import ACTIONS, ENVIRONMENT

COUNT = 50
RULE = """
[rule.R{k}]
when = "min(front) < {near} m and held(speed > 0.1 m/s, 0.1 s)"
until = "min(front) > {far} m"
priority = {k}
on_invalid = "trip"
[rule.R{k}.action]
name = "Turn"
angle = "60 deg * side(rear[0] - rear[1]) if once(speed > 1 m/s, 1 s) else 0.5 rad"
rate = "2.5 rad/s"
patience = "3 * 0.5 s"
[rule.R{k}.action.on_invalid]
angle = "60 deg"
"""
TEXT = 'format = "reflex/1"\n' + "".join(RULE.format(k=k, near=0.3 + k / 100, far=0.4 + k / 100) for k in range(COUNT))


def counted(monkeypatch, module, name):
    """Replace a function of a module with one that also lists its calls."""
    calls, function = [], getattr(module, name)

    def call(*args, **kwargs):
        calls.append(args)
        return function(*args, **kwargs)

    monkeypatch.setattr(module, name, call)
    return calls


def load():
    return load_rules(read_toml(Path("many.toml"), TEXT), ENVIRONMENT, ACTIONS)


def test_each_text_is_parsed_once_and_only_constants_are_evaluated(monkeypatch):
    parsed = counted(monkeypatch, arguments, "parse")
    compiled = counted(monkeypatch, evaluator, "lower")
    rules = load().rules
    texts = [text for text, *_ in parsed]
    assert len(texts) == len(set(texts)) == 2 * COUNT + 3
    assert len(compiled) == COUNT  # 3 * 0.5 s of each rule
    assert {rule.arguments["rate"].value for rule in rules} == {2.5}
    assert {rule.arguments["patience"].value for rule in rules} == {1.5}


def test_a_rule_that_fires_has_nothing_left_to_compile(monkeypatch):
    model = RuleModel(load())
    compiled = counted(monkeypatch, evaluator, "lower")
    x = np.array([0.2] * 4 + [1.0, 2.0, math.inf, 0.5, 0.0, 0.0])
    for t in (0.0, 0.1):
        reflexes = model.react(x, t)
    assert len(reflexes) == COUNT
    assert {reflex.parameters["angle"] for reflex in reflexes} == {0.5}
    x[0] = math.nan
    blind = model.react(x, 0.2)
    assert {reflex.parameters["angle"] for reflex in blind} == {math.radians(60.0)}
    assert compiled == []
