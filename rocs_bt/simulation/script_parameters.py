"""Parameters of the scripts of actors, read from the scenario."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

from ..base.parameter import field_parameters, read_arguments
from ..catalog import ActorSpec
from ..declare import positions_of

T = TypeVar("T")


def script_parameters(declared: type[T], actor: ActorSpec, file: Path) -> T:
    """Create the parameters of an actor's script.

    Raises:
        InputError: Parameters are unknown, missing, of a wrong unit or out of range; the error lists all faults.
    """
    what = f"{actor.script} '{actor.name}'"
    fields, positions = field_parameters(declared), positions_of(actor.parameters)
    return declared(**read_arguments(fields, actor.parameters, what, file=file, positions=positions))
