"""rules/among_people.toml with physics: a robot that a mission drives straight ahead, and blind people in its way."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from rocs_bt import run
from rocs_bt.catalog import Catalog
from rocs_bt.event import ContactBegan, Event, ListSink, RuleChanged

PEOPLE = 4
APART = 0.9  # [m] least distance of two people, without the robot: nobody walks through another
PERSON = '<body name="P{0}" mocap="true" pos="0 0 0.85"><geom name="P{0}" type="cylinder" size="0.25 0.85"/></body>'
WORLD = '<mujoco><worldbody><geom name="floor" type="plane" size="30 30 0.1"/>{}</worldbody></mujoco>'
REACTION = 0.1  # [s] delay of the motors: no command after the release moves the robot earlier
AHEAD = """<root BTCPP_format="4" main_tree_to_execute="ahead"><BehaviorTree ID="ahead">
<RetryUntilSuccessful num_attempts="-1"><GoTo goal="end" cruise="1.2 m/s"/></RetryUntilSuccessful>
</BehaviorTree></root>"""
SCENARIO = """
format = "scenario/2"
doc = "A robot drives straight ahead, and blind people cross its way and come towards it."
world = "street"
duration = "4 s"
[[place]]
name = "end"
x = "14 m"
y = "0 m"
[[agent]]
name = "R"
robot = "jackal"
mission = "ahead"
rules = ["among_people"]
x = "0 m"
y = "0 m"
"""
WALK = """
[[actor]]
name = "P{}"
script = "polynomial"
x = "{:.3f} m"
y = "{:.3f} m"
to_x = "{:.3f} m"
to_y = "{:.3f} m"
speed = "{:.3f} m/s"
"""


def walks(seed: int) -> str:
    """People that cross the way of the robot where it may be, or come towards it, and keep away from each other."""
    rng, people, text = np.random.default_rng(seed), [], ""
    times = np.arange(0.0, 4.0, 0.1)
    while len(people) < PEOPLE:
        speed, meets = rng.uniform(0.5, 1.4), rng.uniform(1.5, 4.0)  # [m/s], [s]
        at = np.array([rng.uniform(0.5, 1.0) * meets, rng.uniform(-0.4, 0.4)])
        angle = math.pi + rng.uniform(-0.3, 0.3) if len(people) % 2 else rng.choice([-1.0, 1.0]) * rng.uniform(1.1, 2.0)
        velocity = speed * np.array([math.cos(angle), math.sin(angle)])
        path = at + (times[:, None] - meets) * velocity
        if all(np.hypot(*(path - other).T).min() > APART for other in people) and np.hypot(*path[0]) > 1.0:
            text += WALK.format(len(people), *path[0], *(path[0] + 12.0 * velocity), speed)
            people.append(path)
    return text


def street(folder: Path, seed: int) -> list[Event]:
    for name, text in {
        "scenarios/street.toml": SCENARIO + walks(seed),
        "scenarios/worlds/street.xml": WORLD.format("".join(map(PERSON.format, range(PEOPLE)))),
        "planners/missions/ahead.xml": AHEAD,
    }.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    sink = ListSink()
    run("street", Catalog(folder), sinks=[sink], report=False)
    return sink.events


@pytest.mark.parametrize("seed", [4, 8, 9, *(pytest.param(seed, marks=pytest.mark.soak) for seed in range(10, 40))])
def test_a_robot_that_is_driven_towards_people_stops_before_it_drives_into_one(tmp_path: Path, seed: int) -> None:
    """Until the rule first releases the robot: a mission that drives on may be surprised by people that turn."""
    events = street(tmp_path, seed)
    phases = [(e.t, e.phase) for e in events if isinstance(e, RuleChanged) and e.rule.endswith("Yield")]
    assert "fired" in [phase for _, phase in phases]
    released = next((t for t, phase in phases if phase == "released"), math.inf)
    driven = [(e.t, e.other) for e in events if isinstance(e, ContactBegan) and e.kind == "collision"]
    assert [contact for contact in driven if contact[0] <= released + REACTION] == []
