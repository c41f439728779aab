"""Output of `rocs-bt drive --dry-run`: once per second, the newest command of each actuator."""

from __future__ import annotations

from ..event import ActuatorCommanded, Event
from .terminal import discard_if_closed, echo


class DryRunOutput:
    """Event sink that keeps the newest command of each actuator, and a progress function that prints them."""

    def __init__(self) -> None:
        self._newest: dict[tuple[str, str], ActuatorCommanded] = {}
        self._printed = 0  # [s]

    def emit(self, event: Event) -> None:
        """Keep a command."""
        if isinstance(event, ActuatorCommanded):
            self._newest[event.agent, event.actuator] = event

    def show(self, t: float) -> None:
        """Print the commands if another second has passed since the start."""
        if int(t) <= self._printed:
            return
        self._printed = int(t)
        with discard_if_closed():
            for (agent, actuator), event in list(self._newest.items()):
                values = ", ".join(f"{value:.3f}" for value in event.values)
                echo(f"{self._printed} s: {agent}/{actuator} would get [{values}] ({event.route})", err=True)
