"""Planners: that what they name exists, and that their mission takes their parameters."""

from __future__ import annotations

from collections.abc import Iterable

from ..catalog import Catalog, Entry, at_parameters
from ..errors import Fault, InputError
from ..plan import mission_arguments


def check_planner_file(entry: Entry, catalog: Catalog) -> Iterable[Fault]:
    """All that is wrong with a planner; its parameters only where Python content may run."""
    planner = catalog.load_planner(str(entry.path))
    if not catalog.code and catalog.find("mission", planner.mission).path.suffix == ".py":
        return
    try:
        mission_arguments(catalog.load_mission(planner.mission, planner.nodes), planner.parameters)
    except InputError as error:
        yield from at_parameters(planner, error).faults
