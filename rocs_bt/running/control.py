"""CommandDesk: applies the commands of a person to a run, between control periods."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Protocol

from msgspec.structs import replace

from ..agent import Agent, RuleWatch
from ..agent.rule_files import RuleFile
from ..clock import SLICE, Clock
from ..drivers.emergency_stop import EmergencyStop
from ..errors import InputError
from ..event import EventSink, RunControlled
from ..record import SubtreeSwap
from .command import Control, RunCommand
from .swaps import SwapSchedule

_PAUSE = "pause of the run"  # source of the holds


class Pausing(Protocol):
    """Stage of a run, as far as a pause needs it."""

    @property
    def time_stops(self) -> bool:
        """Whether the time of the run stops in a pause, as in lockstep; else only the robots stop."""
        ...

    def pause(self, by: str) -> None:
        """Begin a pause that this person or program asked for."""
        ...

    def resume(self, by: str) -> None:
        """End a pause.

        Raises:
            InputError: No command ends a pause of this stage.
        """
        ...


class SimulatedPause:
    """Pause of a simulation: in lockstep time stops, else the robots are held in neutral.

    Args:
        agents: Agents of the run.
        time_stops: Whether the run is in lockstep.
    """

    def __init__(self, agents: Sequence[Agent], *, time_stops: bool) -> None:
        self.time_stops = time_stops
        self._agents = () if time_stops else agents

    def pause(self, by: str) -> None:
        """Hold the robots."""
        for agent in self._agents:
            agent.hold(f"paused by {by}", _PAUSE)

    def resume(self, by: str) -> None:
        """Let the robots move again."""
        for agent in self._agents:
            agent.resume(_PAUSE, by)


class HardwarePause:
    """Pause of a run on hardware: the robots go to neutral and wait for a go, as after an emergency stop.

    Args:
        stops: Emergency stops of the robots.
    """

    time_stops = False

    def __init__(self, stops: Sequence[EmergencyStop]) -> None:
        self._stops = stops

    def pause(self, by: str) -> None:
        """Send all robots to neutral."""
        for stop in self._stops:
            stop.pause(by)

    def resume(self, by: str) -> None:
        """Refuse: only a person at the robots lets them move again."""
        raise InputError("robots on hardware go on only when a person presses Enter at the terminal of the run.")


class CommandDesk:
    """Applies the commands of a person to a run, and records each of them as a `RunControlled` event.

    Args:
        control: Source of the commands; None for a run without.
        swaps: Swaps of the run, which get those of the commands.
        rules: Rule files of the agents.
        clock: Clock of the run.
        sink: Sink of the events.
        stage: Stage of the run, which pauses and continues in its way.
        only_pause: Whether every other command is refused.

    Attributes:
        paused: Whether the run is paused by a command.
    """

    def __init__(
        self,
        control: Control | None,
        swaps: SwapSchedule,
        rules: RuleWatch,
        clock: Clock,
        sink: EventSink,
        stage: Pausing,
        *,
        only_pause: bool = False,
    ) -> None:
        self.paused = False
        self._control = control
        self._swaps = swaps
        self._rules = rules
        self._clock = clock
        self._sink = sink
        self._stage = stage
        self._only_pause = only_pause
        self._stepping = False

    def period(self, ended: Callable[[], str]) -> None:
        """Apply the new commands; in lockstep, wait while the run is paused.

        Args:
            ended: Returns the reason of a signal that ends the run, or an empty text.
        """
        if self._control is None:
            return
        self._stepping = False
        self._apply_all(self._control)
        while self._stage.time_stops and self.paused and not self._stepping and not ended():
            time.sleep(SLICE)
            self._apply_all(self._control)

    def _apply_all(self, control: Control) -> None:
        for command in control.take():
            event = RunControlled(
                t=self._clock.now(),
                command=command.kind,
                target=command.rules or command.node,
                source=command.mission,
                tree=command.tree,
                by=command.by,
            )
            after = None
            try:
                event, after = self._apply(command, event)
            except InputError as error:
                event = replace(event, refusal=str(error))
            self._sink.emit(event)
            if after is not None:
                after()

    def _apply(self, command: RunCommand, event: RunControlled) -> tuple[RunControlled, Callable[[], None] | None]:
        """Apply a command; returns its event, and what remains to do after the event.

        Raises:
            InputError: The command is not possible; nothing has changed.
        """
        if self._only_pause and command.kind != "pause":
            raise InputError(f"'{command.kind}' on hardware needs rocs-bt drive --control.")
        match command.kind:
            case "pause":
                self._stage.pause(command.by)
                self.paused = True
            case "continue":
                self._stage.resume(command.by)
                self.paused = False
            case "step":
                if not self._stage.time_stops:
                    raise InputError("only a run in lockstep mode goes on for one control period.")
                self.paused = self._stepping = True
            case "swap":
                node = f"{command.agent}:{command.node}" if command.agent else command.node
                swap, content = self._swaps.add(SubtreeSwap(node, command.mission, event.t, command.tree))
                event = replace(event, target=swap.node, source=swap.mission, content=content)
                return event, partial(self._swaps.step, event.t)
            case "reload":
                self._rules.request(command.rules, command.agent)
                return event, self._rules.check if self._stage.time_stops else None
        return event, None


def rule_files_of(agents: Sequence[Agent]) -> list[tuple[str, RuleFile]]:
    """Rule files of all agents, each with the name of its agent."""
    return [(agent.name, file) for agent in agents for file in agent.rule_files]
