"""Ground that is not level."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog, GroundSpec
from rocs_bt.check import check_scenario
from rocs_bt.declare import replaced
from rocs_bt.devices.mujoco import MujocoWorld
from rocs_bt.event import ListSink
from rocs_bt.simulation import build_world

from .yard import BOOM, SCENARIO, driven

SLOPE = GroundSpec(name="ramp", kind="slope", pose=Pose2(0.0, 0.0), length=2.0, width=1.5, height=0.1)
STEPS = GroundSpec(
    name="steps", kind="step", pose=Pose2(0.0, 1.0, math.pi / 2), length=0.9, width=1.5, height=0.04, count=3
)
GRAVEL = GroundSpec(
    name="gravel", kind="rough", pose=Pose2(0.0, 0.0, 0.3), length=3.0, width=2.0, height=0.03, grain=0.1
)
BLOCK = GroundSpec(name="block", kind="step", pose=Pose2(1.0, 0.0), length=0.4, width=2.0, height=0.3)


def test_a_robot_drives_up_a_slope_which_is_no_obstacle(built) -> None:
    simulated = built(SLOPE)
    level = built().world.pose3("R2").z
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
    renamed = built(replaced(GRAVEL, name="scree")).world
    assert one.model.hfield_data.tobytes() == again.model.hfield_data.tobytes()
    assert not np.array_equal(one.model.hfield_data, other.model.hfield_data)
    assert not np.array_equal(one.model.hfield_data, renamed.model.hfield_data)
    tops = [one.ground_height(x, y) for x in np.linspace(-1.0, 1.0, 60) for y in np.linspace(-0.5, 0.5, 30)]
    assert 0.02 < max(tops) <= 0.03
    assert min(tops) >= 0.0
    assert one.ground_height(2.0, 0.0) == 0.0
    assert one.pose3("R2").z - built().world.pose3("R2").z > 0.015


NARROW = GroundSpec(name="sill", kind="step", pose=Pose2(0.05, 0.0, 0.4), length=0.02, width=2.0, height=0.2)
ROOF = GroundSpec(name="roof", kind="slope", pose=Pose2(-0.1, 0.1, 2.0), length=0.3, width=0.2, height=0.15)
SPIKES = GroundSpec(
    name="spikes", kind="rough", pose=Pose2(0.0, 0.0, 0.7), length=1.0, width=1.0, height=0.1, grain=0.03
)


@pytest.mark.parametrize("ground", [NARROW, ROOF, SPIKES], ids=lambda ground: ground.name)
@pytest.mark.parametrize("yaw", [0.0, 1.0])
def test_a_robot_starts_above_narrow_ground(built, ground, yaw) -> None:
    world = built(ground, at=Pose2(0.0, 0.0, yaw)).world
    mujoco.mj_forward(world.model, world.data)
    assert world.pose3("R2").z > 0.15
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
    simulated = built(replaced(BLOCK, pose=Pose2(0.0, 0.0), length=1.0), at=Pose2(0.0, 0.0))
    world: MujocoWorld = simulated.world
    q = world.robots["R2"].q
    world.data.qpos[q + 2] += 0.3
    world.data.qpos[q + 3 : q + 7] = 0.0, 1.0, 0.0, 0.0  # on its back
    world.advance(300)
    assert world.pose3("R2").z > 0.3
    assert world.ground_contact("R2") == "hull"
    assert world.contacts() == []


@pytest.mark.parametrize("height", [0.3, 1.0])
@pytest.mark.parametrize("kind", ["step", "slope"])
def test_a_robot_that_drives_against_a_side_face_of_the_ground_collides_and_does_not_fall(built, height, kind) -> None:
    block = replaced(BLOCK, kind=kind, height=height, pose=Pose2(1.0, 0.0, math.pi), length=1.4)
    simulated = built(block, at=Pose2(-0.5, 0.0))
    driven(simulated, 3.0)
    contacts = simulated.world.contacts()
    assert [(c.robot, c.other.partition("/")[0], c.driven) for c in contacts] == [("R2", "block", True)]
    assert simulated.world.ground_contact("R2") == ""


def test_a_scenario_with_level_ground_only_is_the_same_as_before(built) -> None:
    plain = built().world
    assert plain.model.nhfield == 0
    assert plain.ground_height(0.0, 0.0) == 0.0


AREA = 'x = "0 m"\ny = "0 m"\nlength = "{0} m"\nwidth = "{0} m"\nheight = "1 cm"\n'


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
