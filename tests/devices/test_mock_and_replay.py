"""The mock obeys exactly; the replay repeats exactly."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import DeviceError, InputError
from rocs_bt.base.geometry import Pose2
from rocs_bt.control.locomotion_kinds import make_locomotion
from rocs_bt.devices.replay import ReplayActuator, replay_sensors
from rocs_bt.devices.simulated.flat import FlatRobot, FlatWorld
from rocs_bt.event import SensorFailed, SensorRead, pack
from rocs_bt.interfaces.actuator_limits import ActuatorLimits
from rocs_bt.interfaces.safety_gate import SafetyGate
from rocs_bt.testing.mock_agent import MockSensor
from tests.made_devices import make_device

DRIVE = make_locomotion("differential", wheel_separation=0.4, max_wheel_speed=1.0, max_wheel_acceleration=1.0)
WHEELS = {"motors": ["l", "r"], "wheel_radius": 0.1}
speeds = st.floats(-1.0, 1.0)


def robot(world: FlatWorld) -> FlatRobot:
    return FlatRobot(world, DRIVE, Pose2(0.0, 0.0), {"front": Pose2(0.2, 0.0, 0.0)}, {"l": 0.1, "r": 0.1})


def test_a_mock_robot_stops_when_its_watchdog_expires() -> None:
    clock = SimulatedClock(0.1)
    world = FlatWorld(clock)
    body = robot(world)
    wheels = make_device(body.world, body.name, "wheels", "velocity", WHEELS)
    gate = SafetyGate(wheels, clock, ActuatorLimits((-1.2,), (1.2,), together=True), period=0.1, max_age=0.2)
    body.gates.append(gate)
    gate.command([1.0, 1.0])
    for _ in range(10):
        world.advance(0.1)
        clock.advance()
    assert body.pose.x == pytest.approx(0.3)  # at 0, 0.1 and 0.2 s it still drove


@given(st.floats(0.0, 6.2), st.floats(0.5, 3.0), st.floats(0.05, 0.4))
def test_a_ray_at_a_circle_stops_at_its_rim(yaw: float, distance: float, radius: float) -> None:
    centre = (distance * math.cos(yaw), distance * math.sin(yaw))
    world = FlatWorld(SimulatedClock(0.1), circles=[(centre, radius)])
    assert world.ray(0.0, 0.0, yaw) == pytest.approx(distance - radius)
    assert world.ray(0.0, 0.0, yaw + math.pi) == math.inf


def test_a_mock_sensor_can_be_told_what_to_say_and_to_break() -> None:
    body = robot(FlatWorld(SimulatedClock(0.1)))
    sensor = MockSensor(make_device(body.world, body.name, "s", "height", {}))
    assert sensor.read().values == [0.0]
    sensor.values = [math.nan, 1.0]
    assert sensor.read().values[1] == 1.0
    sensor.broken = "unplugged"
    with pytest.raises(DeviceError, match="'s' has no reading: unplugged"):
        sensor.read()


def test_unknown_mounts_and_motors_list_what_exists() -> None:
    body = robot(FlatWorld(SimulatedClock(0.1)))
    with pytest.raises(InputError, match="no mount for sensor 's' is named 'rear'"):
        make_device(body.world, body.name, "s", "range_cone", {"sites": ["rear"], "range": [0.1, 1.0]})
    with pytest.raises(InputError, match=r"no motor is named 'm'.*The robot 'R1' has: l, r"):
        make_device(body.world, body.name, "wheels", "velocity", {"motors": ["l", "m"], "wheel_radius": 0.1})


def test_a_replay_says_what_was_recorded_when_it_was() -> None:
    clock = SimulatedClock(0.05)
    events = [
        SensorRead(t=0.0, agent="R2", sensor="sonar", stamp=0.0, data=pack([1.0, math.inf])),
        SensorRead(t=0.0, agent="R3", sensor="sonar", stamp=0.0, data=pack([9.0])),
        SensorRead(t=0.1, agent="R2", sensor="sonar", stamp=0.05, data=pack([0.5, 0.4])),
        SensorFailed(t=0.2, agent="R2", sensor="sonar", detail="gone"),
    ]
    sonar = replay_sensors(events, "R2", ["sonar"], clock)["sonar"]
    assert sonar.read().values == [1.0, math.inf]
    clock.advance()
    with pytest.raises(DeviceError, match="no reading of sensor 'sonar' at this time"):
        sonar.read()
    clock.advance()
    reading = sonar.read()
    assert (reading.stamp, reading.values) == (0.05, [0.5, 0.4])
    clock.advance(2)
    for _ in range(2):
        with pytest.raises(DeviceError, match="gone"):
            sonar.read()
        clock.advance()


def test_a_replay_actuator_only_notes() -> None:
    clock = SimulatedClock(0.1)
    wheels = ReplayActuator("wheels", 2, clock)
    wheels.command([0.1, 0.2])
    clock.advance()
    wheels.neutral()
    assert wheels.commands == [(0.0, (0.1, 0.2)), (0.1, (0.0, 0.0))]
