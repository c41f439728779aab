"""Output of the preflight check of `rocs-bt drive`: the sensors that are missing, and a table of all sensors."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .terminal import discard_if_closed, echo, show_table

if TYPE_CHECKING:
    from ..simulation import PreflightReport, SensorState

_PATIENCE = 1.0  # [s] before the first message about a missing sensor
_HEAD = ("sensor", "driver", "from", "rate", "age", "values", "needed for")


class PreflightOutput:
    """Observer of the preflight check that prints to stderr: what it waits for, and at the end the table."""

    def __init__(self) -> None:
        self._waiting: tuple[str, ...] = ()
        self._paused = ""

    def __call__(self, report: PreflightReport) -> None:
        """Print what has changed since the last report."""
        with discard_if_closed():
            names = tuple(f"{state.agent}/{state.sensor}" for state in report.missing)
            if names != self._waiting and report.t >= _PATIENCE and not report.over:
                self._waiting = names
                for state in report.missing:
                    echo(f"waiting for {state.agent}/{state.sensor}: {state.problem}", err=True)
            if report.over:
                show_sensors(report.sensors)


def show_sensors(sensors: tuple[SensorState, ...]) -> None:
    """Print the table of sensors."""
    several = len({state.agent for state in sensors}) > 1
    rows = [_row(state, several) for state in sensors]
    shown = [i for i in range(len(_HEAD)) if i in (0, 5) or any(row[i] for row in rows)]
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


def _row(state: SensorState, several: bool) -> tuple[str, ...]:
    rate = "" if state.rate is None else f"{state.rate:.3g} of {state.declared_rate:.3g} Hz"
    age = "" if state.age is None else f"{state.age:.2f} s"
    needed = ", ".join(state.needed_for) or "the mission may read it"
    return (
        f"{state.agent}/{state.sensor}" if several else state.sensor,
        state.driver,
        state.source,
        rate,
        age,
        state.problem.partition(":")[0] or f"{state.size} fresh",
        "optional" if state.optional else needed,
    )
