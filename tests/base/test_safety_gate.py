"""The safety gate: limits and watchdog of every actuator."""

import math
import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import DeviceError, InputError
from rocs_bt.event import CommandExpired, CommandLimited, LandingBegan, ListSink
from rocs_bt.interfaces.actuator_limits import ActuatorLimits
from rocs_bt.interfaces.device import Actuator
from rocs_bt.interfaces.safety_gate import Landing, SafetyGate

WHEELS = ActuatorLimits((-1.2,), (1.2,), together=True)


class Wheels(Actuator):
    """Keeps every command in `log`, neutral as zeros."""

    def __init__(self, size=2):
        super().__init__("wheels", size)
        self.log = [[0.0] * size]

    def command(self, values):
        self.log.append(list(values))

    def neutral(self):
        self.log.append([0.0] * self.size)


@pytest.fixture
def clock():
    return SimulatedClock(0.005)


def gate_of(wheels, clock, limits=WHEELS, sink=None, max_age=0.2):
    return SafetyGate(wheels, clock, limits, period=0.05, max_age=max_age, sink=sink, agent="R2")


def test_a_command_holds_for_its_age_and_not_longer(clock):
    wheels, sink = Wheels(), ListSink()
    gate = gate_of(wheels, clock, sink=sink)
    clock.advance(7)
    gate.command([1.0, 1.0])
    for _ in range(40):
        clock.advance()
        assert gate.check() is False
        assert wheels.log[-1] == [1.0, 1.0]
    clock.advance()
    assert gate.check() is True
    assert wheels.log[-1] == [0.0, 0.0]
    assert sink.events == [CommandExpired(t=clock.now(), agent="R2", actuator="wheels")]
    assert gate.check() is False, "it goes to neutral once"


def test_each_command_restarts_the_age(clock):
    gate = gate_of(Wheels(), clock)
    for _ in range(10):
        gate.command([1.0, 1.0])
        clock.advance(30)
        assert gate.check() is False


def test_after_a_silence_that_nobody_checked_commands_begin_at_neutral(clock):
    """A process that was stopped, or whose interpreter was held, may command before its watchdog is checked."""
    wheels, sink = Wheels(), ListSink()
    gate = gate_of(wheels, clock, ActuatorLimits((-1.2,), (1.2,), max_change=4.0, together=True), sink)
    for _ in range(6):
        clock.advance(10)
        gate.command([1.0, 1.0])
    assert wheels.log[-1] == [1.0, 1.0]
    sink.events.clear()
    clock.advance(500)
    gate.command([1.0, 1.0])
    assert wheels.log[-2:] == [[0.0, 0.0], [pytest.approx(0.2)] * 2]
    expired, limited = sink.events
    assert expired == CommandExpired(t=clock.now(), agent="R2", actuator="wheels")
    assert isinstance(limited, CommandLimited)
    assert gate.check() is False


def test_a_command_that_comes_while_the_watchdog_expires_is_not_stopped(clock):
    wheels, sink = Wheels(), ListSink()
    gate = gate_of(wheels, clock, sink=sink)
    gate.command([1.0, 1.0])
    clock.advance(500)
    sound = clock.now

    def now():
        clock.now = sound
        t = sound()
        gate.command([0.5, 0.5])  # as from another thread, when the watchdog has just found the silence
        return t

    clock.now = now
    assert gate.check() is False
    assert wheels.log[-2:] == [[0.0, 0.0], [0.5, 0.5]]
    assert [type(event) for event in sink.events] == [CommandExpired]


def test_a_gate_that_was_shut_refuses_commands(clock):
    wheels = Wheels()
    gate = gate_of(wheels, clock)
    gate.command([1.0, 1.0])
    gate.shut()
    assert wheels.log[-1] == [0.0, 0.0]
    with pytest.raises(DeviceError, match="'wheels' was shut"):
        gate.command([1.0, 1.0])


def test_neutral_does_not_wait_for_a_command_that_hangs(clock):
    release, entered = threading.Event(), threading.Event()

    class Hanging(Wheels):
        def command(self, values):
            super().command(values)
            entered.set()
            release.wait(10.0)

    wheels = Hanging()
    gate = gate_of(wheels, clock)
    thread = threading.Thread(target=gate.command, args=([1.0, 1.0],))
    thread.start()
    assert entered.wait(5.0)
    gate.shut()
    assert wheels.log[-1] == [0.0, 0.0]
    release.set()
    thread.join()
    assert wheels.log[-1] == [0.0, 0.0]


@pytest.mark.parametrize("reading", [1, 2])
def test_a_command_that_meets_shut_on_its_way_ends_in_neutral(reading):
    """`shut` comes after the gate was found open, when the gate reads the clock before or after it commands."""

    class Shutting(SimulatedClock):
        readings, gate = 0, None

        def now(self):
            self.readings += 1
            if self.readings == reading:  # `shut` gives up waiting for the lock, and goes to neutral without it
                thread = threading.Thread(target=self.gate.shut)
                thread.start()
                thread.join()
            return super().now()

    wheels, clock = Wheels(), Shutting(0.005)
    clock.gate = gate_of(wheels, clock)
    clock.gate.command([1.0, 1.0])
    assert wheels.log[-1] == [0.0, 0.0]


def test_a_command_that_the_driver_refuses_does_not_count_for_the_limit_of_change(clock):
    class Refusing(Wheels):
        def command(self, values):
            raise DeviceError("no")

    wheels = Wheels()
    gate = gate_of(wheels, clock, ActuatorLimits((-1.2,), (1.2,), max_change=1.0, together=True))
    gate.wrap(lambda device: Refusing())
    for _ in range(20):
        with pytest.raises(DeviceError):
            gate.command([1.0, 1.0])
        clock.advance(10)
    gate.wrap(lambda device: wheels)
    assert gate.give([1.0, 1.0]) == pytest.approx([0.05, 0.05])


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ([1.0], r"takes 2 values, found 1: \[1.0\]"),
        ([0.1, math.nan], r"takes finite values, found \[0.1, nan\]"),
        ([math.inf, 0.1], r"takes finite values, found \[inf, 0.1\]"),
        (["fast", 0.1], r"takes 2 numbers, found \['fast', 0.1\]"),
        (None, "takes 2 numbers, found None"),
        ([10**400, 0.0], "takes 2 numbers, found"),
    ],
)
def test_what_is_no_command_is_refused_and_not_sent(clock, values, message):
    wheels = Wheels()
    with pytest.raises(InputError, match=message):
        gate_of(wheels, clock).command(values)
    assert wheels.log == [[0.0, 0.0]]


def test_a_limited_command_keeps_its_curvature_and_is_an_event(clock):
    wheels, sink = Wheels(), ListSink()
    assert gate_of(wheels, clock, sink=sink).give([5.0, 2.5], "Creep") == [1.2, 0.6]
    assert wheels.log[-1] == [1.2, 0.6]
    (event,) = sink.events
    assert event == CommandLimited(
        t=0.0, agent="R2", actuator="wheels", wanted=(5.0, 2.5), given=(1.2, 0.6), action="Creep"
    )


def test_a_command_within_the_limits_passes_as_it_is(clock):
    wheels, sink = Wheels(), ListSink()
    gate_of(wheels, clock, sink=sink).command([1.2, -1.2])
    assert (wheels.log[-1], sink.events) == ([1.2, -1.2], [])


def test_values_that_are_no_wheels_are_limited_each_by_itself(clock):
    arm = Wheels()
    limits = ActuatorLimits((0.1, -2.0), (0.5, 2.0), max_change=1.0)
    gate = gate_of(arm, clock, limits)
    assert gate.give([0.9, 1.0]) == pytest.approx([0.15, 0.05])  # from the rest at (0.1, 0), in one period
    clock.advance(10)
    assert gate.give([0.15, -3.0]) == pytest.approx([0.15, 0.0])


def test_neutral_is_exempt_from_the_limit_of_change(clock):
    wheels = Wheels()
    gate = gate_of(wheels, clock, ActuatorLimits((-1.2,), (1.2,), max_change=1.0, together=True))
    for _ in range(20):
        gate.command([1.0, 1.0])
        clock.advance(10)
    assert wheels.log[-1] == pytest.approx([1.0, 1.0])
    gate.neutral()
    assert wheels.log[-1] == [0.0, 0.0]
    assert gate.give([1.0, 1.0]) == pytest.approx([0.05, 0.05])  # and the next command starts from rest


@pytest.mark.parametrize(
    ("low", "high", "more", "message"),
    [
        ((1.0,), (-1.0,), {}, "from a finite number to a larger one, found 1 to -1"),
        ((-math.inf,), (1.0,), {}, "found -inf to 1"),
        ((math.nan,), (1.0,), {}, "found nan to 1"),
        ((-1.0,), (1.0, 2.0), {}, "one lower bound for each upper bound"),
        ((0.5,), (1.0,), {"together": True}, "must contain 0 m/s"),
        ((-1.0,), (1.0,), {"max_change": 0.0}, "max_change must be positive, found 0"),
        ((-1.0,), (1.0,), {"max_change": math.nan}, "max_change must be positive, found nan"),
    ],
)
def test_limits_that_mean_nothing_are_refused(low, high, more, message):
    with pytest.raises(InputError, match=message):
        ActuatorLimits(low, high, **more)


def test_bounds_for_another_number_of_values_are_refused(clock):
    with pytest.raises(InputError, match="bounds for 3 values, but a command has 2"):
        gate_of(Wheels(), clock, ActuatorLimits((-1.0,) * 3, (1.0,) * 3))


VALUES = st.floats(-1e12, 1e12, allow_nan=False)
STEPS = st.lists(
    st.one_of(
        st.tuples(st.just("command"), st.tuples(VALUES, VALUES)),
        st.tuples(st.just("neutral"), st.none()),
        st.tuples(st.just("wait"), st.integers(1, 60)),
    ),
    max_size=40,
)


@given(
    STEPS, st.floats(0.1, 3.0), st.floats(0.1, 3.0), st.one_of(st.just(math.inf), st.floats(0.1, 50.0)), st.booleans()
)
def test_no_sequence_of_commands_gets_a_value_past_the_gate(steps, low, high, change, together):
    clock, wheels = SimulatedClock(0.005), Wheels()
    gate = gate_of(wheels, clock, ActuatorLimits((-low,), (high,), change, together))
    last, at, before, before_at = [0.0, 0.0], -math.inf, [0.0, 0.0], -math.inf
    for kind, argument in steps:
        if kind == "wait":
            clock.advance(argument)
            continue
        if kind == "neutral":
            gate.neutral()
            last = before = [0.0, 0.0]
            continue
        now = clock.now()
        if now > gate.expiry + 5e-7:  # nobody calls `check` here: the command finds the silence
            last = before = [0.0, 0.0]
        given = gate.give(argument)
        assert wheels.log[-1] == given
        assert all(-low <= v <= high for v in given)
        if now > at:
            before, before_at, at = last, at, now
        last = given
        allowed = change * min(now - before_at, 0.05) * (1.0 + 1e-9) + 1e-12
        assert all(abs(v - w) <= allowed for v, w in zip(given, before, strict=True))


@given(st.tuples(VALUES, VALUES), st.floats(0.1, 3.0))
def test_one_factor_scales_wheels_into_their_range(wanted, limit):
    given = ActuatorLimits((-limit,) * 2, (limit,) * 2, together=True).apply(wanted, (0.0, 0.0), 0.05)
    largest = max(map(abs, wanted))
    factor = min(1.0, limit / largest) if largest > 0.0 else 1.0
    assert given == pytest.approx([v * factor for v in wanted], rel=1e-9, abs=1e-300)


@given(st.tuples(VALUES, VALUES), st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)), st.floats(0.1, 50.0))
def test_one_factor_scales_a_change_of_wheel_speeds(wanted, last, change):
    given = ActuatorLimits((-1.0,) * 2, (1.0,) * 2, change, together=True).apply(wanted, last, 0.05)
    reached = ActuatorLimits((-1.0,) * 2, (1.0,) * 2, together=True).apply(wanted, last, 0.05)
    steps, full = ([v - w for v, w in zip(values, last, strict=True)] for values in (given, reached))
    assert steps[0] * full[1] == pytest.approx(steps[1] * full[0], abs=1e-9)


DOWN = (0.0, 0.0, -0.3, 0.0)


def lander(clock, sink=None):
    body = Wheels(4)
    limits = ActuatorLimits((-1.0,) * 4, (1.0,) * 4, together=True)
    landing = Landing(5.0, DOWN)
    return body, SafetyGate(body, clock, limits, period=0.05, max_age=0.2, sink=sink, agent="R4", landing=landing)


def passes(clock, gate, seconds, command=None):
    """Time passes: commands at 20 Hz, and the checks of the physics, only when the gate says that one is due."""
    for _ in range(round(seconds / 0.05)):
        if command is not None:
            gate.command(command)
        for _ in range(10):
            clock.advance()
            if clock.now() > gate.expiry:
                gate.check()


@pytest.mark.parametrize("rests", [None, [0.0] * 4], ids=["without commands", "with commands to rest"])
def test_a_flying_body_that_is_not_commanded_to_move_hovers_then_lands(clock, rests):
    sink = ListSink()
    body, gate = lander(clock, sink)
    passes(clock, gate, 1.0, rests)
    assert set(map(tuple, body.log)) == {(0.0,) * 4}, "on the ground it does not land"
    passes(clock, gate, 1.0, [0.0, 0.0, 0.5, 0.0])
    passes(clock, gate, 4.7, rests)
    assert tuple(body.log[-1]) == (0.0,) * 4
    begun = clock.now()
    passes(clock, gate, 1.0, rests)
    assert tuple(body.log[-1]) == DOWN
    (landed,) = [e for e in sink.events if isinstance(e, LandingBegan)]
    assert begun < landed.t < begun + 0.6


def test_neutral_does_not_stop_a_descent_and_a_command_to_move_does(clock):
    body, gate = lander(clock)
    passes(clock, gate, 0.5, [0.1, 0.0, 0.0, 0.0])
    passes(clock, gate, 6.0)
    for stop in (gate.neutral, lambda: passes(clock, gate, 1.0)):
        stop()
        assert tuple(body.log[-1]) == DOWN
    gate.command([0.0, 0.2, 0.0, 0.0])
    assert body.log[-1] == [0.0, 0.2, 0.0, 0.0]
    passes(clock, gate, 4.0, [0.0] * 4)
    assert body.log[-1] == [0.0] * 4, "the time counts anew"


def test_a_shut_gate_still_lands(clock):
    body, gate = lander(clock)
    passes(clock, gate, 0.5, [0.1, 0.0, 0.0, 0.0])
    gate.shut()
    passes(clock, gate, 6.0)
    assert tuple(body.log[-1]) == DOWN


def test_the_descent_is_repeated_for_controllers_with_a_time_limit(clock):
    body, gate = lander(clock)
    passes(clock, gate, 0.5, [0.1, 0.0, 0.0, 0.0])
    passes(clock, gate, 6.0)
    before = len(body.log)
    passes(clock, gate, 1.0)
    assert 15 <= len(body.log) - before <= 25
    assert set(map(tuple, body.log[before:])) == {DOWN}


def test_a_command_that_comes_just_before_the_landing_is_kept(clock):
    body, gate = lander(clock)
    passes(clock, gate, 0.5, [0.1, 0.0, 0.0, 0.0])
    passes(clock, gate, 4.9)
    while clock.now() <= gate.expiry:
        clock.advance()
    clock_now, gate._locked_soon, locked = clock.now(), None, gate._locked_soon
    assert clock_now > 5.0

    def late():  # the other thread gets the lock first
        gate._locked_soon = locked
        gate.command([0.5, 0.0, 0.0, 0.0])
        return locked()

    gate._locked_soon = late
    gate.check()
    assert body.log[-1] == [0.5, 0.0, 0.0, 0.0]
    passes(clock, gate, 1.0)
    assert body.log[-1] == [0.0] * 4, "it hovers"


def test_a_twist_changes_by_the_limit_of_each_axis_and_the_climb_by_itself(clock):
    body = Wheels(4)
    limits = ActuatorLimits((-5.0, -5.0, -1.0, -1.0), (5.0, 5.0, 1.0, 1.0), (1.0, 1.0, 0.5, 2.0), True, (2,))
    gate = SafetyGate(body, clock, limits, period=0.1, max_age=0.3)
    gate.command([0.0, 0.0, 1.0, 4.0])
    clock.advance(20)
    gate.command([0.0, 0.0, 1.0, 4.0])
    assert body.log[-1] == pytest.approx([0.0, 0.0, 0.1, 0.4]), "a large turn does not take the climb"
    gate.neutral()
    assert body.log[-1] == [0.0] * 4
    with pytest.raises(InputError, match="one rate for each of 2 values"):
        ActuatorLimits((-1.0, -1.0), (1.0, 1.0), (1.0,))
