"""`rocs-bt rules`: test rule files, replay them on recordings, and tune their thresholds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..base.errors import InputError, unknown
from ..base.words import counted, inactive_rule
from ..catalog import Catalog, Entry
from .content import catalog_for, no_code_option, open_recording
from .terminal import echo, styled

if TYPE_CHECKING:
    from ..reactive import RuleSet
    from ..record import AgentInfo, Recording
    from ..running.rule_replay import ReflexInput, RuleReplay

_PANELS = 6  # default number of rules with drawn signals


@click.group()
def command() -> None:
    """Test rule files, replay them on recordings, tune their thresholds."""


@command.command()
@click.argument("files", metavar="[FILE|NAME]...", nargs=-1)
@click.option("--robot", help="Test for this robot; by default for all robots that use the file in a scenario.")
@no_code_option
def test(files: tuple[str, ...], robot: str | None, no_code: bool) -> int:
    """Run the tests in rule files and in rules/tests; by default those of all rule files of the project.

    Exits with 0 if all tests pass, with 1 if one fails, with 2 if a file is wrong.
    """
    from ..check import fitted_rules, inactive_rules
    from ..reactive import run_tests

    done = failed = wrong = 0
    for entry, catalog in _entries(files, no_code):
        count = 0
        try:
            fitted = fitted_rules(entry, catalog, robot)
        except InputError as error:  # the other files are tested nevertheless
            wrong += 1
            echo(str(error), err=True)
            continue
        skipped = inactive_rules([(name, rule) for name, rules in fitted for rule in rules.inactive])
        for sentence, _ in skipped:
            echo(f"{entry.path}: {sentence}")
        for name, rules in fitted:
            for result in run_tests(rules):
                count += 1
                if not result.passed:
                    failed += 1
                    position = f"{result.position.file}:{result.position.line}:{result.position.column}"
                    failure = f"{position}: {styled('failed', fg='red', bold=True)}: {result.rule}, '{result.test}'"
                    echo(f"{failure}, on {name}: {result.message}", err=True)
        done += count
        if not count and not skipped:
            separate = entry.path.parent / "tests" / entry.path.name
            echo(f"{entry.path}: has no test. Add one as [[rule.NAME.test]], here or in {separate}.", err=True)
    unread = f" {counted(wrong, 'file')} could not be read." if wrong else ""
    echo(f"{counted(done, 'test')}: {done - failed} passed, {failed} failed.{unread}")
    return 2 if wrong else 1 if failed else 0


@command.command()
@click.argument("file", metavar="FILE|NAME")
@click.argument("run", type=click.Path(path_type=Path))
@click.option("--agent", help="Use the signals of this agent; by default of all agents that use the file.")
@click.option("--rule", "wanted", metavar="RULE", multiple=True, help="Draw the signals of this rule; may be repeated.")
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="Output folder; by default RUN/rules.")
@no_code_option
def replay(file: str, run: Path, agent: str | None, wanted: tuple[str, ...], out: Path | None, no_code: bool) -> None:
    """Evaluate the rules of FILE on the signals recorded in RUN; print firings, and draw signals, latches and winners.

    RUN is a run's folder or its run.mcap. Nothing is simulated: the actions of the rules have no effect.
    """
    catalog, recording = catalog_for(file, no_code=no_code), open_recording(run)
    folder = out or (run if run.is_dir() else run.parent) / "rules"
    replay_rules_on(recording, catalog.find("rules", file).path, catalog, folder, agent=agent, wanted=wanted)


def replay_rules_on(
    recording: Recording,
    path: Path,
    catalog: Catalog,
    folder: Path,
    *,
    agent: str | None = None,
    wanted: Sequence[str] = (),
) -> None:
    """Evaluate a rule file on the signals of a recording, print its firings and draw them.

    Args:
        recording: The recording.
        path: Path of the rule file.
        catalog: Source of the robots.
        folder: Folder of the pictures.
        agent: Name of the agent; None for all agents that use the file.
        wanted: Rules with drawn signals; by default those that latch.
    """
    from ..record.figures.rules import draw_rules, write_picture
    from ..running.rule_replay import reflex_input, replay_rules, rule_index

    for info, rules in _fitting(path, _agents(recording, path, agent), catalog):
        _print_inactive(rules, info.robot)
        found = replay_rules(rules, reflex_input(recording, info))
        echo("\n".join(_table(found)))
        traces = found.traces()
        shown = [traces[rule_index(rule, found.rules)].name for rule in wanted]
        shown = shown or [trace.name for trace in traces if trace.latched.any()][:_PANELS]
        canvas = draw_rules(found.inputs.t, traces, shown, f"{path.stem} on {recording.header.label}, {info.name}")
        for picture in write_picture(f"{path.stem}-{info.name}", canvas, folder):
            echo(str(picture))


@command.command()
@click.argument("file", metavar="FILE|NAME")
@click.argument("runs", metavar="RUN...", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--rule", required=True, help="Count the firings of this rule.")
@click.option("--threshold", required=True, help="Threshold to sweep: a name in the file's [threshold] table.")
@click.option("--from", "low", metavar="QUANTITY", help="Minimum value; by default half of the present one.")
@click.option("--to", "high", metavar="QUANTITY", help="Maximum value; by default twice the present one.")
@click.option(
    "--steps",
    type=click.IntRange(2, 1000),
    default=21,
    show_default=True,
    help="Number of values, in addition to the present one.",
)
@click.option("--agent", help="Use the signals of this agent; by default of all agents that use the file.")
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="Output folder; by default RUN/rules.")
@no_code_option
def tune(
    file: str,
    runs: tuple[Path, ...],
    rule: str,
    threshold: str,
    low: str | None,
    high: str | None,
    steps: int,
    agent: str | None,
    out: Path | None,
    no_code: bool,
) -> None:
    """Count the firings of a rule of FILE in each RUN for a range of values of a threshold."""
    import numpy as np

    from ..base.units import read_quantity
    from ..record.figures.rules import draw_sweep, write_picture
    from ..running.rule_replay import reflex_input, rule_index, sweep_threshold, threshold_dimension

    catalog = catalog_for(file, no_code=no_code)
    path = catalog.find("rules", file).path
    recordings = [open_recording(run) for run in runs]
    fitting = [_fitting(path, _agents(recording, path, agent), catalog) for recording in recordings]
    pairs = [(r, info, own) for r, found in zip(recordings, fitting, strict=True) for info, own in found]
    active = [pair for pair in pairs if rule.rpartition("/")[2] not in _inactive(pair[2])] or pairs
    for _, info, own in pairs:
        _print_inactive(own, info.robot)
    fitted = [(reflex_input(recording, info), own) for recording, info, own in active]
    inputs, rules = [each for each, _ in fitted], fitted[0][1]
    rule_index(rule, rules)
    dimension = threshold_dimension(threshold, rules)
    now = [own.thresholds[threshold] for _, own in fitted]  # robots may override it
    around = [factor * present for present in now for factor in (0.5, 2.0)]
    minimum = min(around) if low is None else read_quantity(low, dimension, "--from")
    maximum = max(around) if high is None else read_quantity(high, dimension, "--to")
    if not minimum < maximum:
        raise InputError(f"--from must be less than --to, found {minimum:g} and {maximum:g} {dimension}.")
    values = np.array(_with_present(np.linspace(minimum, maximum, steps).tolist(), now))
    counts = sweep_threshold(
        path, inputs, catalog, rule=rule, threshold=threshold, values=values.tolist(), dimension=dimension
    )
    names = _unique_names([f"{each.run} {each.agent.name}" for each in inputs])
    echo("\n".join(_sweep_table(threshold, str(dimension), values.tolist(), names, counts.tolist(), now)))
    series = {name: counts[:, i] for i, name in enumerate(names)}
    canvas = draw_sweep(threshold, str(dimension), values, series, now, f"{path.stem}/{rule.rpartition('/')[2]}")
    folder = out or (runs[0] if runs[0].is_dir() else runs[0].parent) / "rules"
    for picture in write_picture(f"{path.stem}-{rule.rpartition('/')[2]}-{threshold}", canvas, folder):
        echo(str(picture))


def _inactive(rules: RuleSet) -> set[str]:
    return {rule.name.rpartition("/")[2] for rule in rules.inactive}


def _print_inactive(rules: RuleSet, robot: str) -> None:
    for rule in rules.inactive:
        echo(inactive_rule(rule.name, [robot], rule.missing), err=True)


def _entries(files: Sequence[str], no_code: bool) -> list[tuple[Entry, Catalog]]:
    """Rule files to test: the given ones, else all of the project, else all shipped ones."""
    from ..catalog import is_path
    from ..reactive import tested_file

    if files:
        named = [str(tested_file(Path(file))) if is_path(file) else file for file in files]
        catalogs = [(file, catalog_for(file, no_code=no_code)) for file in named]
        return [(catalog.find("rules", file), catalog) for file, catalog in catalogs]
    catalog = Catalog.here(code=not no_code)
    found = catalog.list("rules")
    own = [entry for entry in found if entry.origin == "project"]
    return [(entry, catalog) for entry in own or found]


def _agents(recording: Recording, file: Path, wanted: str | None) -> list[AgentInfo]:
    """Select agents of a recording: the one named `wanted`, else those that used the rule file, else all."""
    agents = recording.header.agents
    if wanted is not None:
        found = [agent for agent in agents if agent.name == wanted]
        if not found:
            raise InputError(unknown("agent", wanted, [agent.name for agent in agents], "The run"))
        return found
    return [agent for agent in agents if file.stem in agent.rules] or list(agents)


def _fitting(file: Path, agents: Sequence[AgentInfo], catalog: Catalog) -> list[tuple[AgentInfo, RuleSet]]:
    """Agents that a rule file fits, each with its rules; raises InputError."""
    from ..running.rule_replay import rules_for

    found, errors = [], []
    for agent in agents:
        try:
            found.append((agent, rules_for(file, agent, catalog)))
        except InputError as error:
            errors.append(error)
            echo(f"{file.name} does not fit {agent.name}, a {agent.robot}.", err=True)
    if not found:
        raise errors[0]
    return found


def _table(found: RuleReplay) -> list[str]:
    """Lines of a table of all firings, then the number of firings of each rule, in the replay and in the run itself."""
    inputs: ReflexInput = found.inputs
    lines = [f"{found.rules.name} on {inputs.run}, {inputs.agent.name}: {len(inputs.t)} samples, not interpolated"]
    if found.firings:
        width = max(len(f.rule) for f in found.firings)
        lines.append(f"  {'from [s]':>9} {'to [s]':>8} {'wins [s]':>9}  {'rule':<{width}}  reading")
    for f in found.firings:
        lines.append(f"  {f.begin:>9.2f} {f.end:>8.2f} {f.won:>9.2f}  {f.rule:<{width}}  {f.reading}")
    own = found.rules.name in inputs.agent.rules
    for rule in found.rules.rules:
        line = f"  {rule.name}: {counted(sum(f.rule == rule.name for f in found.firings), 'time')}"
        lines.append(line + (f", {len(inputs.latched.get(rule.name, ()))} in the run itself" if own else ""))
    return lines


def _with_present(values: Sequence[float], now: Sequence[float]) -> list[float]:
    """Threshold values to try: the given ones, and the present values of the runs (`now`)."""
    others = [value for value in values if not any(math.isclose(value, present) for present in now)]
    return sorted({*others, *now})


def _sweep_table(
    threshold: str, unit: str, values: list[float], names: list[str], counts: list[list[float]], now: Sequence[float]
) -> list[str]:
    """Lines of a table: a row per value of the threshold, a column per run; each run's present value is marked."""
    head = f"{threshold} [{unit}]"
    lines = [f"{head:>14}  " + "  ".join(f"{name:>10}" for name in names) + ("       all" if len(names) > 1 else "")]
    for value, row in zip(values, counts, strict=True):
        cells = "  ".join(f"{count:>{max(10, len(name))}.0f}" for count, name in zip(row, names, strict=True))
        total = f"  {sum(row):>8.0f}" if len(names) > 1 else ""
        own = [name for name, present in zip(names, now, strict=True) if present == value]
        mark = "  <- now" + (f" of {', '.join(own)}" if len(own) < len(names) else "") if own else ""
        lines.append(f"{value:>14.4g}  {cells}{total}{mark}")
    return lines


def _unique_names(names: list[str]) -> list[str]:
    """The same names; names that occur more than once get a number, such as `run #2`."""
    return [f"{name} #{names[: i + 1].count(name)}" if names.count(name) > 1 else name for i, name in enumerate(names)]
