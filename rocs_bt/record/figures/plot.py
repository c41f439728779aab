"""All figures of a run as files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ...errors import Fault, InputError, RecordingError
from ..history import History
from ..recording import Recording
from .activation import Activation
from .arena import Arena
from .coordinates import Coordinates
from .figure import Figure
from .wheels import Wheels

FIGURES: tuple[Figure, ...] = (Arena(), Coordinates(), Activation(), Wheels())
_FORMATS = ("png", "svg", "pdf")


def write_figures(recordings: Sequence[Recording], folder: Path, formats: Sequence[str] = ("png", "svg")) -> list[Path]:
    """Draw every figure of a run, or of several laid over each other, into files; returns their paths.

    Args:
        recordings: One or more runs; the world drawn is the first one's.
        folder: Where to write; made if it does not exist.
        formats: Any of `png`, `svg`, `pdf`.

    Raises:
        InputError: There is nothing to draw, or a format is unknown.
        RecordingError: A file cannot be written.
    """
    unknown = [f for f in formats if f not in _FORMATS]
    if unknown or not recordings:
        found = f"the format '{unknown[0]}' is not known." if unknown else "there is no recording to plot."
        raise InputError(Fault(found, hint=f"Give one or more runs, and formats of: {', '.join(_FORMATS)}."))
    runs, paths = [History(r) for r in recordings], []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for figure in FIGURES:
            for form in formats:
                paths.append(folder / f"{figure.name}.{form}")
                paths[-1].write_bytes(figure.render(runs, form))
    except OSError as error:
        raise RecordingError(f"the figures cannot be written to '{folder}': {error.strerror}.") from error
    return paths
