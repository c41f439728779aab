"""Parts that `rocs-bt run` and `rocs-bt drive` share: options, live page, progress bar and printed outcome."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..catalog import CachingCatalog, Catalog
from ..errors import Fault, InputError
from ..event import Event, EventSink, RulesReplaced
from .content import catalog_for, no_code_option
from .outcome import exit_code, outcome_text
from .progress import Progress
from .terminal import discard_if_closed, echo, show_warnings

if TYPE_CHECKING:
    from ..running import RunOptions, RunResult

Play = Callable[[str, "Catalog", "RunOptions"], "RunResult"]
"""Function that runs a scenario: `rocs_bt.run` or `rocs_bt.drive`."""

_NOTICE = "\n{signal}: ending the run and writing its report; a second signal ends it at once.\n"

_FIRST = (
    click.argument("scenario"),
    click.option("--out", type=click.Path(path_type=Path), help="Output folder; by default runs/SCENARIO-SEED."),
)
_LAST = (
    click.option("--live", "show_live", is_flag=True, help="Watch in a browser, until Ctrl-C."),
    click.option(
        "--port", type=click.IntRange(0, 65535), default=0, help="Port of the live page; by default any free port."
    ),
    click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON."),
    click.option("--btlog", is_flag=True, help="Also write AGENT.btlog for replay in Groot2."),
    click.option("--no-report", is_flag=True, help="Write no report.html."),
    no_code_option,
    click.option(
        "--knowledge",
        type=click.Path(path_type=Path, dir_okay=False),
        metavar="FILE",
        help="Load knowledge of earlier runs from this file, and add this run's.",
    ),
    click.option("--watch-rules", is_flag=True, help="Reload rule files that change during the run."),
)


def scenario_options(*own: Callable[..., Any]) -> Callable[..., Any]:
    """Decorator that adds the argument SCENARIO, the command's own options, and the shared options to a command."""

    def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
        for option in reversed((*_FIRST, *own, *_LAST)):
            function = option(function)
        return function

    return decorate


@dataclass(frozen=True, kw_only=True)
class SharedOptions:
    """Values of the shared options, and of the argument SCENARIO.

    Attributes:
        scenario: Name or file of the scenario.
        seed: Seed of the run.
        out: Output folder; None for the default.
        duration: Maximum duration [s]; None for that of the scenario.
        show_live: Whether to show the live page.
        port: Port of the live page; 0 for any free port.
        as_json: Whether to print the summary as JSON.
        btlog: Whether to write logs of trees.
        no_report: Whether to write no report.
        no_code: Whether to refuse Python content.
        knowledge: File of knowledge of earlier runs.
        watch_rules: Whether to reload rule files that change.
    """

    scenario: str
    seed: int
    out: Path | None
    duration: float | None
    show_live: bool
    port: int
    as_json: bool
    btlog: bool
    no_report: bool
    no_code: bool
    knowledge: Path | None
    watch_rules: bool


def play_scenario(
    play: Play,
    shared: SharedOptions,
    changes: dict[str, Any],
    *,
    unit: str,
    keep: bool = False,
    sinks: Sequence[EventSink] = (),
    progress: Callable[[float], None] | None = None,
) -> int:
    """Run a scenario, print its outcome, and return the exit code.

    Args:
        play: Function that runs the scenario.
        shared: Values of the shared options.
        changes: Options of the run that only this command has, by attribute of `RunOptions`.
        unit: Unit of the progress bar.
        keep: Whether the default output folder gets a number where an earlier run has a recording.
        sinks: Sinks for all events.
        progress: Function that is called once per control period, with the time [s].
    """
    from ..check import check_scenario, mission_notes
    from ..running import RunOptions, StopSignals

    scenario, seed, duration = shared.scenario, shared.seed, shared.duration
    if duration is not None and not 0.0 < duration < float("inf"):
        raise InputError(Fault(f"--for must be positive and finite, found {duration:g} s."))
    project = catalog_for(scenario, no_code=shared.no_code)
    catalog = CachingCatalog(project.project, code=project.code)  # the check and the run read each file once
    findings = check_scenario(scenario, catalog)
    findings.refuse()
    spec, warnings = catalog.load_scenario(scenario), findings.warnings
    notes = [note for agent in spec.agents for note in mission_notes(agent, catalog)]
    for note in dict.fromkeys(notes):
        echo(str(note), err=True)
    show_warnings(warnings, f"rocs-bt check {scenario}")
    folder, signals = shared.out or _default_folder(f"{spec.name}-{seed}", keep), StopSignals(_NOTICE)
    with _live(shared.port) if shared.show_live else nullcontext() as live:
        with Progress(spec.name, duration or spec.duration, unit) as shown:

            def show(t: float) -> None:
                if progress is not None:
                    progress(t)
                shown(t)

            options = RunOptions(
                seed=seed,
                out=folder,
                duration=duration,
                live=live,
                report=not shared.no_report,
                btlog=shared.btlog,
                progress=show,
                sinks=[*sinks, *([_Replacements()] if shared.watch_rules else [])],
                watch_rules=shared.watch_rules,
                knowledge=shared.knowledge,
                signals=signals,
                **changes,
            )
            result = play(scenario, catalog, options)
        _print(result, folder, shared.as_json)
        if live is not None and signals.received is None:
            with suppress(KeyboardInterrupt):  # also before `wait` is entered
                echo("The live page stays open until Ctrl-C.", err=True)
                if not live.wait():
                    echo("The live page stopped responding and was closed.", err=True)
    return exit_code(result.summary, signal=signals.received, missing=bool(result.missing))


def _default_folder(name: str, keep: bool) -> Path:
    """Folder of this name in `runs`; to keep an earlier recording, with the next free number."""
    folder, number = Path("runs") / name, 1
    while keep and (folder / "run.mcap").exists():
        number += 1
        folder = Path("runs") / f"{name}_{number}"
    return folder


def _print(result: RunResult, folder: Path, as_json: bool) -> None:
    """Print the summary, and the files that could not be written."""
    summary = result.summary
    with discard_if_closed():
        echo(summary.to_json().rstrip() if as_json else outcome_text(summary, folder, result.report))
        for line in result.missing:
            echo(line, err=True)


@contextmanager
def _live(port: int) -> Iterator[Any]:
    """Open a live page and print its URL."""
    from ..record import page_maker

    with page_maker("live")(port) as live:
        echo(f"Live: {live.url}", err=True)
        yield live


class _Replacements:
    """Event sink that prints the results of reloading rule files."""

    def emit(self, event: Event) -> None:
        """Print a RulesReplaced event."""
        if isinstance(event, RulesReplaced):
            echo(f"{event.t:.2f} s, {event.agent}: {event.rules}: {event.detail}", err=True)
