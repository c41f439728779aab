"""Pages of runs, made by the packages that registered them in the entry points `rocs_bt.report`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..base.registered import load
from .file.recording import Recording
from .file.summary import Summary


def page_maker(name: str) -> Any:
    """What is registered under a name.

    `report` writes a report, `live` is the class of live pages, `knowledge` and `tree` render the knowledge of an agent
    and the tree of a mission.

    Raises:
        InputError: No package makes this page, or it cannot be loaded.
    """
    return load("rocs_bt.report", name)


def write_report(recording: Recording, summary: Summary | None, path: Path, second: Recording | None = None) -> None:
    """Write report.html of a run, with the registered writer; a second recording is shown over the first.

    Raises:
        InputError: No writer is registered.
        RecordingError: The file cannot be written, or the recording cannot be read.
    """
    page_maker("report")(recording, summary, path, second)
