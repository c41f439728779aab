# /// script
# requires-python = ">=3.11"
# dependencies = ["rocs_bt"]
# ///
"""Build a robot of your own: a folder with a table of devices, a model, and a driver in Python.

The scout is a Pioneer with a receiver for a radio beacon at the origin. The receiver's driver and Monitor are Python
classes beside robot.toml, which names them as `file.py:Class`. The key `at` in robot.toml is a field of
the driver's class, converted to metres. The mission reads the receiver's signal like any other, and rules could
too. The shipped rules run on the scout unchanged. `rocs-bt check` in such a project reports all faults of its files.

Output:

    scout has sonar, position, orientation, encoders, radio
    seek, seed 2, 11.0 s simulated
    R2 success; 3.14 m, 0 collisions, 2 reflexes, 2 resumed actions
    distance to the beacon: 2.23 m at the start, 0.01 m at the end
"""

import shutil
import tempfile
from pathlib import Path

import rocs_bt
from rocs_bt.event import ListSink, SignalsWritten

DRIVER = '''
"""A radio beacon: signal strength and distance."""

from rocs_bt import Metres, Monitor, Signal
from rocs_bt.base.units import LENGTH
from rocs_bt.devices.mujoco import MujocoSensor


class Beacon(MujocoSensor):
    """Signal strength of the beacon: 1 at a metre, falling with the square of the distance."""

    at: tuple[Metres, Metres]

    def sample(self) -> list[float]:
        robot = self.world.pose(self.robot)
        squared = (robot.x - self.at[0]) ** 2 + (robot.y - self.at[1]) ** 2
        return [1.0 / (squared + 1e-4)]


class BeaconMonitor(Monitor):
    """Converts the signal strength to a distance."""

    def signals(self):
        return [Signal("beacon", 1, (LENGTH,), (0.0, 100.0), self.max_age, "Distance to the beacon.")]

    def interpret(self, readings):
        return {"beacon": [readings["radio"].values[0] ** -0.5]}
'''

DEVICES = """
[[sensor]]
name = "radio"
driver = "beacon.py:Beacon"
at = ["0 m", "0 m"]
rate = "10 Hz"
noise = "0"
signal = "beacon"
monitor = "beacon.py:BeaconMonitor"
"""

MISSION = '''
"""Go to the goal, and check that the beacon is there."""

from py_trees.composites import Sequence


def build(mission):
    """Drive, then check the signal."""
    there = mission.when("beacon < 0.15 m", name="the beacon is here")
    return Sequence("seek", memory=True, children=[mission.act("GoTo", goal="goal", cruise="0.5 m/s"), there])
'''


def write_project(project: Path) -> rocs_bt.Catalog:
    """Write a robot, a mission and a scenario to the folders of a project."""
    shipped = rocs_bt.Catalog()
    scout = project / "robots" / "scout"
    shutil.copytree(shipped.find("robot", "pioneer_p3dx").path.parent, scout)
    with (scout / "robot.toml").open("a") as table:
        table.write(DEVICES)
    (scout / "beacon.py").write_text(DRIVER)
    (project / "planners" / "missions").mkdir(parents=True)
    (project / "planners" / "missions" / "seek.py").write_text(MISSION)
    scenario = shipped.find("scenario", "exp1").path.read_text()
    scenario = scenario.replace('robot = "pioneer_p3dx"\nmission = "go_to"', 'robot = "scout"\nmission = "seek"')
    scenario = scenario.replace('[agent.parameters]\ngoal = "goal"\ncruise = "0.5 m/s"\n', "")
    (project / "scenarios").mkdir()
    (project / "scenarios" / "seek.toml").write_text(scenario)
    return rocs_bt.Catalog(project)


with tempfile.TemporaryDirectory() as folder:
    catalog = write_project(Path(folder))
    robot = catalog.load_robot("scout")
    print(f"{robot.name} has {', '.join(sensor.name for sensor in robot.sensors)}")
    sink = ListSink()
    result = rocs_bt.run("seek", catalog, seed=2, sinks=[sink])
    print(result)
    distances = [e.values["beacon"][0] for e in sink.events if isinstance(e, SignalsWritten) and "beacon" in e.signals]
    print(f"distance to the beacon: {distances[0]:.2f} m at the start, {distances[-1]:.2f} m at the end")
