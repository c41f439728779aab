"""A robot that falls, and one that is upright again in time."""

from __future__ import annotations

import math

import pytest

from rocs_bt.base.errors import UnknownName
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import load_robot
from rocs_bt.declare import replaced
from rocs_bt.devices.mujoco import MujocoWorld, RobotInstance, compose_world
from rocs_bt.event import ListSink, OutcomeDecided
from rocs_bt.running import RunLoop, SimulatedStage
from rocs_bt.simulation import build_world
from rocs_bt.simulation.fall import FallWatch

TOWER = """<mujoco model="tower">
  <worldbody>
    <body name="base" pos="0 0 0.1">
      <freejoint name="base"/>
      <geom name="hull" type="box" size="0.1 0.1 0.4" pos="0 0 0.45" mass="5"/>
      <geom name="skid" type="box" size="0.1 0.1 0.05" pos="0 0 -0.05" mass="1"/>
      <body name="leg" pos="0.2 0 0.1">
        <joint name="leg" type="hinge" axis="0 1 0"/>
        <geom name="thigh" type="capsule" fromto="0 0 0 0 0 -0.1" size="0.02" mass="0.1"/>
        <body name="shin" pos="0 0 -0.1">
          <joint name="knee" type="hinge" axis="0 1 0"/>
          <geom name="foot" type="sphere" size="0.02" pos="0 0 -0.08" mass="0.1"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>"""
SHIPPED = ["pioneer_p3dx", "jackal", "summit_xl", "rosbot_xl", "robotino", "turtlebot3_burger"]


def watched(samples, period: float = 0.05) -> tuple[float | None, str]:
    """Time at which a watch finds a fall, and its reason at the end; samples are (duration, tilt, geom)."""
    watch, k, fallen = FallWatch(), 0, None
    for duration, tilt, ground in samples:
        for _ in range(round(duration / period)):
            if watch.update(k * period, tilt, ground) and fallen is None:
                fallen = k * period
            k += 1
    return fallen, watch.reason


@pytest.mark.parametrize(
    ("samples", "fallen", "reason"),
    [
        ([(1.0, 0.0, ""), (9.0, 1.1, "")], 6.0, "it tilted by more than 60 deg at 1.00 s"),
        ([(1.0, 0.0, ""), (9.0, 0.0, "hull")], 6.5, "its hull touched the ground from 1.00 s on"),
        ([(1.0, 0.0, ""), (9.0, 1.0, "")], None, ""),
        ([(1.0, 0.0, ""), (0.45, 0.0, "hull"), (9.0, 0.0, "")], None, ""),
        ([(1.0, 0.0, ""), (4.9, 1.1, ""), (9.0, 0.0, "")], None, ""),
        ([(1.0, 0.0, ""), (5.2, 0.0, "hull"), (9.0, 0.0, "")], None, ""),
        (
            [(1.0, 0.0, ""), (4.0, 1.1, ""), (1.0, 0.0, ""), (4.0, 1.1, "")],
            None,
            "it tilted by more than 60 deg at 6.00 s",
        ),
        (
            [(1.0, 0.0, ""), *([(0.1, 0.0, "hull"), (0.1, 0.0, "")] * 40)],
            6.5,
            "its hull touched the ground from 1.00 s on",
        ),
        ([(1.0, 2.0, "hull"), (9.0, 0.5, "hull")], 5.0, "it tilted by more than 60 deg at 0.00 s"),
    ],
    ids=["tilt", "contact", "60 deg", "touch", "rights", "lifts", "twice", "rattles", "tilt then contact"],
)
def test_a_fall_is_five_seconds_down(samples, fallen, reason) -> None:
    found, why = watched(samples)
    assert found == (None if fallen is None else pytest.approx(fallen, abs=1e-6))
    assert why == reason


def world_of(tmp_path, model: str = TOWER) -> MujocoWorld:
    (tmp_path / "robot.xml").write_text(model)
    arena = tmp_path / "arena.xml"
    arena.write_text('<mujoco><worldbody><geom name="floor" type="plane" size="9 9 0.1"/></worldbody></mujoco>')
    return compose_world(arena, [RobotInstance("T", tmp_path / "robot.xml")], step=0.005)


def test_a_tower_that_is_pushed_over_lies_on_its_hull(tmp_path) -> None:
    world = world_of(tmp_path)
    world.advance(100)
    assert (world.tilt("T"), world.ground_contact("T")) == (pytest.approx(0.0, abs=0.02), "")
    world.data.qvel[3] = 3.0  # a push sideways
    world.advance(300)
    assert (world.tilt("T"), world.ground_contact("T")) == (pytest.approx(math.pi / 2, abs=0.1), "hull")
    assert world.contacts() == []  # the floor is no obstacle


def test_a_robot_is_carried_by_its_lowest_parts_and_their_whole_limbs_but_not_by_its_hull(tmp_path) -> None:
    low = TOWER.replace('size="0.1 0.1 0.4" pos="0 0 0.45"', 'size="0.3 0.3 0.1" pos="0 0 -0.12"')
    world = world_of(tmp_path, low.replace('name="base" pos="0 0 0.1"', 'name="base" pos="0 0 0.22"'))
    world.advance(20)  # the hull is lower than the skid and the foot
    assert world.ground_contact("T") == "hull"
    world.allow_ground_contact("T", ["hull", "foot", "thigh"])
    world.advance(10)
    assert world.ground_contact("T") == ""
    plate = world_of(tmp_path, low.replace('name="hull"', 'name="plate"').replace('pos="0 0 0.1"', 'pos="0 0 0.22"'))
    plate.advance(20)
    assert plate.ground_contact("T") == ""
    with pytest.raises(UnknownName, match="Did you mean 'foot'"):
        world.allow_ground_contact("T", ["foto"])


@pytest.mark.parametrize("name", SHIPPED)
def test_wheels_rollers_and_casters_carry_the_shipped_robots(name, catalog, tmp_path) -> None:
    robot = load_robot(catalog.find("robot", name).path)
    arena = tmp_path / "arena.xml"
    arena.write_text('<mujoco><worldbody><geom name="floor" type="plane" size="9 9 0.1"/></worldbody></mujoco>')
    world = compose_world(arena, [RobotInstance("R", robot.model)], step=0.005)
    world.data.ctrl[:] = 6.0  # all wheels turn [rad/s]
    for k in range(40):
        world.advance(10)
        assert world.ground_contact("R") == "", k
    q = world.robots["R"].q
    world.data.qpos[q + 2] = 0.6
    world.data.qpos[q + 3 : q + 7] = 0.0, 1.0, 0.0, 0.0  # on its back
    world.advance(300)
    assert world.ground_contact("R")
    assert world.tilt("R") > math.radians(60.0)


def tipped(stage, seconds: float):
    """Tip R2 over at 1 s, and put it on its wheels again after some seconds."""
    q = stage.world.robots["R2"].q

    def change(mind, t: float) -> bool:
        with stage.world.lock:
            if abs(t - 1.0) < 1e-6:
                stage.world.data.qpos[q + 2] += 0.3
                stage.world.data.qpos[q + 3 : q + 7] = math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0
            if abs(t - 1.0 - seconds) < 1e-6:
                stage.world.place("R2", Pose2(0.0, -1.5, 0.0))
        return True

    return change


@pytest.mark.parametrize(
    ("seconds", "outcome", "end"), [(4.0, "timeout", 9.0), (8.0, "fell", 6.2), (2.0, "failed", 4.0)]
)
def test_a_robot_that_is_upright_again_within_five_seconds_has_not_fallen(
    exp1, make_mind, catalog, seconds, outcome, end
) -> None:
    start = replaced(exp1.agents[0], pose=Pose2(0.0, -1.5, 0.0), jitter=Pose2(0.0, 0.0, 0.0))
    scenario, sink = replaced(exp1, agents=(start,), actors=()), ListSink()
    stage = build_world(scenario, catalog, 1, sink)
    mind = make_mind("R2", stage, lambda t: (0.0, 0.0))
    change = tipped(stage, seconds)

    def watch(t: float) -> bool:
        if outcome == "failed" and t > 3.9:
            mind.status = "FAILURE"
        return change(mind, t)

    place = SimulatedStage(stage, [mind], sink, control=scenario.rate.control_rate)
    result = RunLoop(place, [mind], sink, duration=9.0, between=watch).run()
    assert result.verdicts["R2"].outcome == outcome
    assert result.sim_time == pytest.approx(end, abs=0.3)
    (decided,) = (e for e in sink.events if isinstance(e, OutcomeDecided))
    assert (decided.outcome, decided.fell) == (outcome, outcome == "fell")
    if outcome == "fell":
        assert decided.reason.startswith("it tilted by more than 60 deg at 1.")
    assert mind.stopped == 1
