"""CommandDesk: applies the commands of a person to a run, between control periods."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial

from msgspec.structs import replace

from ..agent import RuleWatch
from ..base.clock import SLICE
from ..base.errors import InputError
from ..event import EventSink, RunControlled
from ..record import SubtreeSwap
from .run_command import CommandSource, RunCommand
from .run_loop import Stage
from .swaps import SwapSchedule


def taken_commands(lockstep: bool, hardware: bool, full: bool) -> tuple[str, ...]:
    """Kinds of commands that a run takes.

    On hardware only a person at the robots lets them go on; `full` allows more than a pause.
    """
    if hardware:
        return ("pause", "swap", "reload") if full else ("pause",)
    return ("pause", "continue", *(["step"] if lockstep else []), "swap", "reload")


_REFUSALS = {
    "continue": "robots on hardware go on only when a person presses Enter at the terminal of the run.",
    "step": "only a run in lockstep mode goes on for one control period.",
}


class CommandDesk:
    """Applies the commands of a person to a run, and records each of them as a `RunControlled` event.

    Args:
        control: Source of the commands; None for a run without.
        taken: Kinds of commands that are not refused.
        swaps: Swaps of the run, which get those of the commands.
        rules: Rule files of the agents.
        sink: Sink of the events.
        stage: Stage of the run, which pauses and continues in its way.
    """

    def __init__(
        self,
        control: CommandSource | None,
        taken: Sequence[str],
        swaps: SwapSchedule,
        rules: RuleWatch,
        sink: EventSink,
        stage: Stage,
    ) -> None:
        self.paused = False
        self._control = control
        self._taken = taken
        self._swaps = swaps
        self._rules = rules
        self._sink = sink
        self._stage = stage
        self._stepping = False

    def period(self, ended: Callable[[], str]) -> None:
        """Apply the new commands; in lockstep, wait while the run is paused."""
        if self._control is None:
            return
        self._stepping = False
        self._apply_all(self._control)
        while self._stage.time_stops and self.paused and not self._stepping and not ended():
            time.sleep(SLICE)
            self._apply_all(self._control)

    def _apply_all(self, control: CommandSource) -> None:
        for command in control.take():
            event = RunControlled(
                t=self._stage.clock.now(),
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
        """Apply a command; returns its event, and what remains to do after the event. Raises InputError."""
        if command.kind not in self._taken:
            needs = f"'{command.kind}' on hardware needs rocs-bt drive --control."
            raise InputError(_REFUSALS.get(command.kind, needs))
        match command.kind:
            case "pause":
                self._stage.pause(command.by)
                self.paused = True
            case "continue":
                self._stage.resume(command.by)
                self.paused = False
            case "step":
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
