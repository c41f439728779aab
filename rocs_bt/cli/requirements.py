"""`rocs-bt requirements`: check requirements on the recording of a run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click
import msgspec

from .content import json_option, open_recording
from .terminal import echo, styled

if TYPE_CHECKING:
    from ..record import Finding

_COLOURS = {"satisfied": "green", "violated": "red", "unknown": "yellow"}


@click.command()
@click.argument("run", type=click.Path(path_type=Path))
@click.option(
    "--require", "texts", metavar="TEXT", multiple=True, help="Check this requirement instead; may be repeated."
)
@click.option("--agent", help="Name of the agent; by default all.")
@json_option("As JSON, by agent.")
def command(run: Path, texts: tuple[str, ...], agent: str | None, as_json: bool) -> int:
    """Check the requirements of RUN's scenario, or others, on its recording: verdict, minimum margin and its time.

    Exits with 0 if all are satisfied, with 1 if one is violated or unknown.
    """
    from ..base.errors import InputError, unknown
    from ..record import RequirementInfo
    from ..running import check_recorded

    recording = open_recording(run)
    names = [a.name for a in recording.header.agents]
    if agent is not None and agent not in names:
        raise InputError(unknown("agent", agent, names, "The run"))
    wanted = [r for r in recording.header.requirements if agent in (None, r.agent)]
    if texts:
        agents = names if agent is None else [agent]
        wanted = [RequirementInfo(name=text, agent=name, text=text) for text in texts for name in agents]
    if not wanted:
        raise InputError("the run's scenario has no requirement. Give one, such as --require 'always speed < 1 m/s'.")
    checked = check_recorded(recording, wanted)
    found = {name: findings for name, findings in checked.items() if findings}
    lines = [finding_line(name, finding) for name, findings in found.items() for finding in findings]
    echo(json.dumps(msgspec.to_builtins(found), indent=2) if as_json else "\n".join(lines))
    return 0 if all(f.verdict == "satisfied" for each in found.values() for f in each) else 1


def finding_line(agent: str, finding: Finding) -> str:
    """Line of text with the result of a requirement of an agent."""
    verdict = styled(finding.verdict, fg=_COLOURS[finding.verdict], bold=True)
    line = f"{agent} {verdict}: {finding.name}"
    if finding.name != finding.require:
        line += f" ({finding.require})"
    if finding.violated is not None:
        line += f", first at {finding.violated:.2f} s" + (f", when {finding.reading}" if finding.reading else "")
    if finding.margin is not None:
        line += f"; minimum margin {finding.margin:.3g}{' ' if finding.unit else ''}{finding.unit}"
        line += f" at {finding.worst:.2f} s"
    if finding.unknown:
        line += f"; unknown at {finding.unknown} of {finding.samples} samples"
    return line
