"""docs/files.md and files-robot.md: each documented key is accepted, and each accepted key is documented."""

import re
import tomllib
from pathlib import Path

import pytest

from rocs_bt.actions import ACTIONS
from rocs_bt.analyze import ANALYZERS
from rocs_bt.base.errors import InputError
from rocs_bt.base.signal import Signal
from rocs_bt.base.units import LENGTH
from rocs_bt.catalog import PlannerSpec, ScenarioSpec, load_robot
from rocs_bt.declare import Registered, Value, fields_of, keys_of
from rocs_bt.devices.simulated import ACTUATORS, SENSORS, declared_keys
from rocs_bt.expression import Environment
from rocs_bt.knowledge.signals import SignalTable
from rocs_bt.monitor import MONITORS, Monitor
from rocs_bt.reactive import load_rules
from rocs_bt.simulation import SCRIPTED_OBJECTS, SCRIPTED_ROBOTS

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGE = "\n".join((DOCS / name).read_text("utf-8") for name in ("files-robot.md", "files.md"))

# One file of each kind with every key; `# zzz TABLE` marks where an unknown key would stand in that table.
ROBOT = """
format = "robot/3"
base = "nothing"
doc = "All keys."
model = "robot.xml"
# zzz robot
[locomotion]
kind = "differential"
actuator = "wheels"
wheel_separation = "0.3 m"
max_wheel_speed = "1 m/s"
max_wheel_acceleration = "1 m/s2"
delay = "0.05 s"
lag = "0.05 s"
latency = "0.05 s"
deceleration = "1 m/s2"
# zzz robot.locomotion
[body]
length = "0.5 m"
ground_contact = ["left_wheel", "right_wheel", "caster"]
width = "0.4 m"
# zzz robot.body
[[sensor]]
name = "where"
driver = "position"
signal = "pose"
monitor = "pose"
rate = "20 Hz"
noise = "1 cm"
unit = "m"
max_age = "0.2 s"
optional = true
latency = "10 ms"
drop_out = 0.1
drift = "1 cm"
jump = "10 cm"
jump_every = "5 s"
mount = { x = "0.1 m", y = "0 m", yaw = "10 deg" }
# zzz robot.sensor
[[actuator]]
name = "wheels"
driver = "velocity"
unit = "m/s"
range = ["-1 m/s", "1 m/s"]
max_change = "5 m/s2"
max_command_age = "0.1 s"
isolated = true
motors = ["left", "right"]
wheel_radius = "0.1 m"
signs = [1, 1]
max_acceleration = "3 m/s2"
delay = "0.1 s"
slip = [0.1]
# zzz robot.actuator
[[monitor]]
name = "pose"
class = "PoseMonitor"
sensors = ["where"]
[[analyze]]
name = "turned"
class = "PassOrientation"
monitors = ["pose"]
[ros2]
transport = "dds"
distro = "jazzy"
domain = 7
network = "lan"
namespace = "r1"
use_sim_time = false
emergency_stop = "stop"
messages = "messages"
go = "go"
# zzz robot.ros2
[rules.avoid_collision]
near = "0.5 m"
"""

RULES = """
format = "reflex/1"
doc = "All keys."
# zzz rules
include = ["nothing_more.toml"]
[robot]
latency = "0.1 s"
deceleration = "1 m/s2"
turn_deceleration = "1 rad/s2"
climb_deceleration = "1 m/s2"
speed_limit = "1 m/s"
length = "1 m"
front_sweep = "0.1 m"
side_sweep = "0.1 m"
# zzz rules.robot
[threshold]
far = "0.5 m"
[alias]
ahead = "min(front)"
[rule.Near]
doc = "One."
tags = ["safety"]
modes = ["drive"]
require = ["front"]
waits_for = "a person"
when = "ahead < 0.4 m"
until = "ahead > 0.5 m"
for = "0.1 s"
cooldown = "1 s"
trigger = "level"
keep = ["speed"]
priority = 50
on_invalid = "hold"
max_hold = "0.5 s"
# zzz rules.rule
[rule.Near.action]
name = "Flinch"
speed = "-0.2 m/s if ahead < 0.2 m else 0 m/s"
[rule.Near.action.on_invalid]
speed = "0 m/s"
[[rule.Near.test]]
name = "far away"
mode = "drive"
given = { front = "1 m" }
at = [{ t = "0 s" }]
expect = [{ t = "0 s", fires = false }]
# zzz rules.rule.test
"""


def rows(title):
    """The lines of the table under a title."""
    (part,) = re.findall(rf"^##+ {re.escape(title)}\n(.*?)(?=^##|\Z)", PAGE, re.MULTILINE | re.DOTALL)
    lines = [line.strip("|").split("|") for line in part.splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in line] for line in lines]


def keys(title):
    """The keys documented under a title."""
    return {key for row in rows(title)[1:] for key in re.findall(r"`(\w+)`", row[0])}


def by_owner(title):
    """The keys documented under a title whose table tells an owner first; an empty owner is the one above."""
    found, owner = {}, ""
    for row in rows(title)[1:]:
        owner = row[0].strip("`") or owner
        found.setdefault(owner, set()).update(re.findall(r"`(\w+)`", row[1]))
    return found


def load(kind, text, folder):
    file = folder / f"{kind}.toml"
    file.write_text(text, "utf-8")
    nothing = folder / "nothing.toml"
    nothing.write_text("", "utf-8")
    if kind == "robot":
        (folder / "robot.xml").write_text("<mujoco/>", "utf-8")
        return load_robot(file, lambda base: nothing)
    (folder / "nothing_more.toml").write_text('format = "reflex/1"', "utf-8")
    signals = SignalTable()
    signals.declare(Signal("front", 2, (LENGTH,)))
    signals.freeze()
    return load_rules(file, Environment.of(signals), ACTIONS)


OTHER_KINDS = {  # a differential drive refuses them
    "robot.locomotion": {
        *("effective_wheel_separation", "icr_offset", "base_radius", "half_length", "half_width"),
        *("max_speed", "max_acceleration", "land_after", "sway"),
    },
}
FILES = {"robot": ROBOT, "rules": RULES}
CLASSES = {"scenario": ScenarioSpec, "planner": PlannerSpec}


def shape(text):
    """The keys of every table of a TOML text, by the table's title in the page."""
    found = {}

    def walk(table, title):
        found.setdefault(title, set()).update(table)
        for key, value in table.items():
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, dict):
                    walk(child, f"{title}.{key}")

    kind = next(k for k, t in FILES.items() if t is text)
    walk(tomllib.loads(text), kind)
    return {title.replace("rule.Near", "rule"): names for title, names in found.items()}


@pytest.mark.parametrize("kind", FILES)
def test_a_file_with_every_documented_key_loads(kind, tmp_path):
    load(kind, FILES[kind], tmp_path)
    titles = re.findall(rf"^### ({kind}(?:\.[\w.]+)?)$", PAGE, re.MULTILINE)
    documented, written = {title: keys(title) for title in titles}, shape(FILES[kind])
    assert titles
    for title in titles:
        assert documented[title] - written[title] == OTHER_KINDS.get(title, set()), title


MARKED = [(kind, title) for kind, text in FILES.items() for title in re.findall(r"# zzz (\S+)", text)]
DRIVER = {
    "robot.locomotion": {"vx"},  # a table, below
    "robot.sensor": {"odometry", "drift", "jump", "jump_every"},
    "robot.actuator": {"motors", "wheel_radius", "signs", "max_acceleration", "delay", "slip"},
}


@pytest.mark.parametrize(("kind", "title"), MARKED)
def test_every_key_that_a_loader_knows_is_documented(kind, title, tmp_path):
    text = FILES[kind].replace(f"# zzz {title}\n", "zzz = 1\n")
    with pytest.raises(InputError) as caught:
        load(kind, text, tmp_path)
    (fault,) = caught.value.faults
    known = set(re.search(r"has: (.*)\.$", fault.hint).group(1).split(", "))
    others = OTHER_KINDS.get(title, set())
    assert known - DRIVER.get(title, set()) - others == keys(title) - others


def test_every_drivers_parameters_are_documented():
    found = by_owner("Drivers")
    assert found == {name: {each.key for each in fields_of(p)} for name, p in {**SENSORS, **ACTUATORS}.items()}


@pytest.mark.parametrize("kind", ["sensor", "actuator"])
def test_every_key_of_the_driver_ros2_is_documented(kind):
    declared = declared_keys("ros2", kind)
    assert keys(f"{kind.capitalize()}s with driver ros2") == {each.key for each in fields_of(declared)}


def test_every_blocks_parameters_are_documented():
    found = by_owner("Blocks")
    common = found.pop("every Monitor")
    assert common == {each.key for each in fields_of(Monitor)}
    blocks = {**MONITORS, **ANALYZERS}.items()
    wanted = {name: {each.key for each in fields_of(cls)} - common for name, cls in blocks}
    assert {name: keys - common for name, keys in found.items()} == {
        name: keys for name, keys in wanted.items() if keys
    }


def tables(cls, title):
    """Declared classes of a file, each with the title of its table in the page."""
    yield title, cls
    for each in fields_of(cls):
        if each.is_key and isinstance(each.hint, type) and issubclass(each.hint, Value):
            yield from tables(each.hint, f"{title}.{each.key}")
        if (added := each.mark(Registered)) is not None:
            yield from ((f"{title}.{name}", added.cls(name)) for name in added.names)


@pytest.mark.parametrize(("title", "cls"), [pair for kind, cls in CLASSES.items() for pair in tables(cls, kind)])
def test_the_keys_of_a_declared_table_are_documented(title, cls):
    if title == "scenario.agent.success":  # a row of the table above it
        (text,) = [row[1] for row in rows("scenario.agent") if row[0] == "`success`"]
        assert all(re.search(rf"\b{key} = ", text) for key in keys_of(cls))
        return
    assert keys(title) - {"base"} == keys_of(cls)


def test_every_scripts_parameters_are_documented():
    scripts = {**SCRIPTED_ROBOTS, **SCRIPTED_OBJECTS}
    assert by_owner("Scripts of scripted actors") == {n: keys_of(c) for n, c in scripts.items()}


def test_the_places_of_blocks_and_names_are_the_tables():
    (monitor,) = [r[1] for r in rows("robot.monitor") if r[0] == "`class`"]
    (analyze,) = [r[1] for r in rows("robot.analyze") if r[0] == "`class`"]
    assert set(re.findall(r"`(\w+)`", monitor)) == set(MONITORS)
    assert set(re.findall(r"`(\w+)`", analyze)) == set(ANALYZERS)
