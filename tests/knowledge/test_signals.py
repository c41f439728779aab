from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rocs_bt.base.errors import KnowledgeError
from rocs_bt.base.signal import Signal
from rocs_bt.base.units import ANGLE, LENGTH
from rocs_bt.knowledge import SignalTable

inf, nan = math.inf, math.nan


def table(*signals: Signal) -> SignalTable:
    made = SignalTable()
    for signal in signals:
        made.declare(signal)
    return made


def test_a_signal_nobody_wrote_is_nan_in_every_reading() -> None:
    signals = table(Signal("front", 2), Signal("speed"))
    assert np.isnan(signals.snapshot(0.0)).all()
    assert np.isnan(signals.read("front", 0.0)).all()
    assert math.isnan(signals.value("speed", 0.0))
    assert signals.stamp("speed") == -inf


def test_a_snapshot_holds_the_values_in_the_order_of_declaration() -> None:
    signals = table(Signal("front", 2), Signal("speed"))
    signals.write("speed", 0.5, 0.0)
    signals.write("front", [1.0, 2.0], 0.0)
    assert signals.snapshot(0.0).tolist() == [1.0, 2.0, 0.5]
    assert signals.names == ("front", "speed")
    assert signals.snapshot(0.0)[signals.slice_of("speed")].tolist() == [0.5]
    assert signals.size == 3


def test_a_snapshot_goes_into_the_callers_buffer_and_is_a_copy() -> None:
    signals = table(Signal("speed"))
    signals.write("speed", 1.0, 0.0)
    buffer = np.zeros(1)
    assert signals.snapshot(0.0, buffer) is buffer
    signals.write("speed", 2.0, 0.0)
    assert buffer.tolist() == [1.0]


@pytest.mark.parametrize("out", [np.zeros(2), np.zeros((1, 1)), np.zeros(1, dtype=np.float32)])
def test_a_snapshot_refuses_a_buffer_that_does_not_fit(out: np.ndarray) -> None:
    with pytest.raises(KnowledgeError, match=r"shape \(1,\)"):
        table(Signal("speed")).snapshot(0.0, out)


def test_what_was_read_is_a_copy() -> None:
    signals = table(Signal("front", 2))
    signals.write("front", [1.0, 2.0], 0.0)
    signals.read("front", 0.0)[:] = 9.0
    assert signals.read("front", 0.0).tolist() == [1.0, 2.0]


def test_the_writers_own_array_stays_untouched_and_is_not_kept() -> None:
    signals = table(Signal("front", 2, bounds=(0.0, 5.0)))
    values = np.array([-1.0, 2.0])
    signals.write("front", values, 0.0)
    assert values.tolist() == [-1.0, 2.0]
    values[1] = 3.0
    assert signals.read("front", 0.0)[1] == 2.0


@pytest.mark.parametrize("steps", [1, 2, 3])
def test_a_value_is_valid_up_to_its_age_and_stale_after_it(steps: int) -> None:
    # Ages as the control loop makes them: k * 0.05 s, with their rounding.
    signals = table(Signal("front", 2, max_age=steps * 0.05))
    for k in range(200):
        signals.write("front", [1.0, 2.0], k * 0.05)
        assert not np.isnan(signals.snapshot((k + steps) * 0.05)).any()
        assert np.isnan(signals.snapshot((k + steps + 1) * 0.05)).all()
        assert np.isnan(signals.read("front", (k + steps + 1) * 0.05)).all()


def test_only_the_stale_signal_is_nan() -> None:
    signals = table(Signal("a", 2, max_age=0.1), Signal("b", 1), Signal("c", 1, max_age=1.0))
    signals.update({"a": [1.0, 2.0], "b": 3.0, "c": 4.0}, 0.0)
    np.testing.assert_array_equal(signals.snapshot(0.5), [nan, nan, 3.0, 4.0])
    np.testing.assert_array_equal(signals.snapshot(2.0), [nan, nan, 3.0, nan])
    assert math.isnan(signals.value("c", 2.0))
    assert signals.value("b", 2.0) == 3.0


def test_a_repeated_old_stamp_goes_stale_however_often_it_is_written() -> None:
    signals = table(Signal("speed", max_age=0.15))
    for _ in range(10):
        signals.write("speed", 1.0, 0.0)
    assert math.isnan(signals.value("speed", 0.3))


@pytest.mark.parametrize("scalar", [False, True])
@pytest.mark.parametrize(
    ("bounds", "value", "kept"),
    [
        ((0.0, inf), inf, True),
        ((0.0, 5.0), inf, False),
        ((0.0, inf), -0.001, False),
        ((0.0, 5.0), 5.0, True),
        ((0.0, 5.0), 0.0, True),
        ((0.0, 5.0), 5.001, False),
        ((-inf, 0.0), -inf, True),
        ((-1.0, inf), -inf, False),
        ((-inf, inf), nan, False),
        ((0.0, inf), nan, False),
    ],
)
def test_only_the_value_out_of_bounds_is_nan(
    bounds: tuple[float, float], value: float, kept: bool, scalar: bool
) -> None:
    signals = table(Signal("x", 1 if scalar else 3, bounds=bounds))
    signals.write("x", value if scalar else [0.0, value, 0.0], 0.0)
    expected = value if kept else nan
    np.testing.assert_array_equal(signals.snapshot(0.0), [expected] if scalar else [0.0, expected, 0.0])
    np.testing.assert_array_equal(signals.read("x", 0.0), signals.snapshot(0.0))


@given(
    st.lists(st.floats(), min_size=1, max_size=6),
    st.tuples(st.floats(allow_nan=False), st.floats(allow_nan=False)).map(lambda b: (min(b), max(b))),
    st.floats(0.01, 10.0),
    st.floats(0.0, 20.0),
)
def test_a_read_value_is_what_was_written_or_nan(
    values: list[float], bounds: tuple[float, float], max_age: float, age: float
) -> None:
    signals = table(Signal("x", len(values), bounds=bounds, max_age=max_age))
    signals.write("x", values, 0.0)
    assume(abs(age - max_age) > 2e-6)  # nearer to the edge rounding decides
    fresh = age < max_age
    expected = [v if fresh and bounds[0] <= v <= bounds[1] else nan for v in values]
    np.testing.assert_array_equal(signals.snapshot(age), expected)
    np.testing.assert_array_equal(signals.read("x", age), expected)


def test_the_live_view_shows_the_newest_value_and_cannot_be_written() -> None:
    signals = table(Signal("front", 2), Signal("speed"))
    view = signals.view("front")
    assert np.isnan(view).all()
    for k in range(3):
        signals.write("front", [k, k + 1.0], k * 0.05)
        assert view.tolist() == [k, k + 1.0]
    with pytest.raises(ValueError, match="read-only"):
        view[0] = 1.0
    signals.write("front", [7.0, 8.0], 1.0)
    assert view.tolist() == [7.0, 8.0]


def test_a_writer_does_what_write_does() -> None:
    signals = table(Signal("front", 2, bounds=(0.0, inf)))
    writer = signals.writer("front")
    writer.write([-1.0, 2.0], 0.5)
    np.testing.assert_array_equal(signals.read("front", 0.5), [nan, 2.0])
    assert signals.stamp("front") == 0.5
    assert (signals.revision_of("front"), signals.revision) == (1, 1)


def test_several_signals_of_one_sample_are_written_whole_or_not_at_all() -> None:
    signals = table(Signal("a"), Signal("b", 2))
    with pytest.raises(KnowledgeError, match="'b' has 2 values, found 1"):
        signals.update({"a": 1.0, "b": [1.0]}, 0.0)
    assert np.isnan(signals.snapshot(0.0)).all()
    assert signals.revision == 0


@pytest.mark.parametrize(
    ("values", "t", "message"),
    [
        ([1.0], 0.0, r"'front' has 2 values, found 1 of shape \(1,\)"),
        (1.0, 0.0, r"'front' has 2 values, found 1 of shape \(\)"),
        ([[1.0, 2.0]], 0.0, r"'front' has 2 values, found 2 of shape \(1, 2\)"),
        ("near", 0.0, "'front' takes numbers, found 'near'"),
        ([1.0, object()], 0.0, "'front' takes numbers"),
        ([1.0, 2.0], nan, "'front' was written with the time nan"),
        ([1.0, 2.0], inf, "'front' was written with the time inf"),
    ],
)
def test_a_wrong_write_is_refused_and_changes_nothing(values: object, t: float, message: str) -> None:
    signals = table(Signal("front", 2))
    signals.write("front", [3.0, 4.0], 0.0)
    with pytest.raises(KnowledgeError, match=message):
        signals.write("front", values, t)
    assert signals.read("front", 0.0).tolist() == [3.0, 4.0]
    assert signals.revision == 1


@pytest.mark.parametrize("name", ["read", "value", "stamp", "spec", "slice_of", "view", "writer", "revision_of"])
def test_an_unknown_signal_is_refused_with_what_exists(name: str) -> None:
    signals = table(Signal("front", 2), Signal("rear", 2))
    arguments = ("frnt", 0.0) if name in ("read", "value") else ("frnt",)
    with pytest.raises(KnowledgeError, match=r"'frnt'. Did you mean 'front'\? .* front, rear"):
        getattr(signals, name)(*arguments)


def test_value_is_for_one_value_only() -> None:
    with pytest.raises(KnowledgeError, match=r"'front' has 2 values, not one; use read\(\)"):
        table(Signal("front", 2)).value("front", 0.0)


@pytest.mark.parametrize(
    ("signal", "message"),
    [
        (Signal("front"), "declared twice"),
        (Signal(""), "has no name"),
        (Signal("x", 0), "at least one value, found size 0"),
        (Signal("x", 3, (LENGTH, ANGLE)), "3 values but 2 dimensions"),
        (Signal("x", bounds=(1.0, 0.0)), "the lower must not exceed the upper"),
        (Signal("x", bounds=(0.0, nan)), "the lower must not exceed the upper"),
        (Signal("x", max_age=0.0), "positive max_age"),
        (Signal("x", max_age=nan), "positive max_age"),
    ],
)
def test_a_senseless_declaration_is_refused(signal: Signal, message: str) -> None:
    signals = table(Signal("front"))
    with pytest.raises(KnowledgeError, match=message):
        signals.declare(signal)
    assert signals.size == 1


def test_a_table_in_use_takes_no_more_declarations() -> None:
    signals = table(Signal("front"))
    signals.write("front", 1.0, 0.0)
    assert signals.frozen
    with pytest.raises(KnowledgeError, match="'rear' came too late"):
        signals.declare(Signal("rear"))
    signals.freeze()
    assert signals.value("front", 0.0) == 1.0


def test_an_empty_table_has_an_empty_snapshot() -> None:
    assert SignalTable().snapshot(0.0).shape == (0,)


NUMBERS = st.floats(allow_nan=True, allow_infinity=True, width=64)


@given(front=st.lists(NUMBERS, min_size=3, max_size=3), gap=st.lists(NUMBERS, min_size=2, max_size=2), pose=NUMBERS)
def test_signals_written_together_are_as_if_written_one_by_one(
    front: list[float], gap: list[float], pose: float
) -> None:
    signals = [
        Signal("front", 3, bounds=(0.0, inf)),
        Signal("gap", 2, bounds=(0.0, inf)),
        Signal("pose", bounds=(-1, 1)),
    ]
    together, alone = table(*signals), table(*signals)
    values = {"front": front, "gap": gap, "pose": [pose]}
    packed = together.update(values, 0.0)
    for name, value in values.items():
        alone.write(name, value, 0.0)
    np.testing.assert_array_equal(together.snapshot(0.0), alone.snapshot(0.0))
    bounded = all(not v < 0.0 for v in (*front, *gap)) and not abs(pose) > 1.0
    if packed is not None:
        assert bounded
        np.testing.assert_array_equal(np.frombuffer(packed), [*front, *gap, pose])
    elif bounded:  # then it was a NaN that asked for a closer look
        assert any(map(math.isnan, (*front, *gap, pose)))
