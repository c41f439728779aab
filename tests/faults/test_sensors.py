"""A sensor that dies, freezes or lies, in lockstep: the wheels stop or the reflex still works, and the run says so."""

import math
from unittest.mock import Mock

import pytest

from rocs_bt.base.errors import DeviceError, InputError
from rocs_bt.catalog import Catalog
from rocs_bt.event import NullSink, RuleChanged
from rocs_bt.simulation import build_world
from rocs_bt.testing.faults import DeadSensor, FrozenSensor, LyingSensor, break_sensor

FAULTS = {
    "dead": (DeadSensor, {}),
    "frozen": (FrozenSensor, {}),
    "frozen with fresh stamps": (FrozenSensor, {"fresh": True}),
    "NaN": (LyingSensor, {"value": math.nan}),
    "inf": (LyingSensor, {"value": math.inf}),
    "-inf": (LyingSensor, {"value": -math.inf}),
    "huge": (LyingSensor, {"value": 1e12}),
    "-huge": (LyingSensor, {"value": -1e12}),
}
AT = 4.0  # [s] close to the box, and driving


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("sensor", ["sonar", "position", "orientation"])
def test_a_robot_that_lost_a_sensor_it_needs_stands_still(sensor, fault, broken):
    kind, how = FAULTS[fault]
    run = broken(lambda stage: break_sensor(stage, sensor, kind, at=AT, **how))
    assert run.touched == []
    assert run.agent.outcome != "success"
    assert run.moved(since=AT) < 0.5
    assert run.moved(since=min(AT + 1.5, run.result.summary.sim_time - 0.05)) < 0.05
    assert sensor in run.sensors
    assert any(f"sensor {sensor}" in text for text in run.agent.faults)


@pytest.mark.parametrize("fault", FAULTS)
def test_without_encoders_the_reflexes_still_work(fault, broken):
    kind, how = FAULTS[fault]
    run = broken(lambda stage: break_sensor(stage, "encoders", kind, at=1.0, **how), duration=40.0)
    assert run.touched == []
    assert len([e for e in run.of(RuleChanged) if e.phase == "fired" and e.t > 1.0]) >= 1
    # Encoders that repeat themselves with fresh stamps cannot be told from a robot that keeps its speed: at 1 s it
    # turns on the spot, so the rules believe that it stands, and Flinch alone keeps it from the box.
    assert ("encoders" in run.sensors) == (fault != "frozen with fresh stamps")
    assert run.agent.goals_reached == 1


def test_the_robot_goes_on_when_the_sensor_is_back(broken):
    run = broken(lambda stage: break_sensor(stage, "sonar", DeadSensor, at=2.0, until=4.0), duration=40.0)
    assert run.agent.outcome == "success"
    assert run.sensors == {"sonar"}


def test_a_fault_is_announced_once_also_if_that_raises(stage):
    break_sensor(stage, "sonar", DeadSensor)
    sonar = stage.sensors["R2"]["sonar"]
    sonar.announce = Mock(side_effect=KeyError)
    with pytest.raises(KeyError):
        sonar.read()
    with pytest.raises(DeviceError):
        sonar.read()


def test_all_sensors_at_once(broken):
    def prepare(stage):
        for name in list(stage.sensors["R2"]):
            break_sensor(stage, name, DeadSensor, at=3.0)

    run = broken(prepare)
    assert run.touched == []
    assert run.sensors == {"sonar", "position", "orientation", "encoders"}
    assert run.moved(since=4.0) < 0.02


def test_a_sound_robot_raises_no_alarm(broken):
    for seed in (1, 2, 3):
        run = broken(seed=seed, duration=30.0)
        assert run.sensors == set()
        assert not run.agent.faults


@pytest.fixture
def stage():
    catalog = Catalog()
    return build_world(catalog.load_scenario("exp1"), catalog, 3, NullSink())


def test_when_the_mind_dies_the_wheels_stand(stage):
    """Nobody steps an agent: the actuator's side stops within max_command_age and the brakes' own time."""
    world = stage.world
    stage.actuators["R2"]["wheels"].command([0.5, 0.5])
    world.advance(40)  # 0.2 s
    assert world.commanded("R2")
    assert world.twist("R2").forward > 0.3
    world.advance(2)
    assert not any(any(m.target) for m in world._motors["R2"])
    world.advance(60)
    assert abs(world.twist("R2").forward) < 0.02


def test_what_does_not_exist_cannot_be_broken(stage):
    with pytest.raises(InputError, match="lidar"):
        break_sensor(stage, "lidar", DeadSensor)
    with pytest.raises(InputError, match="R7"):
        break_sensor(stage, "sonar", DeadSensor, agent="R7")
