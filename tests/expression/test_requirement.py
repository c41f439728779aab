"""Requirements against their meaning, taken word by word over the whole trace."""

import math
import random

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.base.signal import Signal
from rocs_bt.expression import Environment, Expression, evaluate, parse, parse_requirement

ENVIRONMENT = Environment.packed([Signal("a"), Signal("b"), Signal("g", 3)])


def verdicts(text, rows):
    """The requirement, and its value after each row; each margin has the sign of its value."""
    requirement = parse_requirement(text, ENVIRONMENT)
    live, found = Expression(requirement.node, margins=True), []
    for t, *x in rows:
        value = live(x, t)
        assert live.margin != live.margin or value is None or live.margin == 0 or value is (live.margin > 0)
        found.append(value)
    return requirement, found


def expected(rows, i, window):
    """Of `a > 0 implies within WINDOW b > 0`, about the time of row i, by hand: signals stand until the next row."""
    t = rows[i][0]
    if not rows[i][1] > 0:
        return True
    ends = [row[0] for row in rows[1:]] + [math.inf]
    later = [j for j in range(i, len(rows)) if rows[j][0] <= t + window + 1e-9 and ends[j] > t]
    return any(rows[j][2] > 0 for j in later)


@pytest.mark.parametrize("seed", range(100))
def test_a_response_is_told_after_its_window_as_it_was(seed):
    draw, window = random.Random(seed), 0.2
    rows = [
        (0.05 * k, draw.choice([-1.0, -1.0, 2.0]), draw.choice([-1.0, -2.0, -3.0, 1.0]), 0, 0, 0) for k in range(40)
    ]
    requirement, found = verdicts("always (a > 0 implies within 0.2 s b > 0)", rows)
    assert (requirement.always, requirement.delay) == (True, window)
    # A row that stands until exactly when the window begins is not in it.
    assert found[:4].count(False) == 0
    assert found[4:] == [expected(rows, i, window) for i in range(36)]


def test_precedence_and_nesting():
    for left, right in [
        ("a > 0 and b > 0 implies a > 1 or b > 1", "not (a > 0 and b > 0) or (a > 1 or b > 1)"),
        ("a > 0 implies b > 0 implies a > 1", "not (a > 0) or (not (b > 0) or a > 1)"),
        ("a > 0 or b > 0 implies not a > 1", "not (a > 0 or b > 0) or not a > 1"),
        ("1 if (a > 0 implies b > 0) else 2", "1 if not (a > 0) or b > 0 else 2"),
    ]:
        first, second = parse(left, ENVIRONMENT), parse(right, ENVIRONMENT)
        assert all(
            evaluate(first, [a, b, 0, 0, 0]) == evaluate(second, [a, b, 0, 0, 0])
            for a in (-1, 0.5, 2)
            for b in (-1, 0.5, 2)
        ), left


def test_delays_add_up():
    text = "always (a > 0 implies within 0.2 s (b > 0 and within 1 s a < 0))"
    assert parse_requirement(text, ENVIRONMENT).delay == pytest.approx(1.2)
    environment = ENVIRONMENT.with_alias("patience", parse("2 * 0.15 s", ENVIRONMENT))
    assert parse_requirement("within patience b > 0", environment).delay == pytest.approx(0.3)
    assert parse_requirement("within 300 ms b > 0", environment).delay == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("text", "message"), [("within 1 s a > 0", "allowed only in requirements"), ("always a > 0", "always")]
)
def test_a_guard_looks_at_the_past_alone(text, message):
    with pytest.raises(InputError, match=message):
        parse(text, ENVIRONMENT)
