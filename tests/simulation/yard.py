"""World files and drives of tests of ground, pushes and moving objects."""

from __future__ import annotations

from rocs_bt.base.geometry import Pose2

WEST = Pose2(-0.8, 0.0)
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


def driven(simulated, seconds: float, speed: float = 0.3) -> list[float]:
    """Heights of R2's base while it drives ahead [m], one per control period."""
    heights = []
    for _ in range(round(seconds / 0.05)):
        simulated.actuators["R2"]["wheels"].command([speed, speed])
        for actor in simulated.actors:
            actor.step(simulated.clock.now())
        simulated.world.advance(10)
        heights.append(simulated.world.pose3("R2").z)
    return heights
