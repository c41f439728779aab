"""A mission that drives to a goal is there by the goal's own tolerance, whatever that is: SUCCESS is a success."""

import pytest

from rocs_bt import run
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.declare import replaced

CATALOG = Catalog()
ROBOTS = ("jackal", "turtlebot3_burger", "rosbot_xl")


def played(mission, robot, tolerance, parameters):
    """Outcome of a drive of 1 m over a plane to a goal with this tolerance [m]."""
    scenario = CATALOG.load_scenario("exp1")
    goal = replaced(scenario.places[0], tolerance=tolerance)
    agent = replaced(
        scenario.agents[0], robot=robot, mission=mission, rules=(), pose=Pose2(-1.0, 0.2, 0.5), parameters=parameters
    )
    scenario = replaced(scenario, world="plane", places=(goal,), agents=(agent,), actors=(), duration=15.0)
    (found,) = run(scenario, CATALOG, seed=1).summary.agents.values()
    return found


@pytest.mark.parametrize("tolerance", [0.03, 0.1, 0.3])
@pytest.mark.parametrize(("mission", "robot"), [*(("navigate", name) for name in ROBOTS), ("go_to", "jackal")])
def test_success_of_the_mission_is_success_of_the_scenario(mission, robot, tolerance):
    found = played(mission, robot, tolerance, {"goal": "goal"})
    assert found.outcome == "success", found.reason
