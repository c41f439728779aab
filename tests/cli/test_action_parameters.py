"""Types and lengths of actions' parameters, by `check` and before a run: at the line of the mission or rule file."""

import pytest

MISSION = '''"""Drives."""

from rocs_bt import Mission
from rocs_bt.base.units import PositiveMetresPerSecond


def build(mission: Mission, *, first: str, second: str, cruise: PositiveMetresPerSecond = 0.4):
    return {leaf}
'''


@pytest.mark.parametrize("leaf", ['mission.act("SetWheelSpeed", speeds=["0.2 m/s", 0.2], duration="1 s")'])
def test_quantities_in_lists_become_numbers(leaf, project, rocs_bt):
    file = project / "planners/missions/patrol.py"
    file.write_text(MISSION.format(leaf=leaf))
    run = rocs_bt("run", "first", "--no-report")
    assert run.code == 1
    assert "0.2 m from" not in run.err
    assert "moved 0.2" in run.out
