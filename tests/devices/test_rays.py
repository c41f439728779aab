"""Rays: in a model sorted by tiles they meet what MuJoCo's own rays meet, to the bit, but not the robot itself."""

import math

import mujoco
import numpy as np
import pytest

from rocs_bt.devices.mujoco.rays import MANY, Rays

BEARINGS = np.linspace(-math.pi, math.pi, 500, endpoint=False)

SHAPES = (
    'type="cylinder" size=".08 .5"',
    'type="box" size=".1 .2 .4" euler="0 0 30"',
    'type="sphere" size=".3"',
    'type="capsule" size=".1 .3" euler="80 0 10"',
    'type="ellipsoid" size=".1 .2 .4" rgba="1 1 1 0"',
    'type="box" size=".1 .1 .1" material="glass"',
)


def world(rng, things, extra=""):
    """Things on a floor, two bodies that move, one of them with a part that turns on it, and one that is carried."""
    away, bearing = rng.uniform(4.0, 6.5, things), rng.uniform(-math.pi, math.pi, things)
    places = np.stack([away * np.cos(bearing), away * np.sin(bearing)], axis=1)
    geoms = "".join(f'<geom {SHAPES[i % len(SHAPES)]} pos="{x} {y} .3"/>' for i, (x, y) in enumerate(places))
    model = mujoco.MjModel.from_xml_string(f"""
        <mujoco>
          <asset>
            <material name="glass" rgba="1 1 1 0"/>
            <mesh name="pyramid" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>
          </asset>
          <worldbody>
            <geom type="plane" size="9 9 .1" euler="0 2 0"/>
            {geoms}{extra}
            <body name="eye" pos="0 0 .3"><freejoint/><geom size=".2"/><geom type="box" size=".4 .1 .1" pos=".1 0 0"/>
              <body pos=".5 0 0"><joint axis="0 0 1"/><geom type="box" size=".02 .1 .4" pos=".1 .2 0"/></body></body>
            <body pos="3 0 .3"><freejoint/><geom type="box" size=".3 .2 .3" pos=".2 .1 0"/><geom size=".2"/></body>
            <body mocap="true" pos="0 2 .3"><geom type="cylinder" size=".2 .4"/></body>
          </worldbody>
        </mujoco>""")
    return model, mujoco.MjData(model)


@pytest.mark.parametrize("things", [4, MANY, 300])
@pytest.mark.parametrize("extra", ["", '<geom type="mesh" mesh="pyramid" pos="1 1 0"/>'], ids=["plain", "mesh"])
def test_rays_meet_what_mujoco_says_wherever_everything_has_moved_to(things, extra):
    rng, met = np.random.default_rng(things), set()
    model, data = world(rng, things, extra)
    eye = model.body("eye").id
    part = eye + 1  # of the robot that carries the scanner, which is no echo
    rays = Rays(model, eye)
    for _ in range(8):
        data.qpos[:] = model.qpos0 + rng.normal(0.0, 0.1, model.nq)
        data.mocap_pos[:, :2] = rng.uniform(-3.0, 3.0, 2)
        mujoco.mj_kinematics(model, data)
        slope = np.full_like(BEARINGS, rng.uniform(-0.1, 0.1))
        directions = np.stack([np.cos(BEARINGS), np.sin(BEARINGS), slope], axis=1) / math.hypot(1.0, slope[0])
        wanted, hit = np.empty(len(BEARINGS)), np.empty(len(BEARINGS), np.int32)
        how = None, True, eye, hit, wanted, None, len(wanted), 7.0
        mujoco.mj_multiRay(model, data, data.xpos[eye], directions.ravel(), *how)
        bodies = np.where(hit >= 0, model.geom_bodyid[hit], -1)
        wanted[bodies == part] = -1.0
        assert rays.distances(data, data.xpos[eye], directions, 7.0).tolist() == wanted.tolist()
        met |= set(bodies.tolist())
    assert met == {-1, 0, *range(model.nbody)} - {eye}  # all but the body of the scanner; one is a part of its robot


def test_a_scanner_on_a_body_that_nobody_sees_looks_from_there():
    model, data = world(np.random.default_rng(1), MANY)
    model.geom_rgba[model.geom_bodyid == model.body("eye").id, 3] = 0.0
    mujoco.mj_kinematics(model, data)
    ahead = np.array([[1.0, 0.0, 0.0]])
    assert Rays(model, model.body("eye").id).distances(data, np.array([0.0, 0.0, 0.3]), ahead, 7.0)[0] == pytest.approx(
        2.8
    )
