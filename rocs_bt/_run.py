"""Functions `run`, `drive` and `report`: run a scenario in simulation or on hardware, with recording and report.

This module combines the check, the run and the report. Only `compare` and the command line
import it.
"""

from __future__ import annotations

from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import msgspec

from .base.errors import InputError, RecordingError
from .base.files import read_once, write_whole
from .catalog import CachingCatalog, Catalog, ScenarioSpec
from .check import Findings, check_run, check_scenario
from .record import FolderLock, Recording, write_report
from .running import REPORT, SUMMARY, Run, RunOptions, RunResult, summary_of

_DEFAULTS = RunOptions()


def run(
    scenario: ScenarioSpec | str,
    catalog: Catalog | None = None,
    options: RunOptions = _DEFAULTS,
    **changes: Any,
) -> RunResult:
    """Simulate a scenario.

        result = rocs_bt.run("exp1", seed=3, out="runs/exp1-3")
        print(result.summary.agents["R2"].outcome, result.signals("R2", ["front"])["front"].min())

    SIGINT, SIGTERM and SIGHUP end the run in order: the wheels go to neutral, the outcome is `interrupted`, and all
    files are written. Then the signal has its usual effect, such as a KeyboardInterrupt. A second signal ends the run
    immediately, without summary and report. If the engine fails or a disk is full, the files contain the events so far.

    Args:
        scenario: Scenario, or its name, or its file.
        catalog: Source of the content; by default the project around the current folder.
        options: Options of the run.
        changes: Attributes of `RunOptions` as keywords, which replace those of `options`.

    Raises:
        InputError: `rocs-bt check` finds errors in the scenario, or an option is invalid; nothing was written.
        RocsError: The engine failed.
        KeyboardInterrupt: A signal ended the run.
    """
    return _conduct(scenario, catalog, options.changed(**changes))


def drive(
    scenario: ScenarioSpec | str,
    catalog: Catalog | None = None,
    options: RunOptions = _DEFAULTS,
    **changes: Any,
) -> RunResult:
    """Run the agents of a scenario on their real robots, in threaded mode and real time.

    The robots stay in neutral until every sensor gives fresh values, except those that robot.toml declares as optional.
    The run ends when every agent has its outcome, when the duration is over, or by SIGINT, SIGTERM or SIGHUP: first the
    wheels go to neutral, then all files are written. After that the signal has its usual effect, such as a
    KeyboardInterrupt.

    Args:
        scenario: Scenario, or its name, or its file. All drivers of its agents' robots must be users' classes.
        catalog: Source of the content; by default the project around the current folder.
        options: Options of the run.
        changes: Attributes of `RunOptions` as keywords, which replace those of `options`.

    Returns:
        Result of the run. In its summary, collisions and clearance are None, and poses are the robots' own estimates.

    Raises:
        InputError: The content is invalid, or an option needs a simulated world.
        DeviceError: A driver cannot reach its device, or a needed sensor gave no fresh values within the option `wait`.
        KeyboardInterrupt: A signal ended the run.
    """
    return _conduct(scenario, catalog, options.changed(**changes), on_hardware=True)


def report(recording: Recording | Path | str, out: Path | str | None = None) -> RunResult:
    """Write summary.json and report.html from a recording, which may be truncated.

    Args:
        recording: Recording, or its file, or the folder of a run.
        out: Folder for the two files; by default the folder of the recording.

    Raises:
        InputError: A run is writing in the folder.
        RecordingError: The recording cannot be read, or a file cannot be written.
    """
    recorded = recording if isinstance(recording, Recording) else Recording.open(recording)
    folder = recorded.path.parent if out is None else Path(out)
    summary, page = summary_of(recorded), folder / REPORT
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with closing(FolderLock(folder)):
            write_whole(folder / SUMMARY, summary.to_json())
            write_report(recorded, summary, page)
    except OSError as error:
        hint = "Name another folder with --out."
        raise RecordingError(f"the summary '{folder / SUMMARY}' cannot be written: {error.strerror}. {hint}") from error
    return RunResult(summary=summary, recording=recorded.path, report=page)


def checked_run(
    scenario: ScenarioSpec | str, catalog: Catalog, options: RunOptions = _DEFAULTS, *, on_hardware: bool = False
) -> tuple[Run, Findings]:
    """Prepare a run of a scenario as its check; returns the run, for `conduct`, and the findings without errors.

    Raises:
        InputError: The check finds errors in the scenario; contains all of them.
    """
    with ExitStack() as refused, read_once():
        try:
            spec = catalog.load_scenario(scenario) if isinstance(scenario, str) else scenario
        except InputError:
            check_scenario(scenario, catalog).refuse()  # all faults, also those of the robots
            raise
        run = Run(spec, catalog, options, on_hardware=on_hardware)
        refused.callback(run.close)
        findings = check_run(run)
        findings.refuse()
        if not on_hardware:  # else `conduct` opens the devices, when its signals are handled
            if not run.prepared:
                run.prepare()
            run.open()
        refused.pop_all()
    return run, findings


def _conduct(
    scenario: ScenarioSpec | str, catalog: Catalog | None, options: RunOptions, *, on_hardware: bool = False
) -> RunResult:
    """Check a scenario, run it, and add the warnings of the check to the result."""
    run, findings = checked_run(scenario, catalog or CachingCatalog.here(), options, on_hardware=on_hardware)
    return msgspec.structs.replace(run.conduct(), warnings=findings.warnings)
