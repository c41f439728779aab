"""Strategies: guards, roles, preferences, and what was learned from their uses."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import KnowledgeError
from rocs_bt.event import NullSink
from rocs_bt.knowledge import Knowledge
from rocs_bt.knowledge.strategy import KEPT, Use, expected, similarity


@pytest.fixture
def knowledge():
    made = Knowledge("R2", SimulatedClock(0.05), NullSink())
    made.graph.add("hatch", "door", open=True)
    made.graph.add("is the hatch open", "question", query="door where open")
    made.graph.add("is it crowded", "question", query="person")
    made.strategy.add("through", guard="door where open", preference=0.2)
    made.strategy.add("around")
    return made


def meet(knowledge, name, outcome):
    knowledge.strategy.end(knowledge.strategy.begin(name), outcome)


def test_of_those_that_serve_the_preferred_one_is_chosen(knowledge):
    choice = knowledge.strategy.choose()
    assert choice.best == "through"
    assert choice.situation == {"is the hatch open": True, "is it crowded": False}
    knowledge.graph.set("hatch", open=False)
    choice = knowledge.strategy.choose()
    assert choice.best == "around"
    assert "through: no, its guard does not hold: door where open" in str(choice)


def test_what_failed_in_a_like_situation_is_chosen_no_more_and_elsewhere_still_is(knowledge):
    knowledge.graph.add("Ann", "person")
    for _ in range(3):
        meet(knowledge, "through", "failure")
    choice = knowledge.strategy.choose()
    assert choice.best == "around"
    assert "through: -0.40 (preference 0.2, succeeded in 0 of 3 similar situations)" in str(choice)
    knowledge.graph.remove("Ann")  # half alike: a sixteenth each
    assert knowledge.strategy.choose().best == "through"


def test_what_worked_is_preferred_to_what_is_preferred_on_paper(knowledge):
    for _ in range(4):
        meet(knowledge, "around", "success")
    assert knowledge.strategy.choose().best == "around"


def test_roles(knowledge):
    for role in ("attacker", "defender"):
        knowledge.graph.add(role, "role")
    knowledge.graph.relate("through", "suits", "attacker")
    assert knowledge.strategy.choose().best == "around"
    assert knowledge.strategy.choose("attacker").best == "through"
    assert "through: no, it is for attacker" in str(knowledge.strategy.choose("defender"))
    knowledge.graph.relate("R2", "plays", "attacker")
    assert knowledge.strategy.choose().best == "through"
    with pytest.raises(KnowledgeError, match="there is no node named 'goalie'"):
        knowledge.strategy.choose("goalie")


def test_a_fallback_is_the_first_that_serves(knowledge):
    knowledge.strategy.add("wait")
    knowledge.strategy.add("climb", guard="person", falls_back_to="wait")
    knowledge.graph.relate("through", "falls_back_to", "climb")
    assert knowledge.strategy.after("through", ["through"]) == "wait"
    assert knowledge.strategy.after("through", ["through", "wait"]) is None


def test_a_use_tells_what_happened(knowledge):
    use = knowledge.strategy.begin("through", "it is short")
    assert knowledge.strategy.used() == "through"
    knowledge.strategy.end(use, "failure", "the hatch fell shut")
    known = knowledge.graph.attributes(use)
    assert (known["why"], known["outcome"], known["reason"]) == ("it is short", "failure", "the hatch fell shut")
    knowledge.strategy.end(use, "success")
    assert knowledge.graph.get(use, "outcome") == "failure"
    assert knowledge.graph.edge(use, "met", "is the hatch open") == {"answer": True}


def test_old_uses_are_forgotten_and_one_in_force_is_not(knowledge):
    first = knowledge.strategy.begin("through")
    for _ in range(KEPT + 5):
        meet(knowledge, "around", "success")
    uses = knowledge.graph.nodes("use")
    assert len(uses) == KEPT
    assert first in uses
    assert f"use_{KEPT + 6}" in uses


def test_a_guard_that_is_no_query_is_named(knowledge):
    knowledge.graph.set("around", guard="door wher open")
    with pytest.raises(KnowledgeError, match="the guard of 'around' is not a valid query"):
        knowledge.strategy.choose()


answers = st.dictionaries(st.sampled_from("abcd"), st.booleans())
weights = st.dictionaries(st.sampled_from("abcd"), st.floats(0.0, 10.0))


@given(answers, answers, weights)
def test_likeness_is_symmetric_and_one_for_the_same(a, b, w):
    assert 0.0 <= similarity(a, b, w) <= 1.0
    assert similarity(a, b, w) == similarity(b, a, w)
    assert similarity(a, a, w) == 1.0


@given(st.lists(st.tuples(answers, st.booleans()), max_size=8), answers, weights)
def test_another_success_never_lowers_what_is_expected(past, now, w):
    uses = [Use("s", situation, success) for situation, success in past]
    before = expected("s", now, uses, w)
    assert 0.0 < before.share < 1.0
    assert expected("s", now, [*uses, Use("s", now, True)], w).share > before.share
    assert expected("s", now, [*uses, Use("s", now, False)], w).share < before.share
    assert expected("s", now, [*uses, Use("other", now, False)], w) == before
