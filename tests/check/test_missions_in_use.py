"""A mission is judged in the scenarios that use it, with their robots; alone, what depends on the robot is noted."""

from __future__ import annotations

from pathlib import Path

import pytest

from rocs_bt import run
from rocs_bt.catalog import Catalog
from rocs_bt.check import check_content

ROBOT = """format = "robot/3"
base = "pioneer_p3dx"
doc = "With a thermometer."
[[sensor]]
name = "thermometer"
driver = "sensors.py:Thermometer"
rate = "20 Hz"
signal = "temperature"
monitor = "sensors.py:Warmth"
"""
SENSORS = """from rocs_bt import Monitor, Signal
from rocs_bt.devices.mujoco import MujocoSensor
from rocs_bt.base.units import LENGTH


class Thermometer(MujocoSensor):
    def sample(self):
        return [0.5]


class Warmth(Monitor):
    def signals(self):
        return [Signal("temperature", 1, (LENGTH,), (0.0, 9.0), self.max_age)]

    def interpret(self, readings):
        return {"temperature": readings["thermometer"].values}
"""
XML = """<root BTCPP_format="4"><BehaviorTree ID="warm">
  <Sequence><When expression="{condition}"/><RetryUntilSuccessful num_attempts="{attempts}"><AlwaysSuccess/>
  </RetryUntilSuccessful></Sequence>
</BehaviorTree></root>
"""
PYTHON = '''"""Wait for warmth."""


def build(mission):
    """One condition."""
    return mission.when("{condition}")
'''
SCENARIO = """format = "scenario/2"
doc = "Wait for warmth."
world = "arena_box"
duration = "5 s"
[[agent]]
name = "R1"
robot = "{robot}"
mission = "warm"
x = "1 m"
y = "-1 m"
"""


@pytest.fixture(params=["xml", "py"])
def project(request, tmp_path: Path) -> Path:
    for name in ("planners/missions", "scenarios", "robots/warm"):
        (tmp_path / name).mkdir(parents=True)
    (tmp_path / "robots/warm/robot.toml").write_text(ROBOT)
    (tmp_path / "robots/warm/sensors.py").write_text(SENSORS)
    (tmp_path / f"planners/missions/warm.{request.param}").write_text("")
    write(tmp_path)
    return tmp_path


def mission_of(project: Path) -> Path:
    (file,) = (project / "planners" / "missions").glob("warm.*")
    return file


def write(project: Path, condition: str = "temperature &lt; 3 m", attempts: str = "2") -> None:
    file = mission_of(project)
    if file.suffix == ".py":
        file.write_text(PYTHON.format(condition=condition.replace("&lt;", "<")))
    else:
        file.write_text(XML.format(condition=condition, attempts=attempts))


def use(project: Path, robot: str) -> Path:
    file = project / "scenarios" / "warm.toml"
    file.write_text(SCENARIO.format(robot=robot))
    return file


def checked(*paths: Path) -> list[str]:
    return [str(fault) for fault in check_content(paths).faults]


def test_signals_of_an_own_sensor_are_known_to_its_robot(project):
    use(project, "warm")
    assert checked(project) == []
    assert checked(mission_of(project)) == []
    assert run("warm", Catalog(project)).success


def test_a_robot_without_the_signal_is_an_error_once(project):
    scenario = use(project, "jackal")
    for paths in ((project,), (mission_of(project),), (scenario,)):
        found = [text for text in checked(*paths) if "no signal or alias is named 'temperature'" in text]
        assert len(found) == 1, found
        assert ": note: " not in found[0]


def test_alone_it_fits_a_robot_of_the_project(project):
    assert checked(mission_of(project)) == []


def test_alone_an_unknown_signal_is_only_noted(project):
    write(project, "moisture &lt; 3 m")
    findings = check_content([mission_of(project)])
    (fault,) = findings.faults
    assert fault.note
    assert "not judged, because no scenario uses this mission" in fault.message
    assert not findings.has_errors


@pytest.mark.parametrize("used", [False, True])
def test_faults_that_do_not_depend_on_the_robot_are_errors(project, used):
    if mission_of(project).suffix == ".py":
        write(project, "temperature &lt; 3 kg")
    else:
        write(project, attempts="two")
    if used:
        use(project, "warm")
    assert check_content([mission_of(project)]).has_errors
    assert check_content([project]).has_errors


SHARED = """<root BTCPP_format="4"><BehaviorTree ID="part"><Sequence>
  <RetryUntilSuccessful num_attempts="{n}"><GoTo goal="{where}"/></RetryUntilSuccessful>
</Sequence></BehaviorTree></root>
"""
USER = """<root BTCPP_format="4"><BehaviorTree ID="whole">
  <SubTree ID="part" where="corner" n="%s"/>
</BehaviorTree></root>
"""


@pytest.mark.parametrize(("given", "faults"), [("2", 0), ("two", 1)])
def test_a_tree_that_others_use_gets_its_keys_from_them(tmp_path, given, faults):
    missions = tmp_path / "planners" / "missions"
    missions.mkdir(parents=True)
    (missions / "part.xml").write_text(SHARED)
    (missions / "whole.xml").write_text(USER % given)
    assert len(checked(missions)) == faults
    assert not [text for text in checked(missions / "part.xml") if "no node writes it" in text]
    (missions / "whole.xml").unlink()
    assert len([text for text in checked(missions / "part.xml") if "no node writes it" in text]) == 2
