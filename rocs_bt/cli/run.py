"""`rocs-bt run`: run a scenario, with recording and report."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..catalog import Catalog, is_path
from ..errors import Fault, InputError
from ..event import Event, RulesReplaced
from .outcome import exit_code, outcome_text
from .progress import Progress
from .terminal import discard_if_closed, echo

if TYPE_CHECKING:
    from ..record.live import LivePage
    from ..simulation import RunResult

_NOTICE = "\n{signal}: ending the run and writing its report; a second signal ends it at once.\n"


@click.command()
@click.argument("scenario")
@click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Seed of the episode.")
@click.option("--out", type=click.Path(path_type=Path), help="Output folder; by default runs/SCENARIO-SEED.")
@click.option(
    "--mode",
    type=click.Choice(["lockstep", "threaded"]),
    default="lockstep",
    show_default=True,
    help="lockstep: simulated time, repeatable; threaded: wall time, a thread per block.",
)
@click.option("--for", "duration", metavar="SECONDS", type=float, help="End after this simulated time.")
@click.option("--view", is_flag=True, help="Watch in MuJoCo's viewer.")
@click.option("--video", type=click.Path(path_type=Path, dir_okay=False), help="Render a video to this file.")
@click.option("--live", "show_live", is_flag=True, help="Watch in a browser, until Ctrl-C.")
@click.option(
    "--port", type=click.IntRange(0, 65535), default=0, help="Port of the live page; by default any free port."
)
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON.")
@click.option("--btlog", is_flag=True, help="Also write AGENT.btlog for replay in Groot2.")
@click.option("--no-report", is_flag=True, help="Write no report.html.")
@click.option("--no-code", is_flag=True, help="Refuse Python content.")
@click.option(
    "--knowledge",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Load knowledge of earlier runs from this file, and add this run's.",
)
@click.option("--watch-rules", is_flag=True, help="Reload rule files that change during the run.")
def command(
    scenario: str,
    seed: int,
    out: Path | None,
    mode: str,
    duration: float | None,
    view: bool,
    video: Path | None,
    show_live: bool,
    port: int,
    as_json: bool,
    btlog: bool,
    no_report: bool,
    no_code: bool,
    knowledge: Path | None,
    watch_rules: bool,
) -> int:
    """Run SCENARIO, a name or a file, and print the outcome of each agent.

    Writes summary.json, run.mcap and report.html, also if Ctrl-C, SIGTERM or SIGHUP ends the run; a second signal ends
    it at once. Exits with 0 if every agent succeeded, 1 if one did not or a file could not be written, 2 if the input
    is invalid, 3 if the engine failed, 128 + signal if a signal ended the run.
    """
    from .._run import run
    from ..check import agent_warnings
    from ..simulation import RunOptions, StopSignals

    if duration is not None and not 0.0 < duration < float("inf"):
        raise InputError(Fault(f"--for must be positive and finite, found {duration:g} s."))
    catalog = catalog_for(scenario, code=not no_code)
    spec = catalog.load_scenario(scenario)
    for warning in agent_warnings(spec, catalog):
        echo(str(warning), err=True)
    folder, signals = out or Path("runs") / f"{spec.name}-{seed}", StopSignals(_NOTICE)
    with _live(port) if show_live else nullcontext() as live:
        with Progress(spec.name, duration or spec.duration) as progress:
            options = RunOptions(
                seed=seed,
                mode=mode,
                out=folder,
                duration=duration,
                view=view,
                video=video,
                live=live,
                report=not no_report,
                btlog=btlog,
                progress=progress,
                sinks=[_Replacements()] if watch_rules else (),
                watch_rules=watch_rules,
                knowledge=knowledge,
                signals=signals,
            )
            result = run(spec, catalog, options)
        _print(result, folder, as_json)
        if live is not None and signals.received is None:
            with suppress(KeyboardInterrupt):  # also before `wait` is entered
                echo("The live page stays open until Ctrl-C.", err=True)
                if not live.wait():
                    echo("The live page stopped responding and was closed.", err=True)
    return exit_code(result.summary, signal=signals.received, missing=bool(result.missing))


def _print(result: RunResult, folder: Path, as_json: bool) -> None:
    """Print the summary, and the files that could not be written."""
    summary = result.summary
    with discard_if_closed():
        echo(summary.to_json().rstrip() if as_json else outcome_text(summary, folder, result.report))
        for line in result.missing:
            echo(line, err=True)


@contextmanager
def _live(port: int) -> Iterator[LivePage]:
    """Open a live page and print its URL."""
    from ..record.live import LivePage

    with LivePage(port) as live:
        echo(f"Live: {live.url}", err=True)
        yield live


class _Replacements:
    """Event sink that prints the results of reloading rule files."""

    def emit(self, event: Event) -> None:
        """Print a RulesReplaced event."""
        if isinstance(event, RulesReplaced):
            echo(f"{event.t:.2f} s, {event.agent}: {event.rules}: {event.detail}", err=True)


def catalog_for(name: str, *, code: bool = True) -> Catalog:
    """Catalog of the project around a file given by path, else around the current folder."""
    return Catalog.here(Path(name).parent if is_path(name) else None, code=code)
