"""No robot backs into what it cannot see: every shipped robot on wheels, with a wall or a post behind it."""

import pytest

from rocs_bt import run
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog, SuccessSpec
from rocs_bt.declare import replaced

CATALOG = Catalog()
ROBOTS = {entry.name: CATALOG.load_robot(entry.name) for entry in CATALOG.list("robot")}
WHEELED = ("jackal", "pioneer_p3dx", "robotino", "rosbot_xl", "summit_xl", "turtlebot3_burger")
WEST, NORTH = -2.5, 2.5  # [m] the walls of the arena


@pytest.fixture(scope="module")
def back_off(tmp_path_factory):
    """A mission that backs off by 0.6 m, waits, and tries again."""
    file = tmp_path_factory.mktemp("mission") / "back_off.xml"
    file.write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="back_off"><Repeat num_cycles="3"><ForceSuccess>'
        '<Flinch speed="-0.4 m/s" distance="0.6 m" timeout="3 s"/></ForceSuccess></Repeat></BehaviorTree></root>',
        encoding="utf-8",
    )
    return str(file)


def played(robot, pose, mission, rules=(), duration=6.0, goal=None):
    scenario = CATALOG.load_scenario("exp1")
    place = scenario.places[0] if goal is None else replaced(scenario.places[0], pose=goal)
    agent = replaced(
        scenario.agents[0],
        robot=robot,
        mission=mission,
        rules=rules,
        pose=pose,
        jitter=Pose2(0.0, 0.0),
        success=SuccessSpec(),
        parameters={} if goal is None else {"goal": "goal"},
    )
    scenario = replaced(scenario, places=(place,), agents=(agent,), actors=(), duration=duration)
    (found,) = run(scenario, CATALOG, seed=1).summary.agents.values()
    return found


@pytest.mark.parametrize("robot", WHEELED)
@pytest.mark.parametrize("gap", [0.05, 0.3])
def test_it_does_not_back_into_a_wall(robot, gap, back_off):
    # No hull begins more than 0.08 m behind the middle of its box.
    x = WEST + 0.5 * ROBOTS[robot].body.length + 0.08 + gap
    found = played(robot, Pose2(x, -1.0, 0.0), back_off)
    assert not found.collisions
    sees = robot not in ("jackal", "summit_xl")
    assert (found.path_length > 0.1) == (sees and gap > 0.2)


@pytest.mark.parametrize("gap", [0.1, 0.13, 0.25])
def test_the_recoveries_of_navigate_do_not_back_into_a_wall_that_the_scanner_cannot_see(gap):
    pose = Pose2(-1.0, NORTH - 0.254 - gap, -1.57)
    found = played("jackal", pose, "navigate", ("contact",), duration=8.0, goal=Pose2(0.0, 8.0))  # outside of the arena
    assert not found.collisions, found.contacts
