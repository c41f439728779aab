"""Safety gate: limits and watchdog through which every command to an actuator passes.

Actions, leaves, reflexes, scripted robots and users' threads have access only to a `SafetyGate`, never to the device.
The gate refuses invalid commands, reduces commands to the actuator's declared limits, and sends the device to neutral
when no new commands arrive.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from ..base.clock import Clock
from ..base.errors import ActuatorError, DeviceError, InputError, interrupts
from ..base.raised import describe, raised_at
from ..event import (
    CommandExpired,
    CommandLimited,
    EventSink,
    LandingBegan,
    MotionHeld,
    MotionReleased,
    NullSink,
)
from .actuator_limits import ActuatorLimits
from .device import Actuator

_ROUNDING = 1e-9  # relative to the range; smaller differences are rounding errors, which emit no event


@dataclass(frozen=True)
class Landing:
    """Landing of a flying body that is not commanded to move.

    Attributes:
        after: Time at rest after which it lands [s]; +inf for never.
        command: Command of the descent, shape (n,), as for the device.
    """

    after: float
    command: tuple[float, ...]


class SafetyGate(Actuator):
    """Wrapper of an actuator that adds limits and a watchdog; all methods are thread-safe.

    The watchdog sends the device to neutral if there was no command for `max_age`. For this, the loop that moves the
    device (the physics, or a driver's own thread) must call `check`. The limit on the rate of change does not apply to
    `neutral`.

    The lock is held while the driver takes a command, which may hang. What stops the device therefore waits for it only
    briefly, and leaves a mark (`_stops`, `_holds`) before; the thread in the driver finds the mark when it returns, and
    goes to neutral. Events and `on_failure` come after the lock is released, because their handlers stop the robot.

    With a `landing`, a body that has moved and then rests, in neutral or by commands not to move, lands after the time
    of the landing: it descends until it is commanded to move.

    Args:
        device: Driver of the actuator; no other object may use it.
        clock: Clock of the run.
        limits: Limits of the commands.
        period: Control period [s]. The allowed change of a command is `max_change` times the time since the previous
            command, but at most one period.
        max_age: Maximum time between commands before the watchdog goes to neutral [s].
        sink: Sink that receives the gate's events, such as CommandLimited; None to emit none.
        agent: Name of the agent, for events.
        landing: Landing of a flying body; None for other devices.

    Attributes:
        max_age: Maximum time between commands [s].
        on_failure: Handler that is called once, at the first exception of the driver; None to leave it to the caller.

    Raises:
        InputError: The limits are declared for another number of values than the device takes.
    """

    def __init__(
        self,
        device: Actuator,
        clock: Clock,
        limits: ActuatorLimits,
        *,
        period: float,
        max_age: float,
        sink: EventSink | None = None,
        agent: str = "",
        landing: Landing | None = None,
    ) -> None:
        super().__init__(device.name, device.size)
        self.on_failure: Callable[[ActuatorError], None] | None = None
        self._device = device
        self._clock = clock
        self._limits = limits.of_size(device.size)
        self._rest = self._limits.rest()
        self._period = period
        self.max_age = max_age
        self._sink = NullSink() if sink is None else sink
        self._agent = agent
        self._lock = threading.Lock()
        self._given = self._before = self._rest  # last command, and last command of an earlier time
        self._given_at = self._before_at = -math.inf  # [s]
        self._last: float | None = None  # [s] time of the last command; None while neutral
        self._landing = landing
        self._resting_since = math.inf  # [s] time since which a body that has moved rests
        self._lands = False
        self._descent_sent = -math.inf  # [s]
        self._shut = False
        self._holds: dict[str, str] = {}  # reasons by source; replaced, never changed
        self._stops = object()  # replaced by each neutral; a counter could lose one of two concurrent stops
        self._failed = False

    @property
    def expiry(self) -> float:
        """Time at which `check` will send the device to neutral, or to land, without a new command [s]; else +inf."""
        last = self._last
        neutral = math.inf if last is None else last + self.max_age
        return min(neutral, self._landing_at)

    @property
    def rest(self) -> list[float]:
        """Command as which `neutral` is recorded, shape (n,): the one nearest to zero within the range."""
        return list(self._rest)

    @property
    def active(self) -> bool:
        """Whether the last command requested motion and is still in effect."""
        return self._last is not None and self._given != self._rest

    @property
    def held(self) -> str:
        """Reasons for which the device is held in neutral; empty if commands pass."""
        return "; ".join(dict.fromkeys(self._holds.values()))

    def command(self, values: Sequence[float]) -> None:
        self.give(values)

    def give(self, values: Sequence[float], action: str = "") -> list[float]:
        """Command the device, after reducing the command to the limits.

        Args:
            values: Requested command, shape (n,), SI units.
            action: Name of the commanding action, for CommandLimited; empty outside of actions.

        Returns:
            Command sent to the device, shape (n,).

        Raises:
            InputError: The number of values is wrong, or a value is not finite; nothing was sent.
            ActuatorError: The driver raised an exception.
            DeviceError: The actuator was shut after a failure.
        """
        wanted = self._checked(values)
        try:
            with self._lock:
                stops = self._stops  # read first, so that any later stop is detected after the command
                if self._shut:
                    raise DeviceError(f"actuator '{self.name}' was shut after a failure and takes no more commands.")
                now = self._clock.now()
                if self._holds:
                    self._to_neutral()  # again, as the device may have missed the first
                    return self.rest
                if expired := self._overdue(self._last, now):  # the watchdog's `check` has not run yet
                    self._to_neutral()
                given = self._limited(wanted, now)
                self._run(self._device.command, given if self._landing is None else self._landed(given, now))
                self._given, self._last = given, self._clock.now()
                if self._stops is not stops:  # stopped by another thread during the command
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
        # A device may hang in `command` while it holds the lock; stopping must not wait for it. The mark is set first,
        # so that a command that returns later detects the stop.
        self._stops = object()
        try:
            with self._locked_soon():
                self._to_neutral()
        except ActuatorError as error:
            self._report_failure(error)
            raise

    def hold(self, reason: str, source: str = "") -> None:
        """Send the device to neutral, and answer every command by neutral until `release`.

        Args:
            reason: Reason of the hold, not empty. It replaces the previous one of the source.
            source: Name of the part that holds the device; commands pass again when every source has released it.
        """
        if self.mark_held(reason, source):
            self.begin_hold()

    def mark_held(self, reason: str, source: str = "") -> bool:
        """Answer every command by neutral until `release`, without a command to the device: first part of `hold`.

        Args:
            reason: Reason of the hold, not empty.
            source: Name of the part that holds the device.

        Returns:
            Whether the reason is new, so that `begin_hold` is due.
        """
        changed = reason != self._holds.get(source)
        self._holds = {**self._holds, source: reason}
        return changed

    def begin_hold(self) -> None:
        """Send the device to neutral, after `mark_held`: a command that is sent at the same time detects the stop."""
        try:
            self.neutral()
        except ActuatorError:
            if self.on_failure is None:  # otherwise the agent is stopped
                raise
        self._report_hold()

    def release(self, by: str = "", source: str = "") -> None:
        """Pass commands again after `hold`, unless another source holds the device.

        Args:
            by: Name of the person or device that releases it, for the event.
            source: Name of the part that held the device.
        """
        if source not in self._holds:
            return
        self._holds = {name: reason for name, reason in self._holds.items() if name != source}
        if self._holds:
            self._report_hold()
        else:
            self._sink.emit(MotionReleased(t=self._clock.now(), agent=self._agent, actuator=self.name, by=by))

    def shut(self) -> None:
        """Send the device to neutral and refuse all later commands; works even while a command hangs in the driver."""
        self._shut = True
        self.neutral()

    def check(self) -> bool:
        """Watchdog: send the device to neutral if the last command is too old; returns whether this call did so.

        It also begins the landing of a flying body that has rested long enough.
        """
        last, now = self._last, self._clock.now()
        if not self._overdue(last, now):
            if self._landing is not None and now >= self._landing_at - 5e-7:
                self._land(self._landing, now)
            return False
        try:
            with self._locked_soon():
                if self._last != last:  # another thread called `give` or `neutral`
                    return False
                self._stops = object()
                self._to_neutral()
        except ActuatorError as error:
            self._report_failure(error)
            if self.on_failure is None:  # otherwise the agent is stopped, and the caller continues with other devices
                raise
        self._report_expiry(now)
        return True

    def wrap(self, make: Callable[[Actuator], Actuator]) -> None:
        """Replace the device by a wrapper around it, for fault injection in tests."""
        with self._lock:
            self._device = make(self._device)

    def run(self, function: Callable[..., None], *args: object) -> None:
        """Call a function of the driver outside of commands, such as its inner loop, without the gate's lock.

        Args:
            function: Function of the driver.
            args: Arguments of the function.

        Raises:
            ActuatorError: The function raised an exception, and there is no `on_failure`.
        """
        try:
            self._run(function, *args)
        except ActuatorError as error:
            self._report_failure(error)
            if self.on_failure is None:
                raise

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
        # Tolerance of 0.5 us for the rounding of k * step: a command of age max_age is still valid.
        return last is not None and now - last > self.max_age + 5e-7

    def _report_hold(self) -> None:
        self._sink.emit(MotionHeld(t=self._clock.now(), agent=self._agent, actuator=self.name, reason=self.held))

    def _report_expiry(self, now: float) -> None:
        self._sink.emit(CommandExpired(t=now, agent=self._agent, actuator=self.name))

    def _run(self, step: Callable[..., None], *args: object) -> None:
        """Call a method of the driver and convert its exceptions to ActuatorErrors."""
        try:
            step(*args)
        except ActuatorError:
            raise
        except BaseException as error:  # a driver may raise anything
            if interrupts(error):
                raise
            location = raised_at(error, step)
            known = isinstance(error, DeviceError) or location is None
            raise ActuatorError(str(error) if known else f"{describe(error)} ({location})") from error

    def _report_failure(self, error: ActuatorError) -> None:
        """Report the first exception of the driver to `on_failure`; the caller must not hold the lock."""
        if self.on_failure is not None and not self._failed:
            self._failed = True
            self.on_failure(error)

    @contextmanager
    def _locked_soon(self) -> Iterator[None]:
        """Context that holds the lock, or proceeds without it after 20 ms, as a command may hang in the driver."""
        held = self._lock.acquire(timeout=0.02)
        try:
            yield
        finally:
            if held:
                self._lock.release()

    def _limited(self, wanted: Sequence[float], now: float) -> list[float]:
        """Reduce a command to the limits at the present time; the caller holds the lock."""
        # Commands of one instant start from the command before it, not from each other: one allowance for all of them.
        if now > self._given_at:
            self._before, self._before_at, self._given_at = self._given, self._given_at, now
        return self._limits.apply(wanted, self._before, min(now - self._before_at, self._period))

    def _exceeded(self, wanted: Sequence[float], given: Sequence[float]) -> bool:
        sizes = (high - low for low, high in zip(self._limits.low, self._limits.high, strict=True))
        return any(abs(w - g) > _ROUNDING * s for w, g, s in zip(wanted, given, sizes, strict=True))

    def _to_neutral(self) -> None:
        if self._landing is None or not self._lands:
            self._run(self._device.neutral)
        else:  # neutral would stop the descent
            self._run(self._device.command, list(self._landing.command))
        if self._given != self._rest:
            self._resting_since = self._clock.now()
        self._last = None
        self._given = self._before = self._rest

    @property
    def _landing_at(self) -> float:
        """Time at which `check` commands the descent, first or again [s]; +inf for a body that does not rest."""
        if self._landing is None:
            return math.inf
        # Repeated, because a robot's own controller may stop the descent without new commands.
        return self._descent_sent + self._period if self._lands else self._resting_since + self._landing.after

    def _landed(self, given: list[float], now: float) -> list[float]:
        """Command for the device of a body that can land: the descent while it lands and is not commanded to move."""
        if given != self._rest:
            self._resting_since, self._lands = math.inf, False
        elif self._given != self._rest:
            self._resting_since = now
        return list(self._landing.command) if self._landing is not None and self._lands else given

    def _land(self, landing: Landing, now: float) -> None:
        """Command the descent of a body that has rested long enough, or again while it lands."""
        try:
            with self._locked_soon():
                if now < self._landing_at - 5e-7:  # another thread commanded a motion
                    return
                begins, self._lands, self._descent_sent = not self._lands, True, now
                self._run(self._device.command, list(landing.command))
        except ActuatorError as error:
            self._report_failure(error)
            if self.on_failure is None:
                raise
            return
        if begins:
            self._sink.emit(LandingBegan(t=now, agent=self._agent, actuator=self.name))
