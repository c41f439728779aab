"""Check of a mission without an agent."""

from __future__ import annotations

from rocs_bt.base.errors import Fault
from rocs_bt.event import NullSink
from rocs_bt.interfaces.pipeline import Pipeline
from rocs_bt.plan import CheckOptions, Mission, checked_plan


def check_mission(
    build, *, knowledge, clock, actions, parameters=None, robot="this robot", later=None, **parts
) -> list[Fault]:
    """Faults of a mission that is built and checked as in the check of a scenario."""
    options = CheckOptions(robot=robot, later=later)
    pipeline = Pipeline(clock, NullSink())
    mission = Mission("check", knowledge=knowledge, pipeline=pipeline, actions=actions, check_options=options, **parts)
    checked_plan(build, mission, parameters or {})
    return mission.faults
