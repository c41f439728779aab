"""`rocs-bt knowledge why`: why an agent acted by the strategies that it chose, and what came of them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .knowledge_files import agent_option, at_option, open_log, run_argument, run_number_option
from .terminal import echo

if TYPE_CHECKING:
    from ..knowledge import Readable


@click.command()
@run_argument
@agent_option
@run_number_option
@at_option
def why(run: Path, agent: str | None, run_number: int | None, t: float | None) -> None:
    """Tell why an agent chose its strategies in RUN, and what came of each; with --at of the one in force then.

    RUN is a run's folder, its run.mcap, a file that `run --knowledge` wrote, or an export.
    """
    log = open_log(run, agent, run_number)
    state = log.as_of()
    uses = sorted(state.nodes("use"), key=lambda use: state.get(use, "began") or 0.0)
    if t is not None:
        uses = [use for use in uses if _in_force(state, use, t)]
    if not uses:
        when = "" if t is None else f" at {t:g} s"
        hint = "Missions choose strategies with UseStrategy (docs/strategies.md)."
        echo(f"No strategy of {log.agent} was in force{when}. {hint}")
        return
    for use in uses:
        echo("\n".join(_told(state, use)))


def _in_force(state: Readable, use: str, t: float) -> bool:
    ended = state.get(use, "ended")
    return bool((state.get(use, "began") or 0.0) <= t and (ended is None or t <= ended))


def _told(state: Readable, use: str) -> Iterator[str]:
    known = state.attributes(use)
    names = ", ".join(state.related(use, "use_of")) or "a strategy that is forgotten"
    until = f"{known['ended']:.2f} s" if "ended" in known else "the end"
    came = known.get("outcome", "still in force") + (f": {known['reason']}" if "reason" in known else "")
    yield f"{known.get('began', 0.0):.2f} s to {until}  {names}  {came}"
    yield from (f"    {line}" for line in known.get("why", "nothing was noted").splitlines())
