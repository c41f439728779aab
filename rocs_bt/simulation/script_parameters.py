"""Parameters of the scripts of actors, read from the scenario."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

from ..base.parameter import field_parameters, read_arguments
from ..catalog import ActorSpec

T = TypeVar("T")


def script_parameters(declared: type[T], actor: ActorSpec, file: Path) -> T:
    """Create the parameters of an actor's script.

    Raises:
        InputError: Parameters are unknown, missing, of a wrong unit or out of range; the error lists all faults.
    """
    what = f"{actor.script} '{actor.name}'"
    values = read_arguments(field_parameters(declared), actor.parameters, what, file=file, positions=actor.positions)
    return declared(**values)
