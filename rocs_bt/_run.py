"""`run`, `drive` and `report`: simulation, or hardware, with recording and report.

It composes `simulation` and the report, which do not import each other. Imported by `compare` and the command line.
"""

from __future__ import annotations

from pathlib import Path
from typing import Unpack

import msgspec

from .catalog import Catalog, ScenarioSpec
from .errors import RecordingError
from .record import Recording, write_report, write_whole
from .simulation import REPORT, SUMMARY, RunChanges, RunOptions, RunResult, drive_robots, simulate, summary_of

_DEFAULTS = RunOptions()


def run(
    scenario: ScenarioSpec | str,
    catalog: Catalog | None = None,
    options: RunOptions = _DEFAULTS,
    **changes: Unpack[RunChanges],
) -> RunResult:
    """Simulate a scenario.

        result = rocs_bt.run("exp1", seed=3, out="runs/exp1-3")
        print(result.summary.agents["R2"].outcome, result.signals("R2", ["front"])["front"].min())

    SIGINT, SIGTERM and SIGHUP end the run in order: wheels to neutral, outcome `interrupted`, all files written. Then
    the signal has its usual effect, such as a KeyboardInterrupt. A second signal ends it at once, without summary and
    report. If the engine fails, or a disk is full, the files hold what was recorded until then.

    Args:
        scenario: A scenario, or its name or file.
        catalog: Source of the content; the project around the current folder by default.
        options: Options of the run.
        changes: Attributes of `RunOptions` as keywords, which replace those of `options`.

    Raises:
        InputError: Something in the content is wrong; nothing was written.
        RocsError: The engine failed.
        KeyboardInterrupt: A signal ended the run.
    """
    catalog = catalog or Catalog.here()
    return simulate(_spec(scenario, catalog), catalog, msgspec.structs.replace(options, **changes), write_report)


def drive(
    scenario: ScenarioSpec | str,
    catalog: Catalog | None = None,
    options: RunOptions = _DEFAULTS,
    **changes: Unpack[RunChanges],
) -> RunResult:
    """Run the agents of a scenario on their robots, threaded, on wall time; nothing is simulated.

    It ends when every agent has its outcome, when the time is over, or by SIGINT, SIGTERM or SIGHUP: wheels to neutral
    first, then all files. After that the signal has its usual effect, such as a KeyboardInterrupt.

    Args:
        scenario: A scenario, or its name or file. Every driver of its agents' robots must be a user's class.
        catalog: Source of the content; the project around the current folder by default.
        options: Options of the run.
        changes: Attributes of `RunOptions` as keywords, which replace those of `options`.

    Returns:
        The result; in its summary collisions and clearance are None, and poses are the robots' own estimates.

    Raises:
        InputError: Something in the content is wrong, or an option needs a simulated world.
        DeviceError: A driver cannot reach its device.
        KeyboardInterrupt: A signal ended the run.
    """
    catalog = catalog or Catalog.here()
    return drive_robots(_spec(scenario, catalog), catalog, msgspec.structs.replace(options, **changes), write_report)


def report(recording: Recording | Path | str, out: Path | str | None = None) -> RunResult:
    """Make summary.json and report.html from a recording, also from one that was cut off.

    Args:
        recording: A recording, its file, or the folder of a run.
        out: Folder for the files; that of the recording by default.

    Raises:
        RecordingError: The recording cannot be read, or a file cannot be written.
    """
    recorded = recording if isinstance(recording, Recording) else Recording.open(recording)
    folder = recorded.path.parent if out is None else Path(out)
    summary, page = summary_of(recorded), folder / REPORT
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(folder / SUMMARY, summary.to_json())
    except OSError as error:
        hint = "Name another folder with --out."
        raise RecordingError(f"the summary '{folder / SUMMARY}' cannot be written: {error.strerror}. {hint}") from error
    write_report(recorded, summary, page)
    return RunResult(summary=summary, recording=recorded.path, report=page)


def _spec(scenario: ScenarioSpec | str, catalog: Catalog) -> ScenarioSpec:
    return catalog.load_scenario(scenario) if isinstance(scenario, str) else scenario
