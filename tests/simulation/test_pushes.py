"""Pushes: their force, time and direction."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rocs_bt
from rocs_bt.base.errors import BlockError
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import PushSpec
from rocs_bt.declare import replaced
from rocs_bt.event import ListSink, RobotPushed
from rocs_bt.record import Recording

from .yard import driven

PUSH = PushSpec(robot="R2", force=(0.0, 0.0, 30.0), at=0.5, duration=0.1)


def test_a_push_is_a_force_on_the_base_for_its_duration(built) -> None:
    push, sink, speeds = replaced(PUSH, force=(40.0, 20.0, 60.0), duration=0.02), ListSink(), []
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
    monkeypatch.chdir(tmp_path)
    push = PushSpec(robot="R2", force=(1e5, 0.0, 0.0), at=0.2, duration=60.0)
    scenario = replaced(exp1, actors=(), pushes=(push,), duration=5.0)
    with pytest.raises(BlockError, match=r"'physics' raised: the simulation became unstable by \d\.\d\d s: ") as caught:
        rocs_bt.run(scenario, catalog, seed=1, mode=mode, out=tmp_path / "run")
    assert str(caught.value).count("physics' raised") == 1
    agent = Recording.open(tmp_path / "run/run.mcap").summary.agents["R2"]
    assert agent.outcome == "error"
    assert "the simulation became unstable" in agent.reason
    assert not (tmp_path / "MUJOCO_LOG.TXT").exists()  # MuJoCo's own log


def test_the_time_of_a_push_is_that_of_the_seed(built) -> None:
    times = []
    for seed in (1, 1, 2, 3):
        sink = ListSink()
        simulated = built(pushes=(replaced(PUSH, until=2.5),), sink=sink, seed=seed)
        driven(simulated, 3.0, 0.0)
        times.append(next(e.t for e in sink.events if isinstance(e, RobotPushed)))
    assert times[0] == times[1]
    assert len(set(times)) == 3
    assert all(0.5 <= t <= 2.5 for t in times)


def test_the_direction_of_a_push_is_that_of_the_seed_within_its_spread(built) -> None:
    push, forces = replaced(PUSH, force=(0.0, 40.0, 5.0), spread=math.radians(30.0)), []
    for seed in (1, 1, 2, 3):
        sink = ListSink()
        driven(built(pushes=(push,), sink=sink, seed=seed), 0.6, 0.0)
        forces.append(next(e.force for e in sink.events if isinstance(e, RobotPushed)))
    assert forces[0] == forces[1]
    assert len(set(forces)) == 3
    for forward, left, up in forces:
        assert (math.hypot(forward, left), up) == pytest.approx((40.0, 5.0))
        assert abs(math.atan2(-forward, left)) <= math.radians(30.0)
