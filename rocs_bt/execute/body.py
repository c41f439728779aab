"""RobotBody: what actions may use, with actuators that record every command."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..clock import Clock
from ..device import Actuator
from ..errors import DeviceError, WiringError, unknown
from ..event import ActuatorCommanded, Event, EventSink, pack
from ..safety import SafetyGate

if TYPE_CHECKING:
    from ..control.drive import Drive
    from ..control.follower import Follower
    from ..knowledge import Knowledge
    from ..knowledge.share import Messenger


@dataclass
class Turn:
    """What Execute and the body's actuators share about the present control period.

    Attributes:
        route: `reactive`, `deliberative` or `idle`.
        action: Name of the atomic action that acts now; empty while none does.
        commanded: Whether the action that acts now has commanded any actuator.
        open: Whether commands pass; Execute.stop shuts the gate for an action that is in mid-act.
    """

    route: str = "idle"
    action: str = ""
    commanded: bool = False
    open: bool = True


class CommandedActuator(Actuator):
    """An actuator as actions see it: records what the gate gives the device, keeps no command beyond its period.

    Args:
        gate: The actuator behind its limits.
        body: The body that it belongs to.
    """

    def __init__(self, gate: SafetyGate, body: RobotBody) -> None:
        super().__init__(gate.name, gate.size)
        self._gate = gate
        self._body = body
        self._fresh = False
        self._active = False

    def command(self, values: Sequence[float]) -> None:
        turn = self._body.turn
        if not turn.open:
            return
        # Before the device is asked: one that refuses half-way may move all the same, and must then go to neutral.
        self._active = True
        try:
            given = self._gate.give(values, turn.action)
        except DeviceError:
            if self._body.turn.open:
                raise
            return  # it was shut for good while this command was on its way
        self._fresh = turn.commanded = True
        self._record(given)

    def neutral(self) -> None:
        self._gate.neutral()
        self._active = self._fresh = False
        self._record(self._gate.rest)

    def withdraw(self) -> None:
        """Forget that it was commanded in this period: whoever did so has failed."""
        self._fresh = False

    def settle(self) -> None:
        """The period is over: nothing keeps its last command."""
        if self._active and not self._fresh:
            self.neutral()
        self._fresh = False

    def _record(self, values: Sequence[float]) -> None:
        self._body.note(ActuatorCommanded, actuator=self.name, route=self._body.turn.route, data=pack(values))


class RobotBody:
    """The `Body` of one agent's actions.

    Args:
        knowledge: All that the robot knows.
        drive: Kinematics of the wheels.
        follower: The trajectory follower.
        clock: Time.
        period: The control period [s].
        actuators: All actuators behind their limits, by name.
        wheels: The name of the one that takes wheel rim speeds.
        sink: Where events go.

    Attributes:
        messenger: Sends messages to other robots; None where the robot shares nothing.

    Raises:
        WiringError: No actuator has the name that `wheels` gives.
    """

    def __init__(
        self,
        *,
        knowledge: Knowledge,
        drive: Drive,
        follower: Follower,
        clock: Clock,
        period: float,
        actuators: Mapping[str, SafetyGate],
        wheels: str,
        sink: EventSink,
    ) -> None:
        if wheels not in actuators:
            raise WiringError(unknown("actuator", wheels, actuators, "The robot"))
        self.agent = knowledge.agent
        self.knowledge = knowledge
        self.drive = drive
        self.follower = follower
        self.clock = clock
        self.period = period
        self.messenger: Messenger | None = None
        self.turn = Turn()
        self._sink = sink
        self.actuators: Mapping[str, CommandedActuator] = {n: CommandedActuator(a, self) for n, a in actuators.items()}
        self.wheels = self.actuators[wheels]

    def note(self, event: type[Event], **values: Any) -> None:
        """Emit an event of this agent, now."""
        self._sink.emit(event(t=self.clock.now(), agent=self.agent, **values))

    def neutral(self) -> None:
        """Let all actuators stop acting, at once."""
        for actuator in self.actuators.values():
            actuator.neutral()

    def withdraw(self) -> None:
        """What was commanded in this period does not count: unless another action commands, it ends at `settle`."""
        self.turn.commanded = False
        for actuator in self.actuators.values():
            actuator.withdraw()

    def settle(self) -> None:
        """End the period: each actuator that nobody commanded in it goes to neutral, once."""
        for actuator in self.actuators.values():
            actuator.settle()
