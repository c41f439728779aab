"""Values and margins of expressions: the kernel against numpy, and temporal operators against their definitions."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.errors import InputError
from rocs_bt.base.signal import Signal
from rocs_bt.base.units import LENGTH, NONE, SPEED
from rocs_bt.expression import Environment, Expression, Values, compile_expression, evaluator, parse, reading
from rocs_bt.reactive.analysis.validity import decided

from .. import needs

ENVIRONMENT = Environment.packed([Signal("a", 4), Signal("b", 4), Signal("c"), Signal("d"), Signal("e", 2)])
SIZE = 12

numbers = st.sampled_from(["0", "1", "-2", "0.5", "3", "inf", "1e300"])


def singles(groups, singles, truths):
    return st.one_of(
        st.tuples(st.sampled_from(["+", "-", "*", "/"]), singles, singles).map(lambda t: f"({t[1]} {t[0]} {t[2]})"),
        st.tuples(st.sampled_from(["min", "max", "sum", "mean"]), groups).map(lambda t: f"{t[0]}({t[1]})"),
        st.tuples(st.sampled_from(["min", "max"]), groups, singles).map(lambda t: f"{t[0]}({t[2]}, {t[1]})"),
        st.tuples(st.sampled_from(["abs", "sign", "side", "sqrt", "-"]), singles).map(lambda t: f"{t[0]}({t[1]})"),
        st.tuples(singles, singles, singles).map(lambda t: f"clip({', '.join(t)})"),
        st.tuples(singles, singles).map(lambda t: f"hypot({', '.join(t)})"),
        st.tuples(groups, st.sampled_from("<>"), singles).map(lambda t: f"count({' '.join(t)})"),
        st.tuples(singles, truths, singles).map(lambda t: f"({t[0]} if {t[1]} else {t[2]})"),
        singles.map(lambda s: f"(wrap_angle({s} * 1 rad) / 1 rad)"),
        st.tuples(singles, singles).map(lambda t: f"(atan2({', '.join(t)}) / 1 rad)"),
        groups.map(lambda g: f"argmin({g})"),
        groups.map(lambda g: f"min_valid({g}, 3)"),
        groups.map(lambda g: f"dot({g}, [1, -0.5, 0, 2])"),
        truths.map(lambda t: f"(time_since({t}) / 1 s)"),
        st.tuples(singles, windows).map(lambda t: f"(rate({t[0]}, {t[1]}) * 1 s)"),
    )


windows = st.sampled_from(["0.1 s", "0.25 s", "1 s", "10 s"])


def truths(groups, singles, truths):
    signs = st.sampled_from(["<", "<=", ">", ">=", "==", "!="])
    return st.one_of(
        st.tuples(singles, signs, singles).map(lambda t: f"({' '.join(t)})"),
        st.tuples(singles, signs, singles, signs, singles).map(lambda t: f"({' '.join(t)})"),
        st.tuples(truths, st.sampled_from(["and", "or"]), truths).map(lambda t: f"({' '.join(t)})"),
        truths.map(lambda t: f"(not {t})"),
        st.tuples(truths, truths).map(lambda t: f"({t[0]} implies {t[1]})"),
        st.tuples(st.sampled_from(["held", "once"]), truths, windows).map(lambda t: f"{t[0]}({t[1]}, {t[2]})"),
        st.tuples(truths, truths, windows).map(lambda t: f"since({', '.join(t)})"),
        st.tuples(truths, truths, truths).map(lambda t: f"({t[0]} if {t[1]} else {t[2]})"),
        st.tuples(st.sampled_from(["any", "all"]), groups, signs, singles, signs, groups).map(
            lambda t: f"{t[0]}({' '.join(t[1:])})"
        ),
    )


def groups(groups, singles, truths):
    return st.one_of(
        st.tuples(groups, truths, groups).map(lambda t: f"({t[0]} if {t[1]} else {t[2]})"),
        st.tuples(groups, st.sampled_from("+-*/"), singles).map(lambda t: f"({' '.join(t)})"),
        st.tuples(groups, st.sampled_from("+-*/"), groups).map(lambda t: f"({' '.join(t)})"),
        st.tuples(groups, singles, singles).map(lambda t: f"clip({', '.join(t)})"),
        groups.map(lambda g: f"abs(-{g})"),
    )


def expressions(depth):
    """Groups of four, singles and truths, up to a depth."""
    vector = st.sampled_from(["a", "b", "a[0:4]"])
    single = st.one_of(numbers, st.sampled_from(["c", "d", "a[1]", "e[0]", "min_valid(a, 2)", "min_valid(e, 1)"]))
    truth = st.sampled_from(["(c < 1)", "True", "any(b > 0)"])
    for _ in range(depth):
        vector, single, truth = (
            st.one_of(vector, groups(vector, single, truth)),
            st.one_of(single, singles(vector, single, truth)),
            st.one_of(truth, truths(vector, single, truth)),
        )
    return st.one_of(single, truth)


values = st.one_of(
    st.sampled_from([0.0, -0.0, 1.0, -1.0, 0.5, math.inf, -math.inf, math.nan]),
    st.floats(-10.0, 10.0),
    st.floats(allow_nan=False),
)
snapshots = st.one_of(
    st.lists(values, min_size=SIZE, max_size=SIZE), st.lists(st.floats(-2.0, 2.0), min_size=SIZE, max_size=SIZE)
)


def accepted(text):
    try:
        return parse(text, ENVIRONMENT)
    except InputError as error:
        assert "deep" in str(error) or "operations" in str(error) or "characters" in str(error), text
        return None


steps = st.sampled_from([0.0, 0.003, 0.01, 0.05, 0.05, 0.1, 0.25, 2.0, -0.3])


def in_numpy(node):
    """An expression with margins that the kernel does not compute."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(evaluator, "kernel_missing", lambda: "not for this test")
        made = Expression(node, margins=node.kind.boolean)
        made.prepare()
    return made


def bits(value):
    """A value or margin such that only the same bits are equal; NaN is NaN."""
    return None if value is None or value != value else (type(value), float(value).hex())


@needs.kernel
@settings(max_examples=300, deadline=None)
@given(expressions(3), st.lists(st.tuples(snapshots, steps), min_size=1, max_size=12))
def test_the_kernel_and_numpy_give_the_same_bits(text, rows):
    node = accepted(text)
    if node is None:
        return
    kernel, numpy, plain, t = Expression(node, margins=node.kind.boolean), in_numpy(node), Expression(node), 10.0
    for x, dt in rows:
        t += dt
        value = kernel(x, t)
        assert value is None or not math.isnan(value)
        assert bits(value) == bits(numpy(np.array(x), t)) == bits(plain(x, t))
        assert bits(kernel.margin) == bits(numpy.margin)
        known = value is not None and kernel.margin == kernel.margin != 0
        assert node.temporal or not known or value is (kernel.margin > 0)


@needs.kernel
@settings(max_examples=60, deadline=None)
@given(expressions(2), st.lists(snapshots, min_size=1, max_size=30))
def test_a_series_has_the_values_of_its_samples(text, rows):
    node = accepted(text)
    if node is None:
        return
    one, t = Expression(node), np.arange(len(rows)) * 0.05
    found, group = Values([node, parse("a + d", ENVIRONMENT)])(np.array(rows), t)
    expected = [one(x, when) for x, when in zip(rows, t, strict=True)]
    assert [bits(v) for v in found.tolist()] == [bits(None if v is None else float(v)) for v in expected]
    with np.errstate(invalid="ignore"):  # infinities of both signs
        assert np.array_equal(group, np.array(rows)[:, :4] + np.array(rows)[:, 9:10], equal_nan=True)


def every(values):
    return 0.0 if 0.0 in values else math.nan if any(map(math.isnan, values)) else 1.0


def window(t, i, length):
    """The samples that were valid at any time of a window that ends at sample i: each until the next one."""
    return [j for j in range(i + 1) if j == i or t[i] - t[j + 1] < length - 1e-9]


def defined(op, t, c, a, b, i, length):
    """Value of a temporal operator at sample i, by its definition, from all samples."""
    if op == "held":
        return every([a[j] for j in window(t, i, length)]) if t[i] - t[0] >= length - 1e-9 else 0.0
    if op == "once":
        return 1.0 - every([1.0 - a[j] for j in window(t, i, length)])
    if op == "since":
        return 1.0 - every([1.0 - every([b[j], *a[j + 1 : i + 1]]) for j in window(t, i, length)])
    if op == "time_since":
        times = [t[j] for j in range(i + 1) if a[j] == 1.0]
        return math.nan if math.isnan(a[i]) else t[i] - times[-1] if times else math.inf
    j = window(t, i, length)[0]
    return (c[i] - c[j]) / (t[i] - t[j]) if t[i] - t[j] >= length - 1e-9 else math.nan


@pytest.mark.parametrize(
    ("op", "text"),
    [
        ("held", "held(c > 0, 0.3 s)"),
        ("once", "once(c > 0, 0.3 s)"),
        ("since", "since(c > 0, d > 0.5, 0.3 s)"),
        ("time_since", "time_since(c > 0) / 1 s"),
        ("rate", "rate(c, 0.3 s) * 1 s"),
    ],
)
@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from([0.01, 0.05, 0.08]))
def test_temporal_operators_are_as_defined(op, text, seed, period):
    rng = np.random.default_rng(seed)
    t = 10.0 + np.cumsum(period * rng.choice([1.0, 1.0, 1.7], 100))
    x = np.where(rng.random((100, SIZE)) < 0.05, math.nan, rng.uniform(-0.2, 1.0, (100, SIZE)))
    c, a, b = (
        x[:, 8],
        np.where(np.isnan(x[:, 8]), np.nan, x[:, 8] > 0),
        np.where(np.isnan(x[:, 9]), np.nan, x[:, 9] > 0.5),
    )
    (found,) = Values([parse(text, ENVIRONMENT)])(x, t)
    expected = [defined(op, t.tolist(), c.tolist(), a.tolist(), b.tolist(), i, 0.3) for i in range(100)]
    assert np.array_equal(found, expected, equal_nan=True)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from([
    "c > 0.2 and not (d > 0.5 or c > d - 1)", "any(a > c) if d > 0 else all(a < 1)", "held(c > 0, 0.3 s)",
    "once(c > 0.5, 0.3 s) and d != 0.3", "since(d > -0.5, c > 0.8, 0.4 s)",
    "0 < c < 0.5 or held(once(d > 0.9, 0.1 s), 0.2 s)",
]))  # fmt: skip  # expressions, several on a line
def test_values_that_change_by_less_than_the_margin_keep_the_truth(seed, text):
    """Definition of margins: A. Donze, O. Maler, "Robust Satisfaction of Temporal Logic over Real-Valued Signals"."""
    rng = np.random.default_rng(seed)
    x, node = rng.uniform(-1.0, 1.0, (20, SIZE)), parse(text, ENVIRONMENT)
    one = Expression(node, margins=True)
    for k, row in enumerate(x):
        truth = one(row, k * 0.05)
    reach = min(abs(one.margin), 10.0) / 2.0  # a difference of two signals changes by twice as much
    for _ in range(5):
        other = Expression(node)
        for k, row in enumerate(x + rng.uniform(-0.99, 0.99, x.shape) * reach):
            changed = other(row, k * 0.05)
        assert changed is truth


@pytest.mark.parametrize("text", ["any(b > 0) if c < 1 else any(b > 0)", "any(b > 0 if c < 1 else b > 0)"])
def test_a_choice_without_a_condition_has_no_margin(text):
    choice = Expression(parse(text, ENVIRONMENT), margins=True)
    assert choice([0.0] * 4 + [-1.0] * 4 + [math.nan] + [0.0] * 3) is None
    assert math.isnan(choice.margin)


def test_what_is_invalid_counts_only_where_it_matters():
    x = [math.nan] * SIZE
    x[8], x[9] = 1.0, 2.0
    for text, expected in [
        ("c > 0 or a[0] > 0", True),
        ("a[0] > 0 or c > 0", True),
        ("c < 0 and a[0] > 0", False),
        ("c > 0 and a[0] > 0", None),
        ("c < 0 or a[0] > 0", None),
        ("not a[0] > 0", None),
        ("a[0] if c > 0 else d", None),
        ("d if c > 0 else a[0]", 2.0),
        ("c if a[0] > 0 else c", None),
        ("c < 0 < a[0]", False),
        ("min(c, a[0])", None),
    ]:
        assert compile_expression(text, ENVIRONMENT)(x) is expected or expected == 2.0, text
    x[:4] = [3.0, math.nan, 1.0, 2.0]
    for text, expected in [
        ("any(a < 2)", True),
        ("any(a < 0)", None),
        ("all(a > 2)", False),
        ("all(a > 0)", None),
        ("count(a > 0)", None),
        ("argmin(a)", None),
        ("min_valid(a, 3)", 1.0),
        ("min_valid(a, 4)", None),
    ]:
        assert compile_expression(text, ENVIRONMENT)(x) == expected, text


@pytest.mark.parametrize(
    "text", ["c / 0", "inf - inf", "0 * c * inf", "inf / inf", "sqrt(-1)", "c / (d - d)", "sum(a - inf) + sum(a + inf)"]
)
def test_what_has_no_value_is_invalid(text):
    assert compile_expression(text, ENVIRONMENT)([math.inf] * SIZE) is None


def test_a_guarded_division_is_never_computed():
    guarded = compile_expression("c > 0 and 1 / c > 0.5", ENVIRONMENT)
    x = [0.0] * SIZE
    assert guarded(x) is False
    x[8] = 1.0
    assert guarded(x) is True


def test_no_echo_is_farther_than_every_threshold():
    assert compile_expression("min(a) > 1e300", ENVIRONMENT)([math.inf] * SIZE) is True


def test_min_valid_tolerates_broken_values_up_to_its_bound():
    tolerant = compile_expression("min_valid(a, 2)", ENVIRONMENT)
    x = [math.nan, 3.0, math.nan, 2.0] + [0.0] * (SIZE - 4)
    assert tolerant(x) == 2.0
    x[1] = math.nan
    assert tolerant(x) is None


def test_margins_are_in_the_unit_of_what_is_compared_and_shares_of_a_span_where_units_mix():
    environment = Environment.packed(
        [Signal("front", 2, (LENGTH,), bounds=(0.0, 5.0)), Signal("speed", 1, (SPEED,)), Signal("wide", 1, (LENGTH,))]
    )
    x = [0.3, 4.0, 0.5, 1.0]
    for text, margin in [
        ("min(front) < 0.5 m", 0.2),
        ("min(front) < 0.5 m and wide < 0.9 m", -0.1),
        ("min(front) < 0.5 m or wide < 0.9 m", 0.2),
        ("not 0.1 m < min(front) < 0.5 m", -0.2),
        ("any(front > 1 m)", 3.0),
        ("all(front > 1 m)", -0.7),
        ("min(front) == wide", -0.7),
        ("min(front) != wide", 0.7),
        ("True", math.inf),
        ("min(front) < 0.5 m and speed > 0.1 m/s", 0.2 / 5.0),  # speed has no bounds: 1 m/s
        ("min(front) > 0.5 m or speed > 0.6 m/s", -0.2 / 5.0),
        ("held(min(front) < 0.5 m, 1 s)", -math.inf),  # not seen for so long
        ("once(min(front) < 0.5 m, 1 s)", 0.2),
    ]:
        expression = Expression(parse(text, environment), margins=True)
        expression(x)
        assert expression.margin == pytest.approx(margin), text


def test_an_expression_remembers_its_calls_and_begins_anew_when_time_goes_back():
    held = compile_expression("held(c > 0, 0.1 s)", ENVIRONMENT)
    x = [0.0] * SIZE
    x[8] = 1.0
    assert [held(x, t) for t in (0.0, 0.05, 0.1, 0.15, 0.0, 0.1)] == [False, False, True, True, False, True]
    held.reset()
    assert held(x, 0.2) is False


def test_reading_tells_what_was_compared():
    environment = Environment.packed(
        [Signal("front", 3, (LENGTH,)), Signal("speed", 1, (SPEED,)), Signal("n", 1, (NONE,))]
    )
    node = parse("min(front) < 0.3 m and (speed > 0.1 m/s or n == 2) and min(front) > 0 m", environment)
    x = [0.21234, 1.0, math.inf, math.nan, 2.0]
    assert reading(node, x) == "min(front) = 0.212 m, n = 2"  # which made the `or` hold
    assert reading(node, [*x[:4], 1.0]) == "min(front) = 0.212 m, speed = invalid"  # which made it invalid
    assert reading(node, [*x[:3], 0.0, 1.0]) == "min(front) = 0.212 m, speed = 0 m/s, n = 1"


def test_environment_of_a_signal_table():
    class Layout:
        names = ("speed", "front")

        def spec(self, name):
            return Signal(name, 3 if name == "front" else 1, (LENGTH,))

        def slice_of(self, name):
            return slice(5, 8) if name == "front" else slice(2, 3)

    environment = Environment.of(Layout())
    assert compile_expression("max(front) - speed", environment)([0, 0, 1, 0, 0, 2, 3, 4]) == 3


DECIDED = [
    "-c", "abs(c)", "sign(c)", "side(c)", "min(u)", "max(u)", "count(u > 0)", "any(u > 0)", "all(u > 0)", "not c > 0",
    "c > 0 and u[0] > 0", "c > 0 or u[0] > 0", "c if u[0] > 0 else u[1]", "clip(c, -1, 1)", "c / 2", "c / 0", "sqrt(c)",
    "c + u[0]", "c - u[0]", "c * u[0]", "c / u[0]", "sum(u)", "mean(u)", "dot(u, [1, 0])", "min_valid(u, 2) - c",
    "v[0] + v[1]", "v[0] - v[1]", "v[0] * v[1]", "sum(v)", "mean(v)", "dot(v, [1, 0])",
]  # fmt: skip  # expressions, several on a line


@pytest.mark.parametrize("text", DECIDED)
def test_what_valid_signals_decide_is_what_no_valid_signals_make_invalid(text):
    node = parse(text, Environment.packed([Signal("u", 2), Signal("c"), Signal("v", 2, bounds=(-2.0, 2.0))]))
    free, bounded = (-math.inf, -1.0, 0.0, math.inf), (-2.0, 0.0, 2.0)
    compiled = Expression(node)
    valid = all(compiled(x, 10.0) is not None for x in itertools.product(free, free, free, bounded, bounded))
    assert decided(node, node.reads()) == valid
