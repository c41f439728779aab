"""RunResult: summary and files of a run."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path
from urllib.parse import quote

import msgspec

from ..base.errors import Fault, RecordingError
from ..base.words import counted
from ..event import Event
from ..record import AgentResult, Recording, Summary
from ..record.fold.arrays import Table, event_table, signal_table

_COLUMNS = (
    "agent",
    "outcome",
    "reason",
    "time to goal",
    "path",
    "minimum clearance",
    "collisions",
    "reflexes",
    "resumed actions",
)


class RunResult(msgspec.Struct, frozen=True, kw_only=True):
    """Result of a run.

    Attributes:
        summary: Summary, also written as summary.json.
        recording: Path of run.mcap; None if nothing was recorded.
        report: Path of report.html; None if none was written.
        missing: One sentence for each file that could not be written, with the reason, such as a full disk.
        warnings: Warnings of the check before the run: probable mistakes, with which the scenario runs.
    """

    summary: Summary
    recording: Path | None = None
    report: Path | None = None
    missing: tuple[str, ...] = ()
    warnings: tuple[Fault, ...] = ()

    @property
    def success(self) -> bool:
        """Whether every agent succeeded."""
        return all(outcome == "success" for outcome in self.outcomes.values())

    @property
    def outcomes(self) -> dict[str, str]:
        """Outcomes by agent."""
        return {name: agent.outcome for name, agent in self.summary.agents.items()}

    def events(self, kind: str | type[Event] = "", agent: str | None = None) -> Table:
        """Events of the recording as a structured array; see `rocs_bt.record.event_table`.

        Raises:
            InputError: There is no such type of event, or no such agent.
            RecordingError: The run was not recorded.
        """
        return event_table(self._recorded(), kind, agent)

    def signals(self, agent: str, names: Sequence[str] = ()) -> Table:
        """Signals of an agent as a structured array; see `rocs_bt.record.signal_table`.

        Raises:
            InputError: There is no such agent or signal.
            RecordingError: The run was not recorded.
        """
        return signal_table(self._recorded(), agent, names)

    def __str__(self) -> str:
        summary = self.summary
        took = f"{summary.sim_time:.1f} s {'simulated' if summary.simulated else 'on hardware'}"
        lines = [f"{summary.scenario}, seed {summary.seed}, {took}"]
        for name, agent in summary.agents.items():
            reason = f": {agent.reason}" if agent.reason else ""
            collisions = "" if agent.collisions is None else f"{counted(agent.collisions, 'collision')}, "
            lines.append(
                f"{name} {agent.outcome}{reason}; {agent.path_length:.2f} m, {collisions}"
                f"{counted(agent.reflex_activations, 'reflex', 'es')}, {counted(agent.replans, 'resumed action')}"
            )
            lines += [f"  fault at {fault}" for fault in agent.faults]
        return "\n".join([*lines, *self.missing])

    def _repr_html_(self) -> str:
        """Table for notebooks: outcome and key figures of each agent, and a link to the report."""
        summary = self.summary
        head = "".join(f"<th>{name}</th>" for name in _COLUMNS)
        rows = "".join(f"<tr>{_cells(name, agent)}</tr>" for name, agent in summary.agents.items())
        caption = f"{summary.scenario}, seed {summary.seed}, {summary.sim_time:.1f} s"
        parts = [f"<table><caption>{escape(caption)}</caption><tr>{head}</tr>{rows}</table>"]
        if self.report is not None:
            parts.append(f'<p>Report: <a href="{escape(_href(self.report))}">{escape(str(self.report))}</a></p>')
        return "".join([*parts, *(f"<p>{escape(missing)}</p>" for missing in self.missing)])

    def _recorded(self) -> Recording:
        if self.recording is None:
            raise RecordingError("the run was not recorded, so it has no events. Run it with a folder: out=FOLDER.")
        return Recording.open(self.recording)


def _cells(name: str, agent: AgentResult) -> str:
    cells = (
        name,
        agent.outcome,
        agent.reason,
        _quantity(agent.time_to_goal, "s"),
        _quantity(agent.path_length, "m"),
        _quantity(agent.min_clearance, "m"),
        "–" if agent.collisions is None else agent.collisions,
        agent.reflex_activations,
        agent.replans,
    )
    return "".join(f"<td>{escape(str(cell))}</td>" for cell in cells)


def _quantity(value: float | None, unit: str) -> str:
    return "–" if value is None else f"{value:.2f} {unit}"


def _href(file: Path) -> str:
    """Link to a file: relative if its path is, since a notebook server refuses absolute ones."""
    return file.as_uri() if file.is_absolute() else quote(file.as_posix())
