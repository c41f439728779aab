"""Shapes, links and joints of a header place every geom where MuJoCo has it, in any posture of any shipped robot."""

import mujoco
import numpy as np
import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.event import NullSink
from rocs_bt.simulation.body_shapes import RobotShapes, object_shapes
from rocs_bt.simulation.simulated_world import build_world

SCENARIOS = ["exp1", "exp1_quadruped", "exp1_quadrotor", "exp1_humanoid", "exp1_mecanum", "pass_person", "exp3"]


def matrix(position, quaternion):
    turn, found = np.zeros(9), np.eye(4)
    mujoco.mju_quat2Mat(turn, np.array(quaternion, float))
    found[:3, :3], found[:3, 3] = turn.reshape(3, 3), position
    return found


def moved(link, value):
    if not link.turns:
        return matrix(np.array(link.axis) * value, (1, 0, 0, 0))
    return matrix((0, 0, 0), (np.cos(value / 2), *(np.array(link.axis) * np.sin(value / 2))))


@pytest.fixture(scope="module", params=SCENARIOS)
def world(request):
    catalog = Catalog()
    return build_world(catalog.load_scenario(request.param), catalog, 3, NullSink()).world


def test_each_shape_is_where_its_geom_is(world):
    rng, model, data = np.random.default_rng(1), world.model, world.data
    for name, body in world.robots.items():
        drawn = RobotShapes(world, name)
        data.qpos[drawn.addresses] = rng.uniform(-1.0, 1.0, len(drawn.addresses))
        data.qpos[body.q : body.q + 7] = [*rng.normal(size=3), *(q := rng.normal(size=4)) / np.linalg.norm(q)]
        mujoco.mj_kinematics(model, data)
        frames = [matrix(data.xpos[body.root], data.xquat[body.root])]
        for link, address in zip(drawn.links, drawn.addresses, strict=True):
            at = matrix(link.position, link.quaternion) @ moved(link, data.qpos[address])
            frames.append(frames[link.parent] @ at)
        geoms = [g for g in body.geoms if model.geom_group[g] < 3] or body.hull
        assert len(drawn.shapes) == len(geoms) > 0
        carried = {int(b) for b in model.jnt_bodyid[model.actuator_trnid[model.actuator_trntype == 0, 0]]}
        for shape, geom in zip(drawn.shapes, geoms, strict=True):
            if not _rigid(model, int(model.geom_bodyid[geom]), body.root, carried):
                continue  # on a passive joint, which is not recorded
            at = frames[shape.link] @ matrix(shape.position, shape.quaternion)
            assert np.allclose(at[:3, 3], data.geom_xpos[geom], atol=2e-3), (name, model.geom(geom).name)
            assert np.allclose(at[:3, :3], data.geom_xmat[geom].reshape(3, 3), atol=2e-3)
            assert np.allclose(shape.size, model.geom_size[geom], atol=1e-3)


def _rigid(model, body, root, carried):
    while body != root:
        if model.body_jntnum[body] and body not in carried:
            return False
        body = int(model.body_parentid[body])
    return True


def test_each_shape_of_an_object_is_where_its_geom_is(world):
    for name, found in world.objects.items():
        shapes, base = object_shapes(world, name)
        root = int(world.model.geom_bodyid[found.geoms[0]])
        assert base == pytest.approx(world.data.xpos[root][2], abs=1e-3)
        frame = matrix(world.data.xpos[root], world.data.xquat[root])
        for shape, geom in zip(shapes, getattr(found, "tree", found.geoms), strict=True):
            at = (frame @ matrix(shape.position, shape.quaternion))[:3, 3]
            assert np.allclose(at, world.data.geom_xpos[geom], atol=2e-3)
