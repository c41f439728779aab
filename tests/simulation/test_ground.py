"""Ground that is not level, pushes, and things that swing."""

from __future__ import annotations

import dataclasses
import math

import mujoco
import numpy as np
import pytest

import rocs_bt
from rocs_bt.catalog import Catalog, GroundSpec, PushSpec
from rocs_bt.catalog.scenario_file import read_scenario
from rocs_bt.check import check_scenario
from rocs_bt.check.feasible import check_feasible
from rocs_bt.document import read_toml
from rocs_bt.drivers.mujoco import MujocoWorld
from rocs_bt.errors import BlockError, InputError
from rocs_bt.event import BodyMoved, ListSink, RobotPushed
from rocs_bt.geometry import Pose2
from rocs_bt.record import Recording
from rocs_bt.simulation import build_world

SLOPE = GroundSpec("ramp", "slope", Pose2(0.0, 0.0), 2.0, 1.5, 0.1)
STEPS = GroundSpec("stairs", "step", Pose2(0.0, 1.0, math.pi / 2), 0.9, 1.5, 0.04, count=3)
GRAVEL = GroundSpec("gravel", "rough", Pose2(0.0, 0.0, 0.3), 3.0, 2.0, 0.03, grain=0.1)
WEST = Pose2(-0.8, 0.0)
BLOCK = GroundSpec("block", "step", Pose2(1.0, 0.0), 0.4, 2.0, 0.3)


@pytest.fixture
def built(exp1, catalog):
    """Build the world of EXP1 without R1, and with other ground."""

    def build(*grounds: GroundSpec, at: Pose2 = WEST, seed: int = 1, sink=None, **changed):
        start = dataclasses.replace(exp1.agents[0], pose=at, jitter=Pose2(0.0, 0.0, 0.0))
        fields = {"agents": (start,), "actors": (), "world": "arena", "grounds": grounds, **changed}
        return build_world(dataclasses.replace(exp1, **fields), catalog, seed, sink or ListSink())

    return build


def driven(simulated, seconds: float, speed: float = 0.3) -> list[float]:
    """Heights of R2's base while it drives ahead [m], one per control period."""
    heights = []
    for _ in range(round(seconds / 0.05)):
        simulated.actuators["R2"]["wheels"].command([speed, speed])
        for actor in simulated.actors:
            actor.step(simulated.clock.now())
        simulated.world.advance(10)
        heights.append(simulated.world.position("R2")[2])
    return heights


def test_a_robot_drives_up_a_slope_which_is_no_obstacle(built) -> None:
    simulated = built(SLOPE)
    level = built().world.position("R2")[2]
    heights, world = driven(simulated, 5.0), simulated.world
    x = world.pose("R2").x
    assert 0.4 < x < 0.8
    assert heights[-1] - level == pytest.approx(0.1 * (x + 1.0) / 2.0, abs=0.012)
    assert world.tilt("R2") == pytest.approx(math.atan(0.05), abs=0.015)
    assert (world.contacts(), world.ground_contact("R2")) == ([], "")
    assert world.clearance("R2", among="obstacles")[1] != "ramp"


@pytest.mark.parametrize(("y", "height"), [(0.7, 0.04), (1.0, 0.08), (1.3, 0.12), (0.3, 0.0), (1.6, 0.0)])
def test_steps_rise_along_their_length(built, y, height) -> None:
    world = built(STEPS, at=Pose2(0.0, -1.5)).world
    assert world.ground_height(0.0, y) == pytest.approx(height, abs=1e-6)


def test_bumps_are_those_of_the_seed_and_the_ground_and_robots_start_above_them(built) -> None:
    one, again, other = (built(GRAVEL, seed=seed).world for seed in (1, 1, 2))
    renamed = built(dataclasses.replace(GRAVEL, name="scree")).world
    assert one.model.hfield_data.tobytes() == again.model.hfield_data.tobytes()
    assert not np.array_equal(one.model.hfield_data, other.model.hfield_data)
    assert not np.array_equal(one.model.hfield_data, renamed.model.hfield_data)
    tops = [one.ground_height(x, y) for x in np.linspace(-1.0, 1.0, 60) for y in np.linspace(-0.5, 0.5, 30)]
    assert 0.02 < max(tops) <= 0.03
    assert min(tops) >= 0.0
    assert one.ground_height(2.0, 0.0) == 0.0
    assert one.position("R2")[2] - built().world.position("R2")[2] > 0.015


NARROW = GroundSpec("sill", "step", Pose2(0.05, 0.0, 0.4), 0.02, 2.0, 0.2)
ROOF = GroundSpec("roof", "slope", Pose2(-0.1, 0.1, 2.0), 0.3, 0.2, 0.15)
SPIKES = GroundSpec("spikes", "rough", Pose2(0.0, 0.0, 0.7), 1.0, 1.0, 0.1, grain=0.03)


@pytest.mark.parametrize("ground", [NARROW, ROOF, SPIKES], ids=lambda ground: ground.name)
@pytest.mark.parametrize("yaw", [0.0, 1.0])
def test_a_robot_starts_above_narrow_ground(built, ground, yaw) -> None:
    world = built(ground, at=Pose2(0.0, 0.0, yaw)).world
    mujoco.mj_forward(world.model, world.data)
    assert world.position("R2")[2] > 0.15
    assert min((contact.dist for contact in world.data.contact), default=0.0) > -1e-3


def test_a_robot_on_rough_ground_neither_collides_nor_falls_and_repeats_bit_by_bit(built) -> None:
    first, second = built(GRAVEL), built(GRAVEL)
    heights = driven(first, 3.0)
    assert heights == driven(second, 3.0)
    assert max(heights) - min(heights) > 0.003
    assert (first.world.contacts(), first.world.ground_contact("R2")) == ([], "")
    assert first.world.pose("R2").x > -0.4


def test_range_sensors_see_ground_that_is_high(built) -> None:
    readings = [
        built(*grounds, at=Pose2(-0.2, 0.0)).sensors["R2"]["sonar"].read().values[3:5] for grounds in ((BLOCK,), ())
    ]
    assert min(readings[0]) < 0.9 < min(readings[1])


def test_a_hull_on_ground_counts_as_on_the_floor(built) -> None:
    simulated = built(dataclasses.replace(BLOCK, pose=Pose2(0.0, 0.0), length=1.0), at=Pose2(0.0, 0.0))
    world: MujocoWorld = simulated.world
    q = world.robots["R2"].q
    world.data.qpos[q + 2] += 0.3
    world.data.qpos[q + 3 : q + 7] = 0.0, 1.0, 0.0, 0.0  # on its back
    world.advance(300)
    assert world.position("R2")[2] > 0.3
    assert world.ground_contact("R2") == "hull"
    assert world.contacts() == []


@pytest.mark.parametrize("height", [0.3, 1.0])
@pytest.mark.parametrize("kind", ["step", "slope"])
def test_a_robot_that_drives_against_a_side_face_of_the_ground_collides_and_does_not_fall(built, height, kind) -> None:
    block = dataclasses.replace(BLOCK, kind=kind, height=height, pose=Pose2(1.0, 0.0, math.pi), length=1.4)
    simulated = built(block, at=Pose2(-0.5, 0.0))
    driven(simulated, 3.0)
    contacts = simulated.world.contacts()
    assert [(c.robot, c.other.partition("/")[0], c.moving) for c in contacts] == [("R2", "block", True)]
    assert simulated.world.ground_contact("R2") == ""


def test_a_scenario_with_level_ground_only_is_the_same_as_before(built) -> None:
    plain = built().world
    assert plain.model.nhfield == 0
    assert plain.ground_height(0.0, 0.0) == 0.0


PUSH = PushSpec("R2", (0.0, 0.0, 30.0), 0.5, 0.5, 0.1)


def test_a_push_is_a_force_on_the_base_for_its_duration(built) -> None:
    push, sink, speeds = dataclasses.replace(PUSH, force=(40.0, 20.0, 60.0), duration=0.02), ListSink(), []
    for pushes in ((push,), ()):
        simulated = built(pushes=pushes, sink=sink, at=Pose2(0.0, 0.0, math.pi / 2))
        world, body = simulated.world, simulated.world.robots["R2"]
        driven(simulated, 0.45, 0.0)
        world.data.qpos[body.q + 2] += 1.0  # in the air
        driven(simulated, 0.1, 0.0)
        speeds.append(np.array(world.data.qvel[body.v : body.v + 3]))
        assert not world.data.xfrc_applied.any()
    mass = float(world.model.body_subtreemass[body.root])
    left, ahead, up = (speeds[0] - speeds[1]) * mass / 0.02 * (-1.0, 1.0, 1.0)
    assert (ahead, left, up) == pytest.approx(push.force, rel=0.15)  # not through the centre of mass
    (event,) = (e for e in sink.events if isinstance(e, RobotPushed))
    assert (event.agent, event.body, event.t) == ("R2", "R2", pytest.approx(0.5))
    assert (event.force, event.duration) == (push.force, 0.02)


@pytest.mark.parametrize("mode", ["lockstep", "threaded"])
def test_an_unstable_simulation_is_an_error(exp1, catalog, tmp_path, monkeypatch, mode) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo writes a log there
    push = PushSpec("R2", (1e5, 0.0, 0.0), 0.2, 0.2, 60.0)
    scenario = dataclasses.replace(exp1, actors=(), pushes=(push,), duration=5.0)
    with pytest.raises(BlockError, match=r"'physics' raised: the simulation became unstable by \d\.\d\d s: ") as caught:
        rocs_bt.run(scenario, catalog, seed=1, mode=mode, out=tmp_path / "run")
    assert str(caught.value).count("physics' raised") == 1
    agent = Recording.open(tmp_path / "run/run.mcap").summary.agents["R2"]
    assert agent.outcome == "error"
    assert "the simulation became unstable" in agent.reason


def test_the_time_of_a_push_is_that_of_the_seed(built) -> None:
    times = []
    for seed in (1, 1, 2, 3):
        sink = ListSink()
        simulated = built(pushes=(dataclasses.replace(PUSH, until=2.5),), sink=sink, seed=seed)
        driven(simulated, 3.0, 0.0)
        times.append(next(e.t for e in sink.events if isinstance(e, RobotPushed)))
    assert times[0] == times[1]
    assert len(set(times)) == 3
    assert all(0.5 <= t <= 2.5 for t in times)


def test_the_direction_of_a_push_is_that_of_the_seed_within_its_spread(built) -> None:
    push, forces = dataclasses.replace(PUSH, force=(0.0, 40.0, 5.0), spread=math.radians(30.0)), []
    for seed in (1, 1, 2, 3):
        sink = ListSink()
        driven(built(pushes=(push,), sink=sink, seed=seed), 0.6, 0.0)
        forces.append(next(e.force for e in sink.events if isinstance(e, RobotPushed)))
    assert forces[0] == forces[1]
    assert len(set(forces)) == 3
    for forward, left, up in forces:
        assert (math.hypot(forward, left), up) == pytest.approx((40.0, 5.0))
        assert abs(math.atan2(-forward, left)) <= math.radians(30.0)


BOOM = """<mujoco><worldbody><geom name="floor" type="plane" size="9 9 0.1"/>
<body name="boom" mocap="true" pos="0 0 0.2"><geom name="beam" type="box" size="0.8 0.05 0.05" pos="0.8 0 0"/></body>
</worldbody></mujoco>"""

SCENARIO = """
format = "scenario/2"
doc = "A boom swings."
world = "yard"
duration = "4 s"
[[agent]]
name = "R2"
robot = "pioneer_p3dx"
mission = "wait"
x = "{x} m"
y = "0 m"
[[actor]]
name = "boom"
script = "swing"
x = "0.5 m"
y = "-1 m"
yaw = "90 deg"
amplitude = "40 deg"
period = "2 s"
"""


@pytest.fixture
def swinging(tmp_path):
    for folder in ("scenarios/worlds", "planners/missions", "rules", "robots"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "scenarios/worlds/yard.xml").write_text(BOOM)
    wait = '<root BTCPP_format="4"><BehaviorTree ID="wait"><Sleep msec="9000"/></BehaviorTree></root>'
    (tmp_path / "planners/missions/wait.xml").write_text(wait)

    def build(x: float, seed: int = 1):
        (tmp_path / "scenarios/swing.toml").write_text(SCENARIO.format(x=x))
        catalog, sink = Catalog(tmp_path), ListSink()
        return build_world(catalog.load_scenario("swing"), catalog, seed, sink), sink

    return build


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
    assert next((c.robot, c.other, c.moving) for c in simulated.world.contacts()) == ("R2", "beam", False)


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
    assert [(c.other, c.moving) for c in world.contacts()][:1] == [("crate", True)]
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
    assert list(check_feasible(catalog.load_scenario("crate"), catalog)) == []


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
    ("change", "fault"),
    [
        (('name = "crate"', 'name = "crates"'), "Did you mean 'crate'"),
        (('name = "crate"', 'name = "crate"\none_of = "boxes"'), "Remove one_of"),
        (('name = "crate"', 'name = "crate"\nrobot = "pioneer_p3dx"'), "script is named 'free'"),
        (('mass = "2.0 kg"', ""), "mass"),
        (("</body>", '<inertial pos="0 0 0" mass="7" diaginertia="1 1 1"/></body>'), "has an <inertial>"),
        (('size="0.15 0.3 0.15"', 'size="1 1 1" contype="0" conaffinity="0"'), "has no geom that collides"),
    ],
)
def test_faults_of_free_objects_name_their_line(pushing, tmp_path, change, fault) -> None:
    pushing()
    for file in (tmp_path / "scenarios/crate.toml", tmp_path / "scenarios/worlds/store.xml"):
        file.write_text(file.read_text().replace(*change))
    catalog = Catalog(tmp_path)
    with pytest.raises(InputError, match=fault) as caught:
        build_world(catalog.load_scenario("crate"), catalog, 1, ListSink())
    (found,) = caught.value.faults
    assert found.file == tmp_path / "scenarios/crate.toml"
    assert found.line == 13


AREA = 'x = "0 m"\ny = "0 m"\nlength = "{0} m"\nwidth = "{0} m"\nheight = "1 cm"\n'


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (f'[[ground]]\nname = "a"\nkind = "mud"\n{AREA.format(1)}', "mud"),
        (f'[[ground]]\nname = "a"\nkind = "slope"\n{AREA.format(1)}count = 2', "'slope' has no 'count'"),
        (f'[[ground]]\nname = "a"\nkind = "rough"\n{AREA.format(99)}grain = "1 cm"', "the maximum is 250000"),
        (f'[[ground]]\nname = "a"\nkind = "rough"\n{AREA.format(1)}grain = "0 m"', "grain must be between 0.005"),
        (f'[[ground]]\nname = "a/1"\nkind = "rough"\n{AREA.format(1)}', "contains '/'"),
        (f'[[ground]]\nname = "a"\nkind = "step"\n{AREA.format(99)}count = 101', "count must be at most 100"),
        (f'[[ground]]\nname = "a"\nkind = "step"\n{AREA.format(99)}count = 0', "count must be at least 1"),
        (f'[[ground]]\nname = "a"\nkind = "step"\n{AREA.format(99)}count = "2"', "count must be a whole number"),
        (f'[[ground]]\nname = "a"\nkind = "step"\n{AREA.format(0.1)}count = 20', "steps are 5 mm long"),
        (f'[[ground]]\nname = "a"\nkind = "step"\n{AREA.format(9).replace("cm", "m")}count = 11', "rise to 11 m"),
        ('[[push]]\nrobot = "R9"\nat = "1 s"\nforce = { left = "9 N" }', "no agent or robot is named 'R9'"),
        ('[[push]]\nrobot = "R2"\nat = "2 s"\nuntil = "1 s"\nforce = { left = "9 N" }', "is before its earliest"),
        ('[[push]]\nrobot = "R2"\nat = "2 s"\nforce = { }', "has no force"),
        ('[[place]]\nname = "p"\nx = "0 m"\ny = "0 m"\nheight_tolerance = "1 m"', "without z has no height"),
    ],
)
def test_faults_of_ground_and_pushes_name_their_line(text, fault, tmp_path) -> None:
    file = tmp_path / "s.toml"
    file.write_text(SCENARIO.format(x=0) + text)
    with pytest.raises(InputError, match=fault) as caught:
        read_scenario(read_toml(file))
    assert caught.value.faults[0].line >= 20
    assert len(caught.value.faults) == 1


def test_ground_with_the_name_of_a_geom_of_the_world_is_a_fault(swinging, tmp_path) -> None:
    swinging(-3.0)
    world = tmp_path / "scenarios/worlds/yard.xml"
    world.write_text(BOOM.replace("<body", '<geom name="floor/a" size="0.1"/><body', 1))
    ground = f'[[ground]]\nname = "a"\nkind = "slope"\n{AREA.format(1)}'
    (tmp_path / "scenarios/swing.toml").write_text(SCENARIO.format(x=-3.0) + ground)
    catalog = Catalog(tmp_path)
    with pytest.raises(InputError, match=r"yard\.xml: the scenario's ground cannot be added to the world: .*'floor/a'"):
        build_world(catalog.load_scenario("swing"), catalog, 1, ListSink())


def warnings(catalog: Catalog) -> list[str]:
    """Warnings of the check of the scenario `swing`."""
    return [str(fault) for fault in check_scenario("swing", catalog).warnings]


def test_ground_outside_of_the_world_does_not_extend_it(swinging, tmp_path) -> None:
    swinging(-3.0)
    file = tmp_path / "scenarios/swing.toml"
    ground = f'[[ground]]\nname = "far"\nkind = "step"\n{AREA.format(2)}'.replace('x = "0 m"', 'x = "50 m"')
    place = '[[place]]\nname = "p"\nkind = "place"\nx = "50 m"\ny = "0 m"\n'
    file.write_text(SCENARIO.format(x=-3.0) + place + ground)
    found = warnings(Catalog(tmp_path))
    assert len(found) == 2
    assert "swing.toml:20: warning: the place 'p' at x = 50 m, y = 0 m is outside of the world" in found[0]
    assert "swing.toml:25: warning: the ground 'far' at x = 50 m" in found[1]


@pytest.mark.parametrize(
    ("times", "fault"),
    [
        ('at = "4 s"', "the push of R2 at 4 s does not happen: the run ends at 4 s."),
        ('at = "3 s"\nuntil = "5 s"', "the push of R2 from 3 s to 5 s may not happen"),
        ('at = "3 s"\nuntil = "3.9 s"', ""),
    ],
)
def test_a_push_after_the_end_of_the_run_is_a_warning_at_its_line(swinging, tmp_path, times, fault) -> None:
    swinging(-3.0)
    push = f'[[push]]\nrobot = "R2"\nforce = {{ left = "9 N" }}\n{times}\n'
    (tmp_path / "scenarios/swing.toml").write_text(SCENARIO.format(x=-3.0) + push)
    catalog = Catalog(tmp_path)
    found = warnings(catalog)
    assert len(found) == bool(fault)
    assert all(f"swing.toml:20: warning: {fault}" in each for each in found)
