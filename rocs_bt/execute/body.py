"""RobotBody: what actions can use of the robot, with actuators that record every command."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..base.clock import Clock
from ..base.errors import DeviceError, WiringError, unknown
from ..base.geometry import Twist2, Twist3
from ..control.trail import Trail
from ..event import ActuatorCommanded, Event, EventSink, pack
from ..interfaces.device import Actuator
from ..interfaces.safety_gate import SafetyGate

if TYPE_CHECKING:
    from ..control.follower import Follower
    from ..control.locomotion import Locomotion
    from ..interfaces.message import Messenger
    from ..knowledge import Knowledge


@dataclass
class ControlPeriod:
    """State of the present control period, shared by Execute and the body's actuators."""

    route: str = "idle"  # `reactive`, `deliberative` or `idle`
    action: str = ""  # empty if none runs
    commanded: bool = False
    open: bool = True  # whether commands pass; `Execute.stop` blocks those of an action that still runs


class CommandedActuator(Actuator):
    """Actuator that actions command. Each command lasts one control period and is recorded as the device gets it."""

    def __init__(self, gate: SafetyGate, body: RobotBody) -> None:
        super().__init__(gate.name, gate.size)
        self._gate = gate
        self._body = body
        self._fresh = False
        self._active = False

    def command(self, values: Sequence[float]) -> None:
        period = self._body.control_period
        if not period.open:
            return
        # Set before the command: a device that raises may move nevertheless, and must then go to neutral.
        self._active = True
        try:
            given = self._gate.give(values, period.action)
        except DeviceError:
            if self._body.control_period.open:
                raise
            return  # the gate was shut during this command
        self._fresh = period.commanded = True
        self._record(given)

    def neutral(self) -> None:
        self._gate.neutral()
        self._active = self._fresh = False
        self._record(self._gate.rest)

    def withdraw(self) -> None:
        """Discard the command of this period, because its action failed."""
        self._fresh = False

    def settle(self) -> None:
        """End the control period: the actuator goes to neutral if it got no command in this period."""
        if self._active and not self._fresh:
            self.neutral()
        self._fresh = False

    def _record(self, values: Sequence[float]) -> None:
        self._body.note(ActuatorCommanded, actuator=self.name, route=self._body.control_period.route, data=pack(values))


class RobotBody:
    """Body of one agent's actions (`rocs_bt.interfaces.action.Body`).

    Args:
        knowledge: Knowledge of the agent.
        locomotion: Locomotion of the robot.
        follower: Trajectory follower.
        clock: Clock of the run.
        period: Control period [s].
        actuators: Safety gates of all actuators, by name.
        motion: Name of the actuator of the locomotion.
        sink: Sink for all events.

    Attributes:
        control_period: State of the present control period.
        messenger: Sender of messages to other robots; None without sharing.
        trail: Poses that the robot has passed.

    Raises:
        WiringError: There is no actuator of that name.
    """

    def __init__(
        self,
        *,
        knowledge: Knowledge,
        locomotion: Locomotion,
        follower: Follower,
        clock: Clock,
        period: float,
        actuators: Mapping[str, SafetyGate],
        motion: str,
        sink: EventSink,
    ) -> None:
        if motion not in actuators:
            raise WiringError(unknown("actuator", motion, actuators, "The robot"))
        self.agent = knowledge.agent
        self.knowledge = knowledge
        self.locomotion = locomotion
        self.follower = follower
        self.clock = clock
        self.period = period
        self.messenger: Messenger | None = None
        self.trail = Trail()
        self.control_period = ControlPeriod()
        self._sink = sink
        self.actuators: Mapping[str, CommandedActuator] = {n: CommandedActuator(a, self) for n, a in actuators.items()}
        self.motion = self.actuators[motion]

    def move(self, twist: Twist2 | Twist3) -> None:
        """Command a body twist for this period; motions that the body cannot make are ignored."""
        self.motion.command(self.locomotion.command(twist).tolist())

    def rest(self) -> None:
        """Command the body not to move in this period."""
        self.motion.command(self.locomotion.rest)

    def note(self, event: type[Event], **values: Any) -> None:
        """Emit an event of this agent with the present time.

        Args:
            event: Class of the event.
            values: Fields of the event, without `t` and `agent`.
        """
        self._sink.emit(event(t=self.clock.now(), agent=self.agent, **values))

    def neutral(self) -> None:
        """Send all actuators to neutral immediately."""
        for actuator in self.actuators.values():
            actuator.neutral()

    def withdraw(self) -> None:
        """Discard the commands of this period. Actuators that get no new command then go to neutral in `settle`."""
        self.control_period.commanded = False
        for actuator in self.actuators.values():
            actuator.withdraw()

    def settle(self) -> None:
        """End the control period: each actuator that got no command in this period goes to neutral, once."""
        for actuator in self.actuators.values():
            actuator.settle()
