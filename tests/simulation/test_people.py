"""Scripted people, and the doors of others: what they do at a stationary robot in their way."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.compare.company import Company
from rocs_bt.event import ListSink
from rocs_bt.simulation import build_world

PERSON = '<body name="{0}" mocap="true" pos="0 0 0.85"><geom name="{0}" type="cylinder" size="{1}"/></body>'
HALL = """<mujoco><worldbody><geom name="floor" type="plane" size="9 9 0.1"/>{}</worldbody></mujoco>"""

WAIT = """<root BTCPP_format="4" main_tree_to_execute="Wait"><BehaviorTree ID="Wait">
<KeepRunningUntilFailure><AlwaysSuccess/></KeepRunningUntilFailure></BehaviorTree></root>"""

SCENARIO = """
format = "scenario/2"
doc = "People walk past a stationary robot."
world = "hall"
duration = "60 s"
[[agent]]
name = "R"
robot = "{robot}"
mission = "wait"
x = "0 m"
y = "0 m"
yaw = "40 deg"
"""

WALK = """
[[actor]]
name = "{name}"
script = "{script}"
x = "{x} m"
y = "{y} m"
to_x = "{to_x} m"
to_y = "{to_y} m"
speed = "{speed} m/s"
"""


@pytest.fixture
def hall(tmp_path):
    def build(walks, robot="jackal", seed=1, more="", people=None):
        text = SCENARIO.format(robot=robot)
        for i, (script, x, y, to_x, to_y) in enumerate(walks):
            text += WALK.format(name=f"P{i}", script=script, x=x, y=y, to_x=to_x, to_y=to_y, speed=1.0) + more
        for folder in ("scenarios/worlds", "planners/missions"):
            (tmp_path / folder).mkdir(parents=True, exist_ok=True)
        (tmp_path / "planners/missions/wait.xml").write_text(WAIT, encoding="utf-8")
        (tmp_path / "scenarios/hall.toml").write_text(text, encoding="utf-8")
        people = people or "".join(PERSON.format(f"P{i}", "0.25 0.85") for i in range(len(walks)))
        (tmp_path / "scenarios/worlds/hall.xml").write_text(HALL.format(people), encoding="utf-8")
        catalog = Catalog(tmp_path)
        return build_world(catalog.load_scenario("hall"), catalog, seed, ListSink())

    return build


def walked(simulated, seconds: float, speed=None):
    """Positions of all people, shape (periods, people, 2), and all contacts; the robot stays, or drives ahead."""
    path, contacts, world = [], [], simulated.world
    for _ in range(round(seconds / 0.05)):
        if speed is not None:
            simulated.actuators["R"]["wheels"].command([speed] * simulated.actuators["R"]["wheels"].size)
        for actor in simulated.actors:
            actor.step(simulated.clock.now())
        world.advance(10)
        contacts += world.contacts()
        path.append([world.object_pose(actor.name)[:2] for actor in simulated.actors])
    return np.array(path), contacts


THROUGH = [(-4.0, 0.1, 4.0, -0.1), (0.1, 4.0, 0.0, -4.0), (3.0, 3.0, -3.0, -3.0)]


@pytest.mark.parametrize("robot", ["jackal", "quadruped", "pioneer_p3dx"])
def test_polite_people_walk_round_the_outline_of_a_robot(hall, robot) -> None:
    simulated = hall([("social_force", *ends) for ends in THROUGH], robot)
    path, contacts = walked(simulated, 30.0)
    assert contacts == []
    assert (np.abs(np.diff(path, axis=0)).sum(axis=(0, 2)) > 15.0).all(), "they walk"


def test_blind_people_stop_at_what_they_touch_push_nothing_and_turn_back(hall) -> None:
    simulated = hall([("polynomial", *ends) for ends in THROUGH])
    before = simulated.world.pose("R")
    path, contacts = walked(simulated, 40.0)
    assert {contact.driven for contact in contacts} == {False}
    assert before.distance(simulated.world.pose("R")) < 0.01, "nobody bulldozes"
    assert np.hypot(*np.moveaxis(path, 2, 0)).min() > 0.4, "nobody walks through it"
    assert (np.abs(path[-300:] - path[-1]).max(axis=(0, 2)) > 0.5).all(), "all walk on"


def test_blind_people_turn_round_within_less_than_a_second(hall) -> None:
    path, _ = walked(hall([("polynomial", -3.0, 2.0, 3.0, 2.0)]), 20.0)
    speed = np.diff(path[:, 0, 0]) / 0.05
    turns = np.flatnonzero(np.diff(np.sign(speed)))
    assert len(turns) >= 2
    assert np.abs(np.diff(speed)).max() / 0.05 < 2.0 * 1.0 / 0.8 + 0.3, "acceleration of a person [m/s2]"
    for turn in turns:
        assert abs(speed[min(turn + 10, len(speed) - 1)]) > 0.9


def test_a_push_against_one_person_is_one_contact(hall) -> None:
    simulated = hall([("polynomial", -3.0, 0.0, 3.0, 0.0)])
    _, contacts = walked(simulated, 3.0)
    times = [contact.t for contact in contacts]
    assert all(later - earlier > 1.0 for earlier, later in pairwise(times))


LEG = """
[[actor]]
name = "P0_{0}"
script = "leg"
person = "P0"
side = "{0}"
x = "1.5 m"
y = "{1} m"
"""


def test_a_push_of_a_person_with_two_legs_is_one_contact_too(hall) -> None:
    person = PERSON.format("P0", "0.25 0.85").replace("<geom", '<geom contype="0" conaffinity="0"')
    people = person + PERSON.format("P0_left", "0.06 0.85") + PERSON.format("P0_right", "0.06 0.85")
    legs = LEG.format("left", 1.1) + LEG.format("right", 1.3)
    _, contacts = walked(hall([("polynomial", 1.5, 1.2, 1.0, 0.9)], more=legs, people=people), 5.0, speed=0.5)
    assert {contact.other for contact in contacts} == {"P0"}
    assert all(later.t - earlier.t > 1.0 for earlier, later in pairwise(contacts))


def test_a_push_against_two_geoms_of_one_object_is_one_contact(hall) -> None:
    sides = (f'<geom name="side_{y}" type="box" size="0.03 0.03 0.1" pos="0 {y} 0"/>' for y in (-0.1, 0.1))
    cart = f'<body name="cart" pos="0.6 0.5 0.1" euler="0 0 40"><freejoint/>{"".join(sides)}</body>'
    _, contacts = walked(
        hall([("polynomial", -4.0, 4.0, -4.0, 3.0)], people=PERSON.format("P0", "0.25 0.85") + cart), 2.0, 0.5
    )
    assert [contact.driven for contact in contacts] == [True]


def test_a_robot_that_drives_into_a_person_collides(hall) -> None:
    simulated = hall([("polynomial", 1.5, 1.2, 1.2, 1.2)])
    _, contacts = walked(simulated, 4.0, speed=0.5)
    assert [(contact.other, contact.driven) for contact in contacts][:1] == [("P0", True)]


@pytest.mark.parametrize(("script", "more"), [("social_force", ""), ("polynomial", 'deviation = "0.5 m"\n')])
def test_the_same_seed_gives_the_same_walks(hall, script, more) -> None:
    walks = [(script, *ends) for ends in THROUGH]
    first, second, other = (walked(hall(walks, seed=seed, more=more), 5.0)[0] for seed in (1, 1, 2))
    assert (first == second).all()
    assert (first != other).any()


def test_company_is_measured_between_outlines(hall) -> None:
    simulated = hall([("social_force", *ends) for ends in THROUGH])
    company, gaps = Company("R", simulated), []
    for _ in range(200):
        for actor in simulated.actors:
            actor.step(simulated.clock.now())
        simulated.world.advance(10)
        company.measure()
        gaps.append(min(simulated.world.clearance("R")[0], 5.0))
    for extent in (0.45, 1.2, 2.5):
        assert company.intrusion(extent) == pytest.approx(np.mean(np.array(gaps) < extent))
    assert 0.0 < company.time_to_collision < math.inf
