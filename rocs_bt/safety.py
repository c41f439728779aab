"""The safety gate: the one place through which every command reaches a device.

Actions, leaves, reflexes, scripted robots and threads of users hold a `SafetyGate`, never the device. The gate refuses
what is not a command, scales what exceeds the actuator's declared limits, and goes to neutral when commands cease.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from .clock import Clock
from .device import Actuator
from .errors import ActuatorError, DeviceError, InputError, interrupts
from .event import CommandExpired, CommandLimited, EventSink, NullSink
from .raised import describe, raised_at

_ROUNDING = 1e-9  # relative; scaling by less is arithmetic, and no event


@dataclass(frozen=True)
class Limits:
    """Range and rate of change of an actuator's commands, in SI units of the command.

    Attributes:
        low: Smallest command, shape (1,) for all values alike or (n,).
        high: Largest command, same shape.
        max_change: Largest change of each value per second; +inf for no limit.
        together: Whether one factor scales all values, which keeps the curvature that wheel speeds drive; otherwise
            each value is limited by itself.

    Raises:
        InputError: A bound is not finite, `low` is not below `high`, `max_change` is not positive, or values that are
            scaled together cannot be zero.
    """

    low: tuple[float, ...]
    high: tuple[float, ...]
    max_change: float = math.inf
    together: bool = False

    def __post_init__(self) -> None:
        if len(self.low) != len(self.high) or not self.low:
            raise InputError("a range has one lower bound for each upper bound.")
        for low, high in zip(self.low, self.high, strict=True):
            if not (math.isfinite(low) and math.isfinite(high) and low < high):
                raise InputError(f"a range goes from a finite number to a larger one, found {low:g} to {high:g}.")
            if self.together and not low <= 0.0 <= high:
                raise InputError(f"the range of wheel speeds must contain 0 m/s, found {low:g} to {high:g} m/s.")
        if not self.max_change > 0.0:
            raise InputError(f"max_change must be positive, found {self.max_change:g}.")

    @property
    def largest(self) -> float:
        """Largest magnitude that every value can have in both directions; the speed limit of wheels [m/s]."""
        return min(min(-low, high) for low, high in zip(self.low, self.high, strict=True))

    def of_size(self, size: int) -> Limits:
        """The same limits with one pair of bounds for each of `size` values.

        Raises:
            InputError: Bounds are declared for another number of values.
        """
        if len(self.low) == size:
            return self
        if len(self.low) > 1:
            raise InputError(f"the range has bounds for {len(self.low)} values, but a command has {size}.")
        return Limits(self.low * size, self.high * size, self.max_change, self.together)

    def rest(self) -> list[float]:
        """The command nearest to zero, shape (n,)."""
        return [min(max(0.0, low), high) for low, high in zip(self.low, self.high, strict=True)]

    def apply(self, wanted: Sequence[float], last: Sequence[float], period: float) -> list[float]:
        """The nearest command within the limits.

        Args:
            wanted: Wanted command, shape (n,), finite.
            last: Last command given, shape (n,), within the range.
            period: Time since `last` was given [s].

        Returns:
            Command within the range and within `max_change * period` of `last`, shape (n,).
        """
        given = self._in_range(wanted)
        if self.max_change == math.inf:
            return given
        allowed, steps = self.max_change * period, [g - v for g, v in zip(given, last, strict=True)]
        if self.together:
            largest = max(map(abs, steps))
            if largest > allowed:
                steps = [s * (allowed / largest) for s in steps]
        else:
            steps = [min(max(s, -allowed), allowed) for s in steps]
        return self._clipped([v + s for v, s in zip(last, steps, strict=True)])

    def _in_range(self, values: Sequence[float]) -> list[float]:
        if self.together:
            factor = 1.0
            for v, low, high in zip(values, self.low, self.high, strict=True):
                if not low <= v <= high:
                    factor = min(factor, (high if v > 0.0 else low) / v)
            if factor < 1.0:
                values = [v * factor for v in values]
        return self._clipped(values)

    def _clipped(self, values: Sequence[float]) -> list[float]:
        return list(map(min, map(max, values, self.low), self.high))


class SafetyGate(Actuator):
    """An actuator behind its limits and its watchdog.

    The watchdog goes to neutral when no command has come for `max_age`. Whoever moves the device (the physics loop, a
    driver's own thread) calls `check`. `neutral` is exempt from the limit of change. All methods may be called from
    any thread.

    Args:
        device: The actuator's driver. Nobody else may hold it.
        clock: Source of time.
        limits: Range and rate of change of commands.
        period: Control period [s]. A command may differ from the one before it by what the rate of change allows in
            the time between them, and in one period at most.
        max_age: Longest silence before the watchdog goes to neutral [s].
        sink: Receives CommandLimited and CommandExpired.
        agent: Name of the agent, for events.

    Attributes:
        on_failure: Called once, at the first exception of the driver; None to leave it to the caller.

    Raises:
        InputError: The limits are declared for another number of values than the device takes.
    """

    def __init__(
        self,
        device: Actuator,
        clock: Clock,
        limits: Limits,
        *,
        period: float,
        max_age: float,
        sink: EventSink | None = None,
        agent: str = "",
    ) -> None:
        super().__init__(device.name, device.size)
        self.on_failure: Callable[[ActuatorError], None] | None = None
        self._device = device
        self._clock = clock
        self._limits = limits.of_size(device.size)
        self._rest = self._limits.rest()
        self._period = period
        self._max_age = max_age
        self._sink = NullSink() if sink is None else sink
        self._agent = agent
        self._lock = threading.Lock()
        self._given = self._before = self._rest  # the last command, and the last one of an earlier instant
        self._given_at = self._before_at = -math.inf  # [s]
        self._last: float | None = None  # when the watchdog was last fed [s]
        self._shut = False
        self._stops = object()  # another one after each neutral; a count would lose one of two threads' stops
        self._failed = False

    @property
    def expiry(self) -> float:
        """Time at which the watchdog goes to neutral unless a command comes before [s]; +inf while neutral."""
        last = self._last
        return math.inf if last is None else last + self._max_age

    @property
    def rest(self) -> list[float]:
        """The command that neutral counts as, shape (n,): the one nearest to zero within the range."""
        return list(self._rest)

    @property
    def active(self) -> bool:
        """Whether the last command asks for motion."""
        return self._last is not None and self._given != self._rest

    def command(self, values: Sequence[float]) -> None:
        self.give(values)

    def give(self, values: Sequence[float], action: str = "") -> list[float]:
        """Command the device, within its limits.

        Args:
            values: Wanted command, shape (n,), SI units.
            action: Name of the action that commands, for CommandLimited; empty outside of actions.

        Returns:
            The command that the device was given.

        Raises:
            InputError: Another number of values than the actuator takes, or one that is not finite. Nothing was sent.
            ActuatorError: The driver raised.
            DeviceError: The actuator was shut after a failure.
        """
        wanted = self._checked(values)
        try:
            with self._lock:
                stops = self._stops  # before the next line, so that a stop from here on is noticed after the command
                if self._shut:
                    raise DeviceError(f"actuator '{self.name}' was shut after a failure and takes no more commands.")
                now = self._clock.now()
                if expired := self._overdue(self._last, now):  # this thread came before the one that calls `check`
                    self._to_neutral()
                given = self._limited(wanted, now)
                self._run(self._device.command, given)
                self._given, self._last = given, self._clock.now()
                if self._stops is not stops:  # stopped by another thread while the command was on its way
                    self._to_neutral()
        except ActuatorError as error:
            self._report_failure(error)
            raise
        if expired:
            self._report_expiry(now)
        if given != wanted and self._exceeded(wanted, given):
            self._sink.emit(
                CommandLimited(
                    t=now,
                    agent=self._agent,
                    actuator=self.name,
                    wanted=tuple(wanted),
                    given=tuple(given),
                    action=action,
                )
            )
        return given

    def neutral(self) -> None:
        # A device may hang in `command` while it holds the lock; stopping must not wait for it. Noted first, so that
        # a command that comes out of the device after this finds that it was stopped.
        self._stops = object()
        try:
            with self._locked_soon():
                self._to_neutral()
        except ActuatorError as error:
            self._report_failure(error)
            raise

    def shut(self) -> None:
        """Go to neutral for good: later commands are refused. Works while a command hangs in the device."""
        self._shut = True
        self.neutral()

    def check(self) -> bool:
        """Go to neutral if the last command is too old; True if it did so now."""
        last, now = self._last, self._clock.now()
        if not self._overdue(last, now):
            return False
        try:
            with self._locked_soon():
                if self._last != last:  # a command, or neutral, came meanwhile
                    return False
                self._stops = object()
                self._to_neutral()
        except ActuatorError as error:
            self._report_failure(error)
            if self.on_failure is None:  # otherwise the agent was stopped; the caller moves other devices too
                raise
        self._report_expiry(now)
        return True

    def wrap(self, make: Callable[[Actuator], Actuator]) -> None:
        """Put another device behind the gate, made around the present one; tests inject faults with it."""
        with self._lock:
            self._device = make(self._device)

    def close(self) -> None:
        self._device.close()

    def _checked(self, values: Sequence[float]) -> list[float]:
        try:
            wanted = list(map(float, values))
        except (TypeError, ValueError, OverflowError) as error:
            raise InputError(f"actuator '{self.name}' takes {self.size} numbers, found {values!r:.80}.") from error
        if len(wanted) != self.size:
            raise InputError(f"actuator '{self.name}' takes {self.size} values, found {len(wanted)}: {wanted}.")
        if not all(map(math.isfinite, wanted)):
            raise InputError(f"actuator '{self.name}' takes finite values, found {wanted}.")
        return wanted

    def _overdue(self, last: float | None, now: float) -> bool:
        # Half a microsecond forgives the rounding of k * step: an age of exactly max_age still drives.
        return last is not None and now - last > self._max_age + 5e-7

    def _report_expiry(self, now: float) -> None:
        self._sink.emit(CommandExpired(t=now, agent=self._agent, actuator=self.name))

    def _run(self, step: Callable[..., None], *args: object) -> None:
        """Run a step of the driver."""
        try:
            step(*args)
        except ActuatorError:
            raise
        except BaseException as error:  # a driver may raise anything
            if interrupts(error):
                raise
            place = raised_at(error, step)
            known = isinstance(error, DeviceError) or place is None
            raise ActuatorError(str(error) if known else f"{describe(error)} ({place})") from error

    def _report_failure(self, error: ActuatorError) -> None:
        """Report the driver's first exception; the lock must have been released."""
        if self.on_failure is not None and not self._failed:
            self._failed = True
            self.on_failure(error)

    @contextmanager
    def _locked_soon(self) -> Iterator[None]:
        """The lock; without it after 20 ms, if a command hangs in the device and holds it."""
        held = self._lock.acquire(timeout=0.02)
        try:
            yield
        finally:
            if held:
                self._lock.release()

    def _limited(self, wanted: Sequence[float], now: float) -> list[float]:
        """The command to give now; the caller holds the lock."""
        if now > self._given_at:
            self._before, self._before_at, self._given_at = self._given, self._given_at, now
        return self._limits.apply(wanted, self._before, min(now - self._before_at, self._period))

    def _exceeded(self, wanted: Sequence[float], given: Sequence[float]) -> bool:
        sizes = (high - low for low, high in zip(self._limits.low, self._limits.high, strict=True))
        return any(abs(w - g) > _ROUNDING * s for w, g, s in zip(wanted, given, sizes, strict=True))

    def _to_neutral(self) -> None:
        self._run(self._device.neutral)
        self._last = None
        self._given = self._before = self._rest
