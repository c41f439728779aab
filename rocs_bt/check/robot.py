"""robot.toml and its model together."""

from __future__ import annotations

from collections.abc import Iterable

from ..agent import Mind
from ..catalog import Catalog, Entry
from ..errors import Fault, InputError, unknown
from .model import check_model
from .paper import idle, paper_agent
from .trial import driver_faults, trial_faults


def check_robot(entry: Entry, catalog: Catalog) -> Iterable[Fault]:
    """All that is wrong with a robot: its table, its own drivers, its model, and its blocks."""
    robot = catalog.load_robot(str(entry.path))
    own = not robot.code or catalog.code
    if own:
        yield from driver_faults(robot, catalog)
    sensors = yield from check_model(robot, catalog)
    known = [rules.name for rules in catalog.list("rules")]
    for name, thresholds in robot.thresholds.items():
        if name not in known:
            line = next((line for _, line, _ in thresholds.values()), 0)
            yield unknown("rule file", name, known).at(robot.file, line)
    if not own:
        return
    try:
        agent = paper_agent(robot, catalog.load_class, Mind(build=idle, schema=catalog.load_schema()))
    except InputError as error:
        yield from error.at(robot.file).faults
    else:
        yield from trial_faults(agent, robot, sensors)
