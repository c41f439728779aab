"""`rocs-bt drive`: run a scenario on its real robots, with recording and report."""

from __future__ import annotations

import os
import select
import sys
from typing import TYPE_CHECKING, Any

import click

from ..base.errors import DeviceError
from ..devices.emergency_stop import WAITING
from ..event import ActuatorCommanded, Event, MotionHeld, MotionReleased
from .play_scenario import play_scenario, scenario_options
from .terminal import discard_if_closed, echo, show_table

if TYPE_CHECKING:
    from ..running import PreflightReport, SensorState

_PATIENCE = 1.0  # [s] before the first message about a missing sensor
_HEAD = ("sensor", "driver", "from", "rate", "age", "values", "needed for")


@click.command()
@scenario_options("hardware")
def command(scenario: str, **given: Any) -> int:
    """Run SCENARIO, a name or a file, on its real robots, and print the outcome of each agent.

    First it shows a table of the sensors. The robots stay in neutral until every sensor gives fresh values, except
    those with `optional = true` in robot.toml. Without them it ends after --wait. After an emergency stop the robot
    stays in neutral until the stop is released and a person presses Enter.

    It writes summary.json, run.mcap and report.html. A run on hardware cannot be repeated, so the default folder is
    never that of an earlier run: the second one is runs/SCENARIO-SEED_2.

    Ctrl-C, SIGTERM and SIGHUP end the run: the robots go to neutral, then the files are written. Exits with 0 if every
    agent succeeded; 1 if one did not, if a sensor or actuator cannot be reached, or if a file could not be written; 2
    if the input is invalid; 3 if the engine failed; 128 + signal if a signal ended the run.
    """
    unsent = DryRunOutput() if given["dry_run"] else None
    sinks = [HoldOutput(), *([] if unsent is None else [unsent])]
    given |= {"go": EnterKey(), "preflight": PreflightOutput(), "notice": show_notice, "sinks": sinks}
    progress = None if unsent is None else unsent.show
    if unsent is not None:
        echo("Dry run: nothing is sent to any actuator.", err=True)
    try:
        return play_scenario(scenario, unit="s on hardware", on_hardware=True, progress=progress, **given)
    except DeviceError as error:
        echo(str(error), err=True)
        return 1


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


class EnterKey:
    """Function that returns whether a line was entered since its last call; False if stdin cannot be read."""

    def __init__(self) -> None:
        try:
            self._stdin = sys.stdin.fileno()
        except (AttributeError, OSError, ValueError):  # no stdin, a stub, or closed
            self._stdin = -1

    def __call__(self) -> bool:
        """Read what was typed."""
        try:
            if self._stdin < 0 or not self._foreground or not select.select([self._stdin], [], [], 0.0)[0]:
                return False
            typed = os.read(self._stdin, 4096)
        except OSError:  # the terminal was closed; Windows can select sockets only
            typed = b""
        if not typed:
            self._stdin = -1
        return b"\n" in typed

    @property
    def _foreground(self) -> bool:
        """Whether this process may read its terminal; the system would stop a background process that reads it."""
        return not os.isatty(self._stdin) or os.tcgetpgrp(self._stdin) == os.getpgrp()
