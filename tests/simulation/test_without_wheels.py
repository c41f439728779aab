"""A body without wheels in a whole run: a flying box that an inner loop holds up, with its height in the recording."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

import rocs_bt
from rocs_bt.catalog import Catalog
from rocs_bt.event import BlockFailed, BodyMoved
from rocs_bt.record import Recording
from rocs_bt.record.explanation.why import explain
from rocs_bt.record.figures import write_figures

from ..pages import log_of

MODEL = """<mujoco model="drone">
  <worldbody>
    <body name="base" pos="0 0 0.1">
      <freejoint name="base"/>
      <geom name="hull" type="box" size="0.15 0.15 0.04" pos="0 0 0.04" mass="1"/>
      <geom name="skid" type="box" size="0.1 0.1 0.02" pos="0 0 -0.08" mass="0.1"/>
      <site name="centre"/>
    </body>
  </worldbody>
  <actuator>
    <general name="fx" site="centre" gear="1 0 0 0 0 0"/>
    <general name="fy" site="centre" gear="0 1 0 0 0 0"/>
    <general name="fz" site="centre" gear="0 0 1 0 0 0"/>
    <general name="tx" site="centre" gear="0 0 0 1 0 0"/>
    <general name="ty" site="centre" gear="0 0 0 0 1 0"/>
    <general name="tz" site="centre" gear="0 0 0 0 0 1"/>
  </actuator>
</mujoco>"""

DRIVER = """
from rocs_bt import Monitor, Signal
from rocs_bt.devices.mujoco import MujocoActuator, MujocoSensor
from rocs_bt.base.units import LENGTH, SPEED, TURN_RATE


class Thrust(MujocoActuator):
    size = 4

    def set_up(self):
        self.controls = self.world.controls(self.robot, ["fx", "fy", "fz", "tx", "ty", "tz"])
        self.wanted, self.z = [0.0] * 4, 0.6

    def command(self, values):
        self.wanted = list(values)

    def neutral(self):
        self.wanted = [0.0] * 4

    def before_step(self, t):
        world, robot = self.world, self.robot
        pose, twist, velocity = world.pose3(robot), world.twist(robot), world.data.qvel
        forward, left, up, turn = self.wanted
        self.z += up * world.step
        force = 1.1 * 9.81 + 12.0 * (self.z - pose.z) - 6.0 * velocity[2] + self.rng.normal(0.0, 0.05)
        torque = -0.5 * pose.roll - 0.1 * velocity[3], -0.5 * pose.pitch - 0.1 * velocity[4], 0.3 * (turn - twist.turn)
        values = [6.0 * (forward - twist.forward), 6.0 * (left - twist.left), force, *torque]
        FAULT
        world.set_controls(self.controls, values)


class Motion(MujocoSensor):
    def sample(self):
        twist = self.world.twist(self.robot)
        return [twist.forward, twist.turn, self.world.pose3(self.robot).z]


class MotionMonitor(Monitor):
    def signals(self):
        return [
            Signal("speed", 1, (SPEED,), (-9.0, 9.0), self.max_age),
            Signal("turn_rate", 1, (TURN_RATE,), (-20.0, 20.0), self.max_age),
            Signal("height", 1, (LENGTH,), (-1.0, 100.0), self.max_age),
        ]

    def interpret(self, readings):
        forward, turn, height = readings["motion"].values
        return {"speed": [forward], "turn_rate": [turn], "height": [height]}
"""

ROBOT = """
format = "robot/3"
doc = "A flying box."
model = "robot.xml"

[locomotion]
kind = "flying"
actuator = "thrust"
lag = "0.15 s"
vx = { max_speed = "0.8 m/s", max_acceleration = "1 m/s2" }
vy = { max_speed = "0.5 m/s", max_acceleration = "1 m/s2" }
vz = { max_speed = "0.5 m/s", max_acceleration = "1 m/s2" }
wz = { max_speed = "1 rad/s", max_acceleration = "2 rad/s2" }

[[sensor]]
name = "position"
driver = "position"
unit = "m"
signal = "pose"
monitor = "pose"

[[sensor]]
name = "orientation"
driver = "orientation"
unit = "rad"
signal = "pose"
monitor = "pose"

[[sensor]]
name = "motion"
driver = "drone.py:Motion"
signal = "speed"
monitor = "drone.py:MotionMonitor"

[[monitor]]
name = "pose"
class = "PoseMonitor"
sensors = ["position", "orientation"]

[[actuator]]
name = "thrust"
driver = "drone.py:Thrust"
"""

JAW = """[[actuator]]
name = "jaw"
driver = "velocity"
motors = ["jaw"]
wheel_radius = "0.05 m"
range = ["-0.1", "0.1"]

"""

_FINGER = '<body name="jaw"><joint name="jaw" type="hinge"/><geom size="0.01" mass="0.01"/></body>'
MODEL_WITH_JAW = MODEL.replace("</body>", _FINGER + "</body>").replace(
    "</actuator>", '<velocity name="jaw" joint="jaw" kv="0.01"/></actuator>'
)

SCENARIO = """
format = "scenario/2"
doc = "Flies to a gate."
world = "field"
duration = "12 s"

[[place]]
name = "gate"
x = "1 m"
y = "0.2 m"
z = "0.6 m"

[[agent]]
name = "D"
robot = "drone"
mission = "go_to"
x = "0 m"
y = "0 m"
success = { goal = "gate" }
[agent.parameters]
goal = "gate"
"""

FIELD = '<mujoco><worldbody><geom name="floor" type="plane" size="9 9 0.1"/></worldbody></mujoco>'

WALL = '<geom name="low_wall" type="box" size="0.05 1 0.15" pos="0.6 0 0.15"/></worldbody>'


@pytest.fixture
def fly(tmp_path):
    """Run the scenario with a fault in the driver's inner loop, or another height of the gate."""

    def run(
        seed: int = 1,
        fault: str = "pass",
        height: str = "0.6 m",
        report: bool = False,
        jaw: bool = False,
        end: str = "12 s",
        more: str = "",
        world: str = "field",
        **options,
    ):
        files = {
            "robots/drone/robot.xml": MODEL_WITH_JAW if jaw else MODEL,
            "robots/drone/robot.toml": ROBOT.replace("[[actuator]]", JAW * jaw + "[[actuator]]"),
            "robots/drone/drone.py": DRIVER.replace("FAULT", fault),
            "scenarios/worlds/field.xml": FIELD,
            "scenarios/worlds/wall.xml": FIELD.replace("</worldbody>", WALL),
            "scenarios/fly.toml": SCENARIO.replace('z = "0.6 m"', f'z = "{height}"')
            .replace("12 s", end)
            .replace("field", world)
            + more,
        }
        for name, text in files.items():
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).write_text(text)
        return rocs_bt.run("fly", Catalog(tmp_path), seed=seed, out=tmp_path / "run", report=report, **options)

    return run


def moves(result) -> list[BodyMoved]:
    return [e for e in Recording.open(result.recording).events() if isinstance(e, BodyMoved)]


def test_it_flies_to_the_goal_and_its_height_is_recorded(fly) -> None:
    first = fly(report=True)
    agent = first.summary.agents["D"]
    assert (agent.outcome, agent.reason) == ("success", "")
    found = moves(first)
    assert found[0].height == pytest.approx(0.1)
    assert found[-1].height == pytest.approx(0.6, abs=0.1)
    assert all(abs(e.roll) < 0.2 and abs(e.pitch) < 0.2 and e.wheels == b"" for e in found)
    assert f"height {found[40].height:.3f} m" in str(explain(Recording.open(first.recording), found[40].t))
    assert (first.recording.parent / "report.html").is_file()
    again = fly()
    assert moves(again) == found
    assert again.summary.trajectory_hash == first.summary.trajectory_hash != fly(seed=2).summary.trajectory_hash


def test_a_goal_at_another_height_is_not_reached(fly) -> None:
    agent = fly(height="2 m").summary.agents["D"]
    assert agent.outcome != "success"
    assert agent.goals_reached == 0


def test_the_height_of_a_goal_may_have_a_tolerance_of_its_own(fly) -> None:
    wide = fly(height='0.75 m"\nheight_tolerance = "0.3 m').summary.agents["D"]
    assert (wide.outcome, wide.goals_reached) == ("success", 1)


def test_requirements_read_the_true_height_and_tilt(fly) -> None:
    tables = (
        '[[requirement]]\nname = "low"\nrequire = "always true_height < 0.9 m and true_tilt < 20 deg"\n'
        '[[requirement]]\nname = "high"\nrequire = "always true_height > 0.3 m"\n'
    )
    found = fly(more=tables).summary.agents["D"].requirements
    assert [r.verdict for r in found] == ["satisfied", "violated"]


def test_path_and_clearance_of_a_robot_that_flies_over_a_wall_are_measured_in_space(fly) -> None:
    stages, least = [], []

    def look(t: float) -> None:
        least.append(min([*least[-1:], stages[0].world.clearance("D")[0]]))

    over = fly(world="wall", prepare=stages.append, progress=look)
    agent, found = over.summary.agents["D"], moves(over)
    assert (agent.outcome, agent.collisions) == ("success", 0)
    plane = sum(math.dist((a.x, a.y), (b.x, b.y)) for a, b in pairwise(found))
    space = sum(math.dist((a.x, a.y, a.height), (b.x, b.y, b.height)) for a, b in pairwise(found))
    assert agent.path_length == pytest.approx(space)
    assert space > plane + 0.1
    assert agent.min_clearance == pytest.approx(least[-1], abs=1e-9)
    assert 0.05 < agent.min_clearance < 0.35  # over the wall, which the path crosses


def heights(run) -> str:
    """Figure of height and tilt that `rocs-bt plot` writes, as SVG."""
    folder = run.recording.parent / "figures"
    write_figures([Recording.open(run.recording)], folder, formats=("svg",))
    return (folder / "height.svg").read_text("utf-8")


def test_figures_show_height_tilt_and_pushes_and_the_report_says_them(fly) -> None:
    push = '[[push]]\nrobot = "D"\nat = "3 s"\nforce = { left = "5 N" }\n'
    run = fly(more=push, report=True)
    figure = heights(run)
    assert 'id="height-0-D-height"' in figure
    assert 'id="height-0-D-tilt"' in figure
    assert 'id="height-0-D-push-0-0"' in figure
    assert "pushed by 5 N for 0.1 s (scripted)" in log_of(run.report)
    assert rocs_bt.replay(Recording.open(run.recording), Catalog(run.recording.parents[1])) is None


def test_pushes_of_robots_without_an_agent_are_shown_too(fly) -> None:
    other = '[[actor]]\nname = "R1"\nrobot = "pioneer_p3dx"\nscript = "random_walk"\nx = "-2 m"\ny = "2 m"\n'
    push = '[[push]]\nrobot = "{}"\nat = "1 s"\nforce = {{ left = "5 N" }}\n'
    run = fly(more=other + push.format("R1") + push.format("D"), report=True)
    figure = heights(run)
    assert 'id="height-0-R1-push-0-0"' in figure
    assert 'id="height-0-D-push-1-0"' in figure
    assert [text for text in log_of(run.report) if "pushed" in text] == [
        "R1 was pushed by 5 N for 0.1 s (scripted)",
        "pushed by 5 N for 0.1 s (scripted)",
    ]


def test_an_inner_loop_that_raises_is_an_error_of_the_actuator(fly) -> None:
    result = fly(fault="assert t < 2.0, 'no thrust'")
    agent = result.summary.agents["D"]
    assert agent.outcome == "error"
    (failed,) = (e for e in Recording.open(result.recording).events() if isinstance(e, BlockFailed))
    assert (failed.block, failed.owner, failed.t) == ("thrust", "content", pytest.approx(2.0, abs=0.05))
    assert "AssertionError: no thrust (drone.py:" in agent.reason


def test_it_is_stuck_if_it_does_not_move_although_it_is_commanded_to_and_has_a_gripper(fly) -> None:
    agent = fly(fault="values[:2] = 0.0, 0.0", jaw=True, end="20 s").summary.agents["D"]
    assert agent.outcome == "stuck"
