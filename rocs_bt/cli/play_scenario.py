"""Parts that `rocs-bt run` and `rocs-bt drive` share: options, live page, progress bar and printed outcome."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..catalog import CachingCatalog
from ..event import Event, RulesReplaced, SubtreeSwapped, SwapRefused
from .content import catalog_for, json_option, no_code_option
from .options import declared_options
from .outcome import exit_code, outcome_text
from .progress import ProgressBar
from .terminal import discard_if_closed, echo, show_warnings

if TYPE_CHECKING:
    from ..catalog import Catalog, ScenarioSpec
    from ..running import RunResult

_NOTICE = "\n{signal}: ending the run and writing its report; a second signal ends it at once.\n"

_LOCAL = (
    click.option("--live", "show_live", is_flag=True, help="Watch in a browser, until Ctrl-C."),
    click.option(
        "--port", type=click.IntRange(0, 65535), default=0, help="Port of the live page; by default any free port."
    ),
    json_option("Print the summary as JSON."),
    no_code_option,
)


def scenario_options(stage: str) -> Callable[..., Any]:
    """Decorator that adds the argument SCENARIO and all options to a command that runs a scenario."""
    from ..running import RunOptions

    def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
        for option in reversed((click.argument("scenario"), declared_options(RunOptions, stage), *_LOCAL)):
            function = option(function)
        return function

    return decorate


def play_scenario(
    scenario: str,
    *,
    show_live: bool,
    port: int,
    as_json: bool,
    no_code: bool,
    unit: str,
    planner: str = "",
    on_hardware: bool = False,
    progress: Callable[[float], None] | None = None,
    **given: Any,
) -> int:
    """Run a scenario, print its outcome, and return the exit code.

    Args:
        scenario: Name or file of the scenario; with a planner also a scene of a family.
        show_live: Whether to show the live page.
        port: Port of the live page; 0 for any free port.
        as_json: Whether to print the summary as JSON.
        no_code: Whether to refuse Python content.
        unit: Unit of the progress bar.
        planner: Name of the planner that controls the agent under test; empty for the scenario's own.
        on_hardware: Whether to run on hardware. The default folder of output then keeps an earlier recording.
        progress: Function that is called once per control period, with the time [s].
        given: Options of the run, by attribute of `RunOptions`.
    """
    from .._run import checked_run
    from ..check import mission_notes
    from ..running import RunOptions, StopSignals

    made, swaps = _Changes(), sorted(given.get("swaps", ()), key=lambda swap: swap.at)
    if given["watch_rules"] or swaps:
        given["sinks"] = [*given.get("sinks", ()), made]
    project = catalog_for(scenario, no_code=no_code)
    catalog: Catalog = CachingCatalog(project.project, code=project.code)  # robots of one kind are loaded once
    if planner:
        from ..compare.replay import episode_command

        given["command"] = episode_command(planner, scenario)
    played, catalog = _episode(planner, scenario, catalog) if planner else (scenario, catalog)
    run, findings = checked_run(played, catalog, RunOptions(**given), on_hardware=on_hardware)
    spec = run.spec
    notes = [note for agent in spec.agents for note in mission_notes(agent, catalog)]
    for note in dict.fromkeys(notes):
        echo(str(note), err=True)
    show_warnings(findings.warnings, "rocs-bt check" if planner else f"rocs-bt check {scenario}")
    folder = given["out"] or _default_folder(planner, scenario if planner else spec.name, given["seed"], on_hardware)
    signals = StopSignals(_NOTICE)
    with closing(run), _live(port) if show_live else nullcontext() as live:
        with ProgressBar(spec.name, given["duration"] or spec.duration, unit) as shown:

            def show(t: float) -> None:
                if progress is not None:
                    progress(t)
                shown(t)

            result = run.conduct(out=folder, live=live, progress=show, signals=signals)
        _print(result, folder, as_json)
        if live is not None and signals.received is None:
            with suppress(KeyboardInterrupt):  # also before `wait` is entered
                echo("The live page stays open until Ctrl-C.", err=True)
                if not live.wait():
                    echo("The live page stopped responding and was closed.", err=True)
    for swap in swaps[made.swaps :]:
        echo(f"'{swap}' was not made, because the run had ended.", err=True)
    return exit_code(result.summary, signal=signals.received, missing=bool(result.missing))


def _episode(planner: str, scene: str, catalog: Catalog) -> tuple[ScenarioSpec | str, Catalog]:
    """Scenario of a scene with its planner, and the catalog of its content."""
    from ..compare.replay import episode_scenario

    return episode_scenario(catalog.load_planner(planner), scene, catalog)


def _default_folder(planner: str, scenario: str, seed: int, keep: bool) -> Path:
    """Folder of a run in `runs`; to keep an earlier recording, with the next free number."""
    if planner:
        from ..compare.replay import episode_folder

        return episode_folder(planner, scenario, seed)
    folder = first = Path("runs") / f"{scenario}-{seed}"
    number = 1
    while keep and (folder / "run.mcap").exists():
        number += 1
        folder = first.with_name(f"{first.name}_{number}")
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


class _Changes:
    """Event sink that prints the replacements of rules and subtrees, and counts the latter."""

    def __init__(self) -> None:
        self.swaps = 0

    def emit(self, event: Event) -> None:
        """Print a replacement, or why it was refused."""
        if isinstance(event, (RulesReplaced, SubtreeSwapped, SwapRefused)):
            self.swaps += not isinstance(event, RulesReplaced)
            echo(f"{event.t:.2f} s, {event.agent}: {event.sentence}", err=True)
