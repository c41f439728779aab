"""Source of an expression: it is read as the same expression."""

import pytest
from hypothesis import given, settings

from rocs_bt.expression import parse
from rocs_bt.expression.source import source

from .test_evaluators import ENVIRONMENT, accepted, expressions


def same(text):
    node = accepted(text)
    assert node is None or parse(source(node, ENVIRONMENT), ENVIRONMENT) == node


@settings(max_examples=300, deadline=None)
@given(expressions(3))
def test_it_is_read_as_the_same_expression(text):
    same(text)


@pytest.mark.parametrize(
    "text",
    [
        "held(c > 0, 0.3 s)",
        "rate(min(a), 0.25 s) * 1 s > 0.1",
        "-c < inf",
        "c < -inf",
        "all(a[1:3] < 1)",
        "0.1 < c <= 1e-9",
        "not True",
    ],
)
def test_windows_infinities_slices_and_chains_too(text):
    same(text)


def test_aliases_are_expanded():
    environment = ENVIRONMENT.with_alias("low", parse("c - 1", ENVIRONMENT))
    assert source(parse("d < low", environment), ENVIRONMENT) == "(d < (c - 1.0))"
