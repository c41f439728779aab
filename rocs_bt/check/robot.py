"""robot.toml and its model together."""

from __future__ import annotations

from collections.abc import Iterable

from ..catalog import Catalog, Entry, load_robot
from ..errors import Fault, InputError
from .model import check_model
from .paper import paper_agent


def check_robot(entry: Entry, catalog: Catalog) -> Iterable[Fault]:
    """All that is wrong with a robot: its table, its model, and its blocks."""
    robot = load_robot(entry.path)
    yield from check_model(robot)
    if catalog.code or not robot.code:
        try:
            paper_agent(robot, catalog.load_class)
        except InputError as error:
            yield from error.at(robot.file).faults
