"""Drive to a place and wait."""

from rocs_bt import Mission
from rocs_bt.base.units import PositiveMetresPerSecond


def build(mission: Mission, *, first: str, cruise: PositiveMetresPerSecond = 0.4):
    drive = mission.act("GoTo", goal=first, cruise=cruise)
    return mission.node("Sequence", drive, mission.wait("1 s"))
