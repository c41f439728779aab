"""Faults of a robot as an agent of a scenario, at the lines of the scenario."""

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.catalog import Catalog

SCENARIO = """format = "scenario/2"
world = "arena"
[[place]]
name = "{place}"
x = "0 m"
y = "0 m"
agents = ["{knows}"]
[[agent]]
name = "{agent}"
robot = "own"
mission = "go_to"
x = "0 m"
y = "0 m"
[[agent]]
name = "R9"
robot = "jackal"
mission = "go_to"
x = "1 m"
y = "0 m"
"""
ROBOT = """format = "robot/3"
base = "pioneer_p3dx"
[[actuator]]
name = "wheels"
max_command_age = "{age} s"
"""


def faults(folder, place="goal", agent="R2", knows="R2", age=0.2):
    for name in ("scenarios", "robots/own"):
        (folder / name).mkdir(exist_ok=True, parents=True)
    (folder / "robots/own/robot.toml").write_text(ROBOT.format(age=age))
    file = folder / "scenarios/own.toml"
    file.write_text(SCENARIO.format(place=place, agent=agent, knows=knows))
    try:
        Catalog(folder).load_scenario("own")
    except InputError as error:
        return [(fault.line, fault.message) for fault in error.faults]
    return []


def test_names_of_an_agent_its_devices_and_its_places_differ(tmp_path):
    assert faults(tmp_path) == []
    taken = "the name '{0}' is taken by the {1} '{0}' of own."
    assert faults(tmp_path, place="sonar") == [(3, taken.format("sonar", "sensor"))]
    assert faults(tmp_path, agent="wheels", knows="wheels") == [(8, taken.format("wheels", "actuator"))]
    assert faults(tmp_path, place="sonar", knows="R9") == []  # a robot without sonars


@pytest.mark.parametrize(("age", "found"), [(0.2, 0), (0.05, 0), (0.04, 1)])
def test_commands_are_not_older_than_a_control_period(tmp_path, age, found):
    said = [each for _, each in faults(tmp_path, age=age)]
    assert len(said) == found
    assert all(f"the actuator 'wheels' goes to neutral {age} s after a command" in each for each in said)
