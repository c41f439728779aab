"""A user's own drivers: keys by the fields of the class, and classes that raise, through `check` and `run`."""

from __future__ import annotations

from pathlib import Path

import pytest

DRIVER = """\
from rocs_bt import Monitor, Signal
from rocs_bt.devices.mujoco import MujocoActuator, MujocoSensor
from rocs_bt.base.units import LENGTH, Metres, PositiveMetres


class Beacon(MujocoSensor):
    reach: PositiveMetres
    steps: int = 2
    at: tuple[Metres, ...] = ()

    def set_up(self):
        self.said = [self.reach]

    def prepare(self, model, name):
        pass

    def sample(self) -> list[float]:
        return self.said


class Hear(Monitor):
    def signals(self):
        return [Signal("beacon", 1, (LENGTH,), (0.0, 100.0), self.max_age)]

    def interpret(self, readings):
        return {"beacon": readings["radio"].values}


class Idle(MujocoActuator):
    motors: tuple[str, ...]

    def set_up(self):
        self.size, self.handle = len(self.motors), self.world.motors(self.robot, self.motors)

    def command(self, values):
        self.world.drive(self.handle, values)

    def neutral(self):
        self.world.drive(self.handle, [0.0] * self.size)
"""

SENSOR = """
[[sensor]]
name = "radio"
driver = "beacon.py:Beacon"
signal = "beacon"
monitor = "beacon.py:Hear"
reach = "150 cm"
"""


@pytest.fixture
def beacon(project):
    """Puts a beacon on the robot of a new project, with its driver and its table changed; gives the robot's folder."""

    def put(code: tuple[str, str] = ("", ""), table: tuple[str, str] = ("", "")) -> Path:
        folder = project / "robots" / "rover"
        for old, text in ((code[0], DRIVER), (table[0], SENSOR)):
            assert old in text
        (folder / "beacon.py").write_text(DRIVER.replace(*code))
        with (folder / "robot.toml").open("a") as file:
            file.write(SENSOR.replace(*table))
        return folder

    return put


def line_of(file: Path, text: str) -> int:
    return next(i for i, line in enumerate(file.read_text().splitlines(), 1) if line.strip().startswith(text))


def test_keys_are_fields_in_si_units(beacon, rocs_bt):
    keys = 'steps = 3\nat = ["1 m", "20 cm"]\nreach ='
    folder = beacon(
        ("        self.said", "        if self.steps == 3: raise OSError(self.reach, self.at)\n        self.said"),
        ("reach =", keys),
    )
    told = rocs_bt("check", folder)
    assert told.code == 2
    assert "OSError: [Errno 1.5] (1.0, 0.2)" in told.out + told.err
    file = folder / "robot.toml"
    file.write_text(file.read_text().replace("steps = 3", "steps = 4"))
    assert rocs_bt("check").code == 0
    assert rocs_bt("run", "first", "--for", "1").code in (0, 1)


@pytest.mark.parametrize("bases", ["RangeCone", "RangeCone, MujocoSensor", "MujocoSensor, RangeCone"])
def test_a_driver_that_extends_a_shipped_one_takes_its_keys_and_its_own(project, rocs_bt, bases):
    folder = project / "robots" / "rover"
    (folder / "deaf.py").write_text(f"""\
from rocs_bt.devices.mujoco import MujocoSensor
from rocs_bt.devices.simulated import RangeCone


class Deaf({bases}):
    deaf: bool = False
""")
    toml = folder / "robot.toml"
    toml.write_text(toml.read_text().replace('driver = "range_cone"', 'driver = "deaf.py:Deaf"\ndeaf = true'))
    told = rocs_bt("check")
    assert told.code == 0, told.out + told.err
    toml.write_text(toml.read_text().replace("half_angle =", "half_angel ="))
    told = rocs_bt("check")
    assert "no parameter is named 'half_angel'. Did you mean 'half_angle'?" in told.out + told.err


def test_elements_of_a_sensor_that_is_not_in_mujoco_are_refused(beacon, rocs_bt):
    shipped = "from rocs_bt.devices.simulated import SimulatedSensor\n\nclass Beacon(SimulatedSensor)"
    folder = beacon(("class Beacon(MujocoSensor)", shipped))
    told, line = rocs_bt("check", folder), line_of(folder / "robot.toml", 'name = "radio"') - 1
    assert told.code == 2
    assert f"robot.toml:{line}: 'Beacon' has a method" in told.text
    assert "'Beacon' has a method 'prepare' and does not extend MujocoSensor, so nothing calls it." in told.text


def test_a_driver_that_replaces_an_inherited_one_does_not_inherit_its_keys(beacon, project, rocs_bt):
    beacon()
    folder = project / "robots" / "quiet"
    folder.mkdir()
    (folder / "robot.toml").write_text(
        'format = "robot/3"\nbase = "rover"\n[[actuator]]\nname = "wheels"\ndriver = "beacon.py:Idle"\n'
        'motors = ["left_motor", "right_motor"]\n'
    )
    (folder / "beacon.py").write_text(DRIVER)
    told = rocs_bt("check", folder)
    assert told.code == 0, told.out + told.err


RAISING = {
    "import": ("class Beacon(", "1 / 0\nclass Beacon("),
    "exit": ("class Beacon(", "raise SystemExit(7)\nclass Beacon("),
    "constructor": ("self.said = [self.reach]", "self.said = [{}[self.reach]]"),
    "prepare": ("        pass", "        model.body('nose').pos[0] = 1"),
    "sample": ("return self.said", "return [self.said[0] / 0]"),
    "interpret": ('return {"beacon": readings["radio"].values}', 'return {"beacon": readings["radios"].values}'),
    "signals": ("return [Signal(", "return [Sgnal("),
}
ODD = {
    "sample none": ("return self.said", "return None"),
    "sample texts": ("return self.said", 'return ["far"]'),
    "sample number": ("return self.said", "return self.reach"),
    "interpret none": ('return {"beacon": readings["radio"].values}', "return 3"),
    "interpret other": ('return {"beacon": readings["radio"].values}', 'return {"nothing": [1.0]}'),
    "interpret long": ('return {"beacon": readings["radio"].values}', 'return {"beacon": [1.0, 2.0]}'),
    "signals none": ("return [Signal(", "return None and [Signal("),
    "signals texts": ("return [Signal(", 'return ["beacon"] or [Signal('),
}


@pytest.mark.parametrize("code", RAISING.values(), ids=RAISING.keys())
def test_check_reports_what_an_own_class_raises_at_its_line_and_goes_on(beacon, project, rocs_bt, code):
    file = beacon(code) / "beacon.py"
    scenario = project / "scenarios" / "first.toml"
    scenario.write_text(scenario.read_text().replace('"60 s"', '"60 m"'))  # another fault, which must not be lost
    told = rocs_bt("check")
    assert told.code == 2, told.out + told.err
    assert "Traceback" not in told.out + told.err
    assert f"{file}:{line_of(file, code[1].splitlines()[0].strip())}: " in told.out + told.err
    assert "duration must be in s" in told.out + told.err


@pytest.mark.parametrize("code", ODD.values(), ids=ODD.keys())
def test_check_reports_what_an_own_class_returns_wrongly_at_the_class(beacon, rocs_bt, code):
    file = beacon(code) / "beacon.py"
    told = rocs_bt("check")
    assert told.code == 2, told.out + told.err
    assert "Traceback" not in told.out + told.err
    name = "Beacon" if "self.said" in code[0] else "Hear"
    assert f"{file}:{line_of(file, f'class {name}')}: {name} of this file raised" in told.out + told.err
