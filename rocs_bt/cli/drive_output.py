"""Output of `rocs-bt drive` about the start and about holds: missing sensors, the table of sensors, prompts for go."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..drivers.emergency_stop import WAITING
from ..event import Event, MotionHeld, MotionReleased
from .terminal import discard_if_closed, echo, show_table

if TYPE_CHECKING:
    from ..running import PreflightReport, SensorState

_PATIENCE = 1.0  # [s] before the first message about a missing sensor
_HEAD = ("sensor", "driver", "from", "rate", "age", "values", "needed for")


class PreflightOutput:
    """Observer of the preflight check that prints to stderr: what it waits for, and the table of sensors."""

    def __init__(self) -> None:
        self._missing: tuple[str, ...] = ()
        self._paused = ""
        self._tabled = False

    def __call__(self, report: PreflightReport) -> None:
        """Print what has changed since the last report."""
        with discard_if_closed():
            names = tuple(f"{state.agent}/{state.sensor}" for state in report.missing)
            if names != self._missing and report.t >= _PATIENCE and not report.over:
                for name, state in zip(names, report.missing, strict=True):
                    if name not in self._missing:
                        echo(f"waiting for {name}: {state.problem}", err=True)
                self._missing, self._tabled, self._paused = names, False, ""
            if report.over or (report.paused and not report.missing and report.t >= _PATIENCE):
                if not self._tabled or report.missing:
                    show_sensors(report.sensors)
                self._tabled = True
                if not report.missing and report.paused != self._paused:
                    self._paused = report.paused
                    if report.paused:
                        echo(_prompt(report.paused), err=True)


class HoldOutput:
    """Event sink that prints why a robot is held in neutral, and when it may move again."""

    def __init__(self) -> None:
        self._reasons: dict[str, str] = {}

    def emit(self, event: Event) -> None:
        """Print a change of an agent's hold, once for all its actuators."""
        if not isinstance(event, (MotionHeld, MotionReleased)):
            return
        reason = event.reason if isinstance(event, MotionHeld) else ""
        if reason == self._reasons.get(event.agent, ""):
            return
        self._reasons[event.agent] = reason
        with discard_if_closed():
            echo(f"{event.t:.2f} s: {event.agent} {f'held: {_prompt(reason)}' if reason else 'goes on'}", err=True)


def show_notice(text: str) -> None:
    """Print a notice, such as about the clock of the run or goals that may go on."""
    with discard_if_closed():
        echo(text, err=True)


def show_sensors(sensors: tuple[SensorState, ...]) -> None:
    """Print the table of sensors."""
    several = len({state.agent for state in sensors}) > 1
    rows = [_row(state, several) for state in sensors]
    shown = [i for i in range(len(_HEAD)) if any(row[i] for row in rows)]
    styles = {i: "red" if state.blocks else "yellow" for i, state in enumerate(sensors) if state.problem}
    show_table(
        [[row[i] for i in shown] for row in rows],
        [_HEAD[i] for i in shown],
        styles=styles,
        right=[i for i, column in enumerate(shown) if column in (3, 4)],
        edge=120,
        err=True,
        box=None,
    )


def _prompt(reason: str) -> str:
    return f"{reason}; press Enter to go" if WAITING in reason else reason


def _row(state: SensorState, several: bool) -> tuple[str, ...]:
    rate = "" if state.rate is None else f"{state.rate:.3g} of {state.declared_rate:.3g} Hz"
    age = "" if state.age is None else f"{state.age:.2f} s"
    if state.ahead:
        age += f", clock {state.ahead:.2f} s ahead"
    needed = ", ".join(state.needed_for) or "the mission may read it"
    return (
        f"{state.agent}/{state.sensor}" if several else state.sensor,
        state.driver,
        state.source,
        rate,
        age,
        state.problem.partition(":")[0] or f"{state.size} {'matched' if state.matched else 'fresh'}",
        "optional" if state.optional else needed,
    )
