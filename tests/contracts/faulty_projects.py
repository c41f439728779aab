"""A good project, and faults to put into it: each replaces a text of one of its files."""

from __future__ import annotations

import random
from collections.abc import Sequence
from pathlib import Path

ROBOT = """format = "robot/3"
base = "pioneer_p3dx"
doc = "With a thermometer."

[[sensor]]
name = "thermometer"
driver = "parts.py:Thermometer"
rate = "20 Hz"
signal = "temperature"
monitor = "parts.py:Warmth"

[[analyze]]
name = "heat"
class = "parts.py:Heat"
monitors = ["thermometer"]
limit = "2 m"

[rules.own]
near = "0.3 m"
"""
PARTS = '''"""Parts of the rover."""

from rocs_bt import Analyze, Monitor, Signal
from rocs_bt.drivers.mujoco import MujocoSensor
from rocs_bt.units import LENGTH, Metres


class Thermometer(MujocoSensor):
    """Constant warmth."""

    def sample(self):
        return [0.5]


class Warmth(Monitor):
    """Warmth."""

    def signals(self):
        return [Signal("temperature", 1, (LENGTH,), (0.0, 9.0), self.max_age)]

    def interpret(self, readings):
        return {"temperature": readings["thermometer"].values}


class Heat(Analyze):
    """Compare with a limit."""

    def __init__(self, *args, limit: Metres = 1.0, **kwargs):
        super().__init__(*args, **kwargs)
        self.limit = limit

    def process(self, t):
        pass
'''
RULES = """format = "reflex/1"
doc = "Back off."

[threshold]
near = "0.2 m"

[alias]
hot = "temperature > 5 m"

[rule.Near]
when = "min(front) < near and speed > 0 m/s"
priority = 20
action = { name = "TurnAngle", angle = "90 deg" }

[rule.Hot]
when = "hot and speed > 0.1 m/s"
until = "speed < 0.05 m/s"
priority = 10
action = { name = "Stop" }
"""
MISSION = """<root BTCPP_format="4" main_tree_to_execute="own">
  <BehaviorTree ID="own">
    <Sequence>
      <When expression="temperature &lt; 3 m"/>
      <RetryUntilSuccessful num_attempts="2"><Knock times="3"/></RetryUntilSuccessful>
      <SubTree ID="drive" goal="{goal}" cruise="0.3 m/s"/>
    </Sequence>
  </BehaviorTree>
  <BehaviorTree ID="drive">
    <Sequence><GoTo goal="{goal}" cruise="{cruise}"/></Sequence>
  </BehaviorTree>
  <TreeNodesModel>
    <SubTree ID="own"><input_port name="goal" default="goal"/></SubTree>
    <SubTree ID="drive">
      <input_port name="goal"/><input_port name="cruise" type="m/s" default="0.4 m/s"/>
    </SubTree>
  </TreeNodesModel>
</root>
"""
NODE = '''"""A node."""

from rocs_bt.trees.nodes import SUCCESS, Input, Instant


class Knock(Instant):
    """Knock."""

    times = Input(int)

    def update(self):
        return SUCCESS
'''
SCENARIO = """format = "scenario/2"
doc = "Drive."
world = "yard"
duration = "5 s"

[rate]
control = "20 Hz"

[[place]]
name = "goal"
x = "2 m"
y = "0 m"
tolerance = "0.2 m"

[[agent]]
name = "R1"
robot = "rover"
mission = "own"
rules = ["own"]
x = "0 m"
y = "0 m"
yaw = "0 deg"

[agent.parameters]
goal = "goal"

[[requirement]]
name = "slow"
require = "always speed < 2 m/s"
"""
WORLD = """<mujoco model="yard">
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <geom name="box" type="box" size="0.2 0.2 0.2" pos="3 3 0.2"/>
  </worldbody>
</mujoco>
"""
FILES = {
    "robots/rover/robot.toml": ROBOT,
    "robots/rover/parts.py": PARTS,
    "rules/own.toml": RULES,
    "planners/missions/own.xml": MISSION,
    "planners/nodes/knock.py": NODE,
    "scenarios/own.toml": SCENARIO,
    "scenarios/worlds/yard.xml": WORLD,
}
R, P, U, M, N, S, W = FILES

ERRORS: Sequence[tuple[str, str, str]] = (
    (R, '"pioneer_p3dx"', '"pioneer_p4dx"'),
    (R, '"20 Hz"', '"20 m"'),
    (R, '"20 Hz"', '"30 Hz"'),
    (R, "parts.py:Thermometer", "parts.py:Barometer"),
    (R, "parts.py:Thermometer", "part.py:Thermometer"),
    (R, 'limit = "2 m"', 'limit = "2 kg"'),
    (R, 'limit = "2 m"', 'limits = "2 m"'),
    (R, 'monitors = ["thermometer"]', 'monitors = ["thermo"]'),
    (R, "[rules.own]", "[rules.other]"),
    (R, 'near = "0.3 m"', 'near = "0.3 s"'),
    (R, 'near = "0.3 m"', 'nearer = "0.3 m"'),
    (R, 'driver = "parts', 'drive = "parts'),
    (R, "[[sensor]]", '[locomotion]\nactuator = "legs"\n\n[[sensor]]'),
    (R, "[[sensor]]", '[locomotion]\nwheel_separation = "0 m"\n\n[[sensor]]'),
    (R, "[[sensor]]", 'model = "other.xml"\n\n[[sensor]]'),
    (P, "return [0.5]", "return [1 / 0]"),
    (P, "return [0.5]", "return None"),
    (P, "return [0.5]", "return [0.5, 0.5]"),
    (P, 'readings["thermometer"].values', 'readings["other"].values'),
    (P, '{"temperature": readings', '{"temper": readings'),
    (P, "        self.limit = limit", '        raise ValueError("no limit")'),
    (P, "class Heat(Analyze)", "class Heat"),
    (P, "class Heat(Analyze):", "class Heat(Analyze)"),
    (P, "from rocs_bt import Analyze", "import nowhere\nfrom rocs_bt import Analyze"),
    (P, 'Signal("temperature"', 'Signal("speed"'),
    (U, "min(front) < near", "min(front) < near2"),
    (U, "min(front) < near", "min(front) < 0.3 s"),
    (U, "min(front) < near", "min(front < near"),
    (U, "min(front) < near", "minimum(front) < near"),
    (U, "priority = 10", "priority = 20"),
    (U, "priority = 10", 'priority = "10"'),
    (U, '"Stop"', '"Stopp"'),
    (U, 'angle = "90 deg"', 'angle = "90 m"'),
    (U, 'angle = "90 deg"', 'angel = "90 deg"'),
    (U, "until =", "untill ="),
    (U, 'near = "0.2 m"', "near = 0.2"),
    (U, '"reflex/1"', '"reflex/9"'),
    (U, "[rule.Hot]", "[rule.Near]"),
    (M, "<Knock times", "<Knok times"),
    (M, 'times="3"', 'times="three"'),
    (M, 'times="3"', 'time="3"'),
    (M, 'num_attempts="2"', 'num_attempts="two"'),
    (M, "<Sequence><GoTo", "<Sequenz><GoTo"),
    (M, 'temperature &lt; 3 m"', 'temperature &lt; 3 kg"'),
    (M, 'temperature &lt; 3 m"', 'warmth &lt; 3 m"'),
    (M, 'temperature &lt; 3 m"', 'temperature &lt; "'),
    (M, 'cruise="0.3 m/s"', 'cruise="0.3 m"'),
    (M, '<SubTree ID="drive" goal="{goal}"', '<SubTree ID="driven" goal="{goal}"'),
    (M, '<GoTo goal="{goal}" cruise="{cruise}"/>', '<SubTree ID="own"/>'),
    (M, 'main_tree_to_execute="own"', 'main_tree_to_execute="main"'),
    (M, "</Sequence>\n  </BehaviorTree>\n  <Behav", "\n  </BehaviorTree>\n  <Behav"),
    (N, "times = Input(int)", "times = Input(complex)"),
    (N, "times = Input(int)", "times = Input(int"),
    (N, "class Knock(Instant)", "class Knock"),
    (N, "Input, Instant", "Inputs, Instant"),
    (S, '"yard"', '"yards"'),
    (S, '"rover"', '"rower"'),
    (S, 'mission = "own"', 'mission = "owl"'),
    (S, 'rules = ["own"]', 'rules = ["owl"]'),
    (S, 'goal = "goal"', 'gaol = "goal"'),
    (S, 'goal = "goal"', "goal = 3"),
    (S, 'x = "0 m"', 'x = "3 m"\nx = "3 m"'),
    (S, 'x = "0 m"\ny = "0 m"', 'x = "3 m"\ny = "3 m"'),
    (S, 'x = "0 m"\ny = "0 m"', 'x = "9 m"\ny = "9 m"'),
    (S, 'yaw = "0 deg"', 'yaw = "0 m"'),
    (S, 'control = "20 Hz"', 'control = "30 Hz"'),
    (S, 'control = "20 Hz"', 'control = "7 Hz"'),
    (S, "always speed < 2 m/s", "always speed < 2 m"),
    (S, "always speed < 2 m/s", "always sped < 2 m/s"),
    (S, 'name = "R1"', 'name = "goal"'),
    (S, 'name = "R1"', 'name = "sonar"'),
    (S, "[[requirement]]", '[[fact]]\nnode = "goal"\nrelation = "eats"\nto = "R1"\n\n[[requirement]]'),
    (S, "[[requirement]]", '[share]\nkinds = ["goals"]\n\n[[requirement]]'),
    (S, "[[requirement]]", '[[push]]\nrobot = "R7"\nat = "1 s"\nforce = { x = "1 N" }\n\n[[requirement]]'),
    (S, "[[requirement]]", '[[agent]]\nname = "R1"\nrobot = "rover"\nx = "1 m"\ny = "1 m"\n\n[[requirement]]'),
    (S, 'format = "scenario/2"', 'format = "scenario/2"\nbase = "own"'),
    (S, 'format = "scenario/2"', 'format = "scenario/2"\nbase = "none"'),
    (S, 'doc = "Drive."', 'dog = "Drive."'),
    (S, 'duration = "5 s"', 'duration = "-5 s"'),
    (W, "</worldbody>", "</world>"),
    (W, 'type="box"', 'type="bocks"'),
    (W, 'size="0.2 0.2 0.2"', 'size="0.2 0.2"'),
    (W, 'name="box"', 'name="floor"'),
)  # fmt: skip  # a table
"""Faults as (file, text, replacement), each of which prevents a run."""

WARNINGS: Sequence[tuple[str, str, str]] = (
    (S, 'goal = "goal"', 'goal = "gaol"'),
    (M, '<GoTo goal="{goal}"', '<GoTo goal="nowhere"'),
    (S, 'x = "2 m"\ny = "0 m"', 'x = "3 m"\ny = "3 m"'),
    (S, 'x = "2 m"\ny = "0 m"', 'x = "7 m"\ny = "0 m"'),
    (S, 'control = "20 Hz"', 'control = "20 Hz"\nsensors = "2 Hz"'),
    (S, "[[requirement]]", '[[push]]\nrobot = "R1"\nat = "9 s"\nforce = { left = "1 N" }\n\n[[requirement]]'),
    (U, '[alias]', '[alias]\nunused = "speed > 1 m/s"'),
    (U, 'min(front) < near and', 'min(front) < 0 m and'),
    (N, '        return SUCCESS', '        import time\n\n        time.sleep(1.0)\n        return SUCCESS'),
    (M, 'cruise="0.3 m/s"', 'cruise="3 m/s"'),
    (R, "[[sensor]]", '[body]\nlength = "2 m"\n\n[[sensor]]'),
)  # fmt: skip  # a table
"""Probable mistakes, with which the project still runs."""


def write_project(folder: Path, faults: Sequence[tuple[str, str, str]] = ()) -> Path:
    """Write the good project with faults; returns the file of its scenario."""
    for name, text in FILES.items():
        for file, old, new in faults:
            if file == name:
                assert old in text or len(faults) > 1, (file, old)
                text = text.replace(old, new, 1)
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    return folder / S


def two_faults(seed: int) -> list[tuple[str, str, str]]:
    """One or two faults or probable mistakes, at random."""
    return random.Random(seed).sample([*ERRORS, *WARNINGS], 1 + seed % 2)
