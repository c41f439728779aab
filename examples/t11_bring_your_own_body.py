# /// script
# requires-python = ">=3.11"
# dependencies = ["rocs_bt"]
# ///
"""Bring a body without wheels: a model, a driver that accepts twists, and a table of its limits.

The puck glides on air; three fans push it ahead, aside and round. Its driver controls the velocity before each physics
step. EXP1's mission and rule file move the puck unchanged, because they ask for twists and signals, not for wheels.

Output:

    a 'twist' locomotion with the axes vx, vy, wz
    it stops from 0.5 m/s within 0.15 m
    exp1_puck, seed 3, 18.4 s simulated
    R2 success; 3.93 m, 0 collisions, 5 reflexes, 3 resumed actions
"""

import tempfile
from pathlib import Path

import rocs_bt

MODEL = """
<mujoco model="puck">
  <worldbody>
    <body name="base" pos="0 0 0.06">
      <freejoint name="base"/>
      <geom name="hull" type="cylinder" size="0.2 0.05" mass="4"/>
      <replicate count="3" euler="0 0 120">
        <geom name="skid" type="sphere" size="0.02" pos="0.15 0 -0.04" mass="0" condim="1" priority="1"/>
      </replicate>
      <site name="fans"/>
      <replicate count="16" euler="0 0 22.5">
        <site name="sonar" pos="0.2 0 0" zaxis="1 0 0"/>
      </replicate>
    </body>
  </worldbody>
  <actuator>
    <general name="ahead" site="fans" gear="1 0 0 0 0 0" ctrlrange="-8 8"/>
    <general name="aside" site="fans" gear="0 1 0 0 0 0" ctrlrange="-8 8"/>
    <general name="round" site="fans" gear="0 0 0 0 0 1" ctrlrange="-0.3 0.3"/>
  </actuator>
</mujoco>
"""

DRIVER = '''
"""Fans of the puck: a velocity controller at the rate of the physics."""

import numpy as np

from rocs_bt import Seconds
from rocs_bt.devices.mujoco import MujocoActuator


class Fans(MujocoActuator):
    """Body twists: forward, left [m/s] and turn [rad/s]."""

    size = 3
    time_constant: Seconds

    def set_up(self) -> None:
        self.fans = self.world.controls(self.robot, ["ahead", "aside", "round"])
        self.gain = np.array([4.0, 4.0, 0.08]) / self.time_constant  # mass [kg] and moment of inertia [kg m2]
        self.wanted = np.zeros(3)

    def command(self, values) -> None:
        self.wanted = np.array(values)

    def neutral(self) -> None:
        self.wanted = np.zeros(3)

    def before_step(self, t: float) -> None:
        now = self.world.twist(self.robot)
        error = self.wanted - (now.forward, now.left, now.turn)
        self.world.set_controls(self.fans, self.gain * error)
'''

ROBOT = """
format = "robot/3"
doc = "Puck on an air cushion, with three fans and a ring of sixteen sonars."
model = "robot.xml"

[locomotion]
kind = "twist"
actuator = "fans"
lag = "0.1 s"
latency = "0.15 s"
deceleration = "1.6 m/s2"
[locomotion.vx]
max_speed = "0.8 m/s"
max_acceleration = "1 m/s2"
[locomotion.vy]
max_speed = "0.8 m/s"
max_acceleration = "1 m/s2"
[locomotion.wz]
max_speed = "2.5 rad/s"
max_acceleration = "2 rad/s2"

[body]
length = "0.4 m"
width = "0.4 m"

[[actuator]]
name = "fans"
driver = "fans.py:Fans"
time_constant = "0.1 s"

[[sensor]]
name = "sonar"
driver = "range_cone"
unit = "m"
rate = "20 Hz"
range = ["0.02 m", "1.0 m"]
half_angle = "11 deg"
rays = 5
sites = [
    "sonar00", "sonar01", "sonar02", "sonar03", "sonar04", "sonar05", "sonar06", "sonar07",
    "sonar08", "sonar09", "sonar10", "sonar11", "sonar12", "sonar13", "sonar14", "sonar15",
]
monitor = "range"

[[sensor]]
name = "position"
driver = "position"
unit = "m"
rate = "20 Hz"
signal = "pose"
monitor = "pose"

[[sensor]]
name = "orientation"
driver = "orientation"
unit = "rad"
rate = "20 Hz"
signal = "pose"
monitor = "pose"

[[sensor]]
name = "twist"
driver = "twist"
rate = "20 Hz"
signal = "speed"
monitor = "MotionMonitor"

[[monitor]]
name = "range"
class = "RangeMonitor"
beams = 16
bearings = [                      # anticlockwise from straight ahead
    "0 deg", "22.5 deg", "45 deg", "67.5 deg", "90 deg", "112.5 deg", "135 deg", "157.5 deg",
    "180 deg", "202.5 deg", "225 deg", "247.5 deg", "270 deg", "292.5 deg", "315 deg", "337.5 deg",
]
[monitor.group.front]
beams = [14, 15, 0, 1, 2]
weights = [0.6, 1.0, 1.0, 1.0, 0.6]
[monitor.group.rear]
beams = [6, 7, 8, 9, 10]
weights = [0.6, 1.0, 1.0, 1.0, 0.6]
[monitor.group.left_gap]
beams = [0, 1, 2, 3, 4]
[monitor.group.right_gap]
beams = [0, 15, 14, 13, 12]

[[monitor]]
name = "pose"
class = "PoseMonitor"

[[analyze]]
name = "obstacle"
class = "PassRange"
monitors = ["range"]
near = "0.6 m"
clear = "0.8 m"

[[analyze]]
name = "position"
class = "PassPosition"
monitors = ["pose"]
"""

SCENARIO = """
format = "scenario/2"
base = "exp1"
doc = "EXP1 with the puck; mission and rule file are those of the Pioneer."

[[agent]]
name = "R2"
robot = "puck"
"""


def write_project(project: Path) -> rocs_bt.Catalog:
    """Write the robot and a scenario to the folders of a project."""
    puck = project / "robots" / "puck"
    puck.mkdir(parents=True)
    files = {"robot.xml": MODEL, "fans.py": DRIVER, "robot.toml": ROBOT}
    for name, text in files.items():
        (puck / name).write_text(text.lstrip())
    (project / "scenarios").mkdir()
    (project / "scenarios" / "exp1_puck.toml").write_text(SCENARIO.lstrip())
    return rocs_bt.Catalog(project)


with tempfile.TemporaryDirectory() as folder:
    catalog = write_project(Path(folder))
    body = catalog.load_robot("puck").locomotion
    print(f"a '{body.kind}' locomotion with the axes {', '.join(body.axes)}")
    print(f"it stops from 0.5 m/s within {body.stop_distance(rocs_bt.Twist2(0.5)):.2f} m")
    print(rocs_bt.run("exp1_puck", catalog, seed=3))
