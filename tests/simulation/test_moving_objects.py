"""Booms that swing, and objects that robots push."""

from __future__ import annotations

import math

import mujoco
import pytest

import rocs_bt
from rocs_bt.base.errors import InputError
from rocs_bt.catalog import Catalog
from rocs_bt.check import check_scenario
from rocs_bt.event import BodyMoved, ListSink
from rocs_bt.record import Recording
from rocs_bt.simulation import build_world

from .yard import BOOM, SCENARIO, driven


def yaws(simulated, seconds: float) -> list[float]:
    found = []
    for _ in range(round(seconds / 0.05)):
        for actor in simulated.actors:
            actor.step(simulated.clock.now())
        simulated.world.advance(10)
        found.append(simulated.world.object_pose("boom").yaw)
    return found


def test_a_boom_swings_periodically_with_the_phase_of_the_seed(swinging) -> None:
    simulated, _ = swinging(-3.0)
    found = yaws(simulated, 4.0)
    middle, amplitude = math.pi / 2, math.radians(40.0)
    assert max(found) == pytest.approx(middle + amplitude, abs=0.02)
    assert min(found) == pytest.approx(middle - amplitude, abs=0.02)
    assert found[:40] == pytest.approx(found[40:], abs=1e-6)
    pose = simulated.world.object_pose("boom")
    assert (pose.x, pose.y) == (0.5, -1.0)
    assert yaws(swinging(-3.0)[0], 1.0) == found[:20]
    assert yaws(swinging(-3.0, seed=2)[0], 1.0) != found[:20]


def test_only_the_selected_boom_of_a_group_has_a_phase(swinging, tmp_path) -> None:
    swinging(-3.0)
    world = tmp_path / "scenarios/worlds/yard.xml"
    boom = BOOM[BOOM.index("<body") : BOOM.index("</worldbody>")]
    world.write_text(BOOM.replace(boom, boom + boom.replace("boom", "gate").replace("beam", "bar")))
    actor = SCENARIO[SCENARIO.index("[[actor]]") :].replace("script", 'one_of = "barriers"\nscript')
    text = SCENARIO.partition("[[actor]]")[0] + actor + actor.replace('"boom"', '"gate"').replace("0.5 m", "-6 m")
    (tmp_path / "scenarios/swing.toml").write_text(text.format(x=-3.0))
    catalog = Catalog(tmp_path)
    simulated = build_world(catalog.load_scenario("swing"), catalog, 1, ListSink())
    (moving,) = (actor.name for actor in simulated.actors)
    turned = {name: abs(simulated.world.object_pose(name).yaw - math.pi / 2) for name in ("boom", "gate")}
    assert turned.pop(moving) > 0.05
    assert list(turned.values()) == [pytest.approx(0.0)]


def test_a_boom_that_hits_a_robot_is_a_contact(swinging) -> None:
    simulated, _ = swinging(1.5, seed=6)
    yaws(simulated, 2.0)
    assert next((c.robot, c.other, c.driven) for c in simulated.world.contacts()) == ("R2", "beam", False)


CRATE = """<mujoco><worldbody><geom name="floor" type="plane" size="9 9 0.1"/>
<body name="crate" mocap="true" pos="0 0 0.15"><geom name="crate" type="box" size="0.15 0.3 0.15"/></body>
</worldbody></mujoco>"""

FREE_CRATE = """
[[actor]]
name = "crate"
script = "free"
x = "0.7 m"
y = "0 m"
yaw = "{yaw} deg"
mass = "{mass} kg"
"""


GROUND_TEXT = """
[[ground]]
name = "block"
kind = "step"
x = "{} m"
y = "{} m"
length = "0.2 m"
width = "0.2 m"
height = "0.3 m"
"""


@pytest.fixture
def pushing(swinging, tmp_path):
    def build(mass: float = 2.0, yaw: float = 0.0, body: str = "", more: str = ""):
        text = SCENARIO.format(x=0).partition("[[actor]]")[0] + FREE_CRATE.format(mass=mass, yaw=yaw) + more
        (tmp_path / "scenarios/crate.toml").write_text(text.replace("yard", "store"))
        (tmp_path / "scenarios/worlds/store.xml").write_text(CRATE.replace("</body>", f"{body}</body>"))
        catalog = Catalog(tmp_path)
        return build_world(catalog.load_scenario("crate"), catalog, 1, ListSink())

    return build


def test_a_robot_pushes_a_free_object_which_is_a_contact_and_comes_to_rest(pushing) -> None:
    simulated = pushing()
    world, start = simulated.world, simulated.world.object_pose("crate")
    assert start == pytest.approx((0.7, 0.0, 0.0), abs=1e-9)
    assert not world.only_robots_move
    driven(simulated, 4.0)
    pushed = world.object_pose("crate")
    assert pushed.x > 0.9
    assert [(c.other, c.driven) for c in world.contacts()][:1] == [("crate", True)]
    assert world.clearance("R2", among="obstacles")[1] == "crate"
    driven(simulated, 1.0, 0.0)
    rest = world.object_pose("crate")
    world.advance(100)
    assert world.object_pose("crate") == pytest.approx(rest, abs=1e-3)


CHILD = '<body pos="0.4 0 0"><geom type="box" size="0.15 0.3 0.15"/></body>'


@pytest.mark.parametrize(
    ("body", "at", "height"),
    [("", (0.9, 0.2), 0.3), ("", (1.1, 0.2), 0.0), ("", (0.7, 0.4), 0.0), (CHILD, (0.7, 0.4), 0.3)],
    ids=["half on it", "beside it", "turned beside it", "its child on it"],
)
def test_a_free_object_starts_above_the_ground_below_its_footprint(pushing, tmp_path, body, at, height) -> None:
    yaw = 90.0 if at[0] < 0.8 else 0.0
    ground = GROUND_TEXT.format(*at)
    world = pushing(yaw=yaw, body=body, more=ground).world
    assert world.data.qpos[world.objects["crate"].q + 2] == pytest.approx(0.15 + height)
    world.advance(1)
    assert all(contact.dist > -1e-3 for contact in world.data.contact)


def test_a_heavy_object_stops_a_robot(pushing) -> None:
    simulated = pushing(mass=500.0, yaw=90.0)
    driven(simulated, 4.0)
    assert simulated.world.object_pose("crate").x < 0.75
    assert simulated.world.pose("R2").x < 0.3


def test_a_free_object_is_recorded_where_physics_moved_it(pushing, tmp_path) -> None:
    pushing()
    moving = '<root BTCPP_format="4"><BehaviorTree ID="wait"><SetWheelSpeed speeds="0.3 m/s; 0.3 m/s" duration="4 s"/>'
    (tmp_path / "planners/missions/wait.xml").write_text(f"{moving}</BehaviorTree></root>")
    run = rocs_bt.run("crate", Catalog(tmp_path), seed=1, out=tmp_path / "run")
    recording = Recording.open(run.recording)
    crate = [e for e in recording.events() if isinstance(e, BodyMoved) and e.body == "crate"]
    assert crate[0].x == pytest.approx(0.7)
    assert crate[-1].x > 0.8
    assert "crate" in [body.name for body in recording.header.bodies]
    assert run.summary.agents["R2"].contacts["collision"] == {"crate": 1}


def test_a_check_puts_objects_at_their_starts(pushing, tmp_path) -> None:
    pushing()  # in the world's file, the crate is where the robot starts
    catalog = Catalog(tmp_path)
    assert check_scenario("crate", catalog).faults == ()


VISUAL = '<geom name="lid" size="0.3" pos="0 0 0.6" contype="0" conaffinity="0"/>'
SMALL = '<geom name="small" type="box" size="0.15 0.3 0.05" pos="0 0 0.2" mass="9"/>'


@pytest.mark.parametrize(
    ("body", "centre"),
    [
        ("", 0.0),
        (VISUAL, 0.0),
        (SMALL, 0.05),
        (f'<body pos="0 0 0.2">{SMALL.replace("0 0 0.2", "0 0 0")}</body>', 0.05),
    ],
    ids=["one geom", "with a visual geom", "two geoms", "with a child"],
)
def test_the_mass_of_a_free_object_is_shared_by_volume(pushing, body, centre) -> None:
    world = pushing(body=body).world
    root = world.model.body("crate").id
    assert world.model.body_subtreemass[root] == pytest.approx(2.0)
    mujoco.mj_forward(world.model, world.data)
    assert world.data.subtree_com[root, 2] - world.data.xpos[root, 2] == pytest.approx(centre)


@pytest.mark.parametrize(
    ("change", "fault", "at"),
    [
        (('name = "crate"', 'name = "crates"'), "Did you mean 'crate'", "[[actor]]"),
        (('name = "crate"', 'name = "crate"\none_of = "boxes"'), "Remove one_of", "[[actor]]"),
        (('name = "crate"', 'name = "crate"\nrobot = "pioneer_p3dx"'), "script is named 'free'", "script = "),
        (('mass = "2.0 kg"', ""), "mass", "[[actor]]"),
        (("</body>", '<inertial pos="0 0 0" mass="7" diaginertia="1 1 1"/></body>'), "has an <inertial>", "[[actor]]"),
        (
            ('size="0.15 0.3 0.15"', 'size="1 1 1" contype="0" conaffinity="0"'),
            "has no geom that collides",
            "[[actor]]",
        ),
    ],
)
def test_faults_of_free_objects_name_their_line(pushing, tmp_path, change, fault, at) -> None:
    pushing()
    for file in (tmp_path / "scenarios/crate.toml", tmp_path / "scenarios/worlds/store.xml"):
        file.write_text(file.read_text().replace(*change))
    catalog = Catalog(tmp_path)
    with pytest.raises(InputError, match=fault) as caught:
        build_world(catalog.load_scenario("crate"), catalog, 1, ListSink())
    (found,) = caught.value.faults
    assert found.file == tmp_path / "scenarios/crate.toml"
    lines = found.file.read_text().split("\n")
    assert lines[found.line - 1].startswith(at)
