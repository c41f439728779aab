"""Identify finds what a model was made with; robot.toml and identified.toml hold what it finds, and check compares."""

from __future__ import annotations

import json
import os
import shutil
from functools import cache
from pathlib import Path

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Twist3
from rocs_bt.catalog import Catalog, content_hash
from rocs_bt.check import Findings, check_content
from rocs_bt.cli.main import call
from rocs_bt.declare import given_of, replaced, values_of
from rocs_bt.simulation.identified_file import identified_path, model_hash, read_identified
from rocs_bt.simulation.identify import Identified, identify

CATALOG = Catalog()
ROBOTS = [r.name for r in CATALOG.list("robot") if (r.path.parent / "identified.toml").exists()]
QUICK = "pioneer_p3dx"
EACH = [pytest.param(r, marks=() if r == QUICK else pytest.mark.soak) for r in ROBOTS]


@cache
def found(robot: str) -> Identified:
    return identify(CATALOG.load_robot(robot), CATALOG)


def test_each_model_that_is_shipped_was_measured() -> None:
    models = {r.path.parent.name for r in CATALOG.list("robot") if (r.path.parent / "robot.xml").exists()}
    assert (
        set(ROBOTS)
        == models
        >= {QUICK, "summit_xl", "jackal", "quadruped", "rosbot_xl", "robotino", "turtlebot3_burger"}
    )


def test_a_differential_drives_wheel_separation_is_where_its_wheels_are() -> None:
    wheels = found("pioneer_p3dx").wheels
    assert wheels is not None
    assert wheels.effective_wheel_separation == pytest.approx(2 * 0.1655, rel=0.003)
    assert wheels.slowest_turn == pytest.approx(1.0, abs=0.002)
    assert wheels.icr_offset == pytest.approx(0.0, abs=0.01)


def test_a_skid_drives_effective_wheel_separation_is_far_wider_than_built_and_near_the_vendors() -> None:
    wheels = measured("summit_xl").wheels
    assert wheels is not None
    assert wheels.effective_wheel_separation == pytest.approx(0.408 * (1.0 + (0.446 / 0.408) ** 2), rel=0.01)  # Coulomb
    assert wheels.effective_wheel_separation == pytest.approx(1.0, rel=0.15)
    assert (jackal := measured("jackal").wheels) is not None
    assert jackal.icr_offset > 0.04


def measured(robot: str):
    path = identified_path(CATALOG.load_robot(robot))
    assert path is not None
    return read_identified(path)


@pytest.mark.parametrize("robot", EACH)
def test_identified_toml_is_what_is_found(robot: str) -> None:
    file, now = measured(robot), found(robot)
    assert file.axes.keys() == now.axes.keys() == set(CATALOG.load_robot(robot).locomotion.axes)
    for axis, of in now.axes.items():
        then = file.axes[axis]
        assert then.max_speed == pytest.approx(of.max_speed, rel=0.01)
        assert then.lag == pytest.approx(of.lag, abs=0.002)
        assert then.stop_distance == pytest.approx(of.stop_distance, rel=0.02)
    if now.wheels is not None:
        assert file.wheels is not None
        assert file.wheels.effective_wheel_separation == pytest.approx(now.wheels.effective_wheel_separation, rel=0.005)
        assert file.wheels.icr_offset == pytest.approx(now.wheels.icr_offset, abs=0.002)


@pytest.mark.parametrize("robot", EACH)
def test_the_stop_distance_of_robot_toml_is_what_braking_takes(robot: str) -> None:
    locomotion = CATALOG.load_robot(robot).locomotion
    for axis, of in found(robot).axes.items():
        assert len(of.braking) >= 5
        for b in of.braking if axis in ("vx", "vy") else ():
            reading = b.distance + b.speed * 0.05  # what was seen may have come just after a reading
            twist = Twist3(b.speed) if axis == "vx" else Twist3(0.0, b.speed)
            assert 0.95 * reading - 0.01 <= locomotion.stop_distance(twist) <= 1.15 * reading + 0.01


@pytest.mark.parametrize("robot", ROBOTS)
def test_what_robot_toml_says_is_what_was_measured(robot: str) -> None:
    spec, file = CATALOG.load_robot(robot), measured(robot)
    numbers, vx = given_of(spec.motion), file.axes["vx"]
    assert file.model == model_hash(spec)
    assert vx.max_speed == pytest.approx(spec.locomotion.speed_limit, rel=0.01)
    response = spec.locomotion.response
    assert vx.lag == pytest.approx(response.late, abs=0.003 if response.late else 0.02)
    if file.wheels is not None:
        assert response.latency == pytest.approx(0.05 + vx.latency, abs=0.002)  # readings come every 0.05 s
        assert response.deceleration["vx"] == pytest.approx(vx.deceleration, rel=0.01)
        width = numbers.get("effective_wheel_separation", numbers.get("wheel_separation"))
        assert width == pytest.approx(file.wheels.effective_wheel_separation, rel=0.005)
        if "icr_offset" in numbers:
            assert numbers["icr_offset"] == pytest.approx(file.wheels.icr_offset, abs=0.002)


def test_the_same_model_gives_the_same_numbers() -> None:
    assert identify(CATALOG.load_robot(QUICK), CATALOG) == found(QUICK)


@pytest.fixture
def rover(tmp_path: Path) -> Path:
    """A copy of the Pioneer in a project."""
    shutil.copytree(CATALOG.find("robot", QUICK).path.parent, tmp_path / "robots" / "rover")
    return tmp_path / "robots" / "rover" / "robot.toml"


def changed(robot: Path, old: str, new: str, file: str = "robot") -> Findings:
    """What check finds after a change of the robot.toml or of another file beside it."""
    path = robot.with_name(f"{file}.toml")
    text = path.read_text("utf-8")
    assert text.count(old) == 1
    path.write_text(text.replace(old, new), "utf-8")
    return check_content([robot])


def line_of(file: Path, text: str) -> int:
    return next(i for i, line in enumerate(file.read_text("utf-8").splitlines(), 1) if line.startswith(text))


def test_the_command_tells_people_and_programs_the_same_and_writes_the_file(
    rover: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = rover.with_name("identified.toml")
    shipped = file.read_text("utf-8")
    file.unlink()
    assert call(["identify", str(rover), "--json", "--dry-run"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert {**told, "robot": QUICK} == json.loads(json.dumps(values_of(found(QUICK)), default=values_of))
    assert not file.exists()
    assert call(["identify", str(rover)]) == 0
    text = capsys.readouterr().out
    assert f"effective_wheel_separation  {told['wheels']['effective_wheel_separation']:.3f} m" in text
    assert f"  vx      1.20 m/s   0.016 s  {told['axes']['vx']['latency']:.3f} s     3.00 m/s2        0.243 m" in text
    assert f"Written to {file}" in text
    assert file.read_text("utf-8") == shipped
    assert call(["identify", "nobody"]) == 2


def test_a_folder_that_cannot_be_written_is_an_error_after_the_report(
    rover: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "replace", refuse)
    monkeypatch.setattr(Path, "replace", refuse)
    monkeypatch.setattr("rocs_bt.simulation.identify.identify", lambda *_: found(QUICK))
    shipped = rover.with_name("identified.toml").read_text("utf-8")
    assert call(["identify", str(rover)]) == 2
    out, err = capsys.readouterr()
    assert "stop distance" in out
    assert f"{rover.with_name('identified.toml')}: cannot write the file: Permission denied. Copy" in err
    assert rover.with_name("identified.toml").read_text("utf-8") == shipped


def test_a_wrong_wheel_separation_is_found_by_check(rover: Path) -> None:
    assert not check_content([rover]).faults
    (fault,) = changed(rover, 'wheel_separation = "0.331 m"', 'wheel_separation = "0.381 m"').faults
    assert fault.warning
    assert not fault.note
    assert (fault.file, fault.line) == (rover, line_of(rover, "wheel_separation"))
    assert fault.message == (
        "wheel_separation is 0.381 m, but 0.3315 m was measured: the robot turns 1.15 times as fast as commanded."
    )


@pytest.mark.parametrize(
    ("file", "old", "new", "line", "message"),
    [
        (
            "robot",
            'latency = "0.053 s"',
            'latency = "0.01 s"',
            "latency",
            "from 1.2 m/s along vx within 0.251 m",
        ),
        ("robot", "[body]", 'delay = "0.1 s"\n[body]', "delay", "delay + lag is 0.1 s, but 0.0158 s was measured"),
        ("robot", 'length = "0.455 m"', 'length = "0.3 m"', "length", "paths lead too near to obstacles"),
        ("robot", 'width = "0.381 m"', 'width = "0.6 m"', "width", "paths avoid gaps"),
        ("identified", '"2.997 m/s2"', '"2 m/s2"', "deceleration", "it brakes too late"),
        ("identified", '"1.198 m/s"', '"0.9 m/s"', "[locomotion]", "the robot reached 0.9 m/s: it cannot follow"),
        ("identified", '"0.0065 m"', '"0.1 m"', "[locomotion]", "icr_offset is 0 m, but 0.1 m was measured"),
        ("identified", 'model = "', 'model = "0', "model", "was measured with another model or actuator"),
    ],
)
def test_a_harmful_difference_is_a_warning_at_its_line(
    rover: Path, file: str, old: str, new: str, line: str, message: str
) -> None:
    (fault,) = changed(rover, old, new, file).faults
    assert fault.warning
    assert (fault.file, fault.line) == (rover, line_of(rover, line))
    assert message in fault.message


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('latency = "0.053 s"', 'latency = "0.2 s"'),
        ('deceleration = "3.0 m/s2"', 'deceleration = "1.5 m/s2"'),
        ("[body]", 'max_wheel_speed = "0.5 m/s"\n[body]'),
    ],
)
def test_margins_are_no_fault(rover: Path, old: str, new: str) -> None:
    assert not changed(rover, old, new).faults


def test_a_robot_without_a_model_uses_the_figures_of_its_base(rover: Path) -> None:
    based = rover.parent.parent / "based" / "robot.toml"
    based.parent.mkdir()
    based.write_text('format = "robot/3"\nbase = "rover"\n[locomotion]\nwheel_separation = "0.4 m"\n', "utf-8")
    (fault,) = check_content([based]).faults
    assert (fault.line, fault.message[:24]) == (4, "wheel_separation is 0.4 ")


def test_another_model_or_driver_must_be_measured_again(rover: Path) -> None:
    based = rover.parent.parent / "based" / "robot.toml"
    based.parent.mkdir()
    wheels = '[[actuator]]\nname = "wheels"\nmax_acceleration = "2 m/s2"\n[locomotion]\ndeceleration = "2 m/s2"\n'
    based.write_text(f'format = "robot/3"\nbase = "rover"\n{wheels}', "utf-8")
    (fault,) = check_content([based]).faults  # the figures of its base are no figures of this robot
    assert "'based' is not identified" in fault.message
    own = based.with_name("identified.toml")
    shutil.copy(rover.with_name("identified.toml"), own)
    (fault,) = check_content([based]).faults
    assert (fault.line, fault.hint) == (2, "Run: rocs-bt identify based")
    model = rover.with_name("robot.xml")
    model.write_text(model.read_text("utf-8") + "<!-- other -->", "utf-8")
    (fault,) = check_content([rover]).faults
    assert "another model" in fault.message


def test_a_faulty_file_is_an_error_with_its_line(rover: Path) -> None:
    (fault,) = changed(rover, '"1.198 m/s"', '"1.198 m"', "identified").faults
    assert not fault.warning
    assert (fault.file, fault.line) == (rover.with_name("identified.toml"), 6)


def test_identified_toml_is_no_part_of_the_content_that_a_recording_needs(rover: Path) -> None:
    catalog = Catalog(rover.parents[2])
    before = content_hash([catalog.find("robot", "rover")])
    rover.with_name("identified.toml").unlink()
    assert content_hash([catalog.find("robot", "rover")]) == before
    rover.write_text(rover.read_text("utf-8") + "\n", "utf-8")
    assert content_hash([catalog.find("robot", "rover")]) != before


# A body that hovers: by its inner loop, each axis follows with a first-order lag after a dead time, and brakes with a
# constant deceleration. A physics step moves the body by the speed at its end.
DELAY, LAG, STEP = 0.06, 0.02, 0.005
BRAKING = {"vx": 2.0, "vy": 1.0, "vz": 1.5, "wz": 4.0}
SPEEDS = {"vx": 1.0, "vy": 0.6, "vz": 0.5, "wz": 1.5}

BODY = """<mujoco model="drone">
  <worldbody>
    <body name="base" pos="0 0 0.3" gravcomp="1">
      <freejoint name="base"/>
      <inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>
      <geom name="hull" type="box" size="0.2 0.15 0.05"/>
      <site name="middle"/>
    </body>
  </worldbody>
  <actuator>
    <general name="x" site="middle" gear="1 0 0 0 0 0"/>
    <general name="y" site="middle" gear="0 1 0 0 0 0"/>
    <general name="z" site="middle" gear="0 0 1 0 0 0"/>
    <general name="turn" site="middle" gear="0 0 0 0 0 0.01"/>
  </actuator>
</mujoco>"""

DRIVER = f'''"""Driver of a body that hovers."""

from collections import deque

import numpy as np

from rocs_bt.devices.mujoco import MujocoActuator


class Hover(MujocoActuator):
    size = 4

    def set_up(self):
        self.controls = self.world.controls(self.robot, ["x", "y", "z", "turn"])
        self.coming = deque()
        self.target = self.speed = np.zeros(4)

    def command(self, values):
        self.coming.append((self.world.stamp + {DELAY}, np.array(values)))

    def neutral(self):
        self.command([0.0] * 4)

    def before_step(self, t):
        while self.coming and self.coming[0][0] <= t + 1e-6:
            self.target = self.coming.popleft()[1]
        world, robot, braking = self.world, self.robot, np.array({list(BRAKING.values())})
        wanted = (self.target - self.speed) / {LAG}
        slows = np.sign(self.speed) * wanted < 0.0
        self.speed = self.speed + np.where(slows, np.clip(wanted, -braking, braking), wanted) * world.step
        twist, up = world.twist(robot), world.data.qvel[world.body(robot).v + 2]
        world.set_controls(self.controls, (self.speed - [twist.forward, twist.left, up, twist.turn]) / world.step)
'''

DRONE = """format = "robot/3"
model = "robot.xml"
[locomotion]
kind = "flying"
actuator = "rotors"
delay = "0.06 s"
lag = "0.02 s"
latency = "0.115 s"
[locomotion.vx]
max_speed = "1 m/s"
max_acceleration = "1 m/s2"
deceleration = "2 m/s2"
[locomotion.vy]
max_speed = "0.6 m/s"
max_acceleration = "0.5 m/s2"
deceleration = "1 m/s2"
[locomotion.vz]
max_speed = "0.5 m/s"
max_acceleration = "1 m/s2"
deceleration = "1.5 m/s2"
[locomotion.wz]
max_speed = "1.5 rad/s"
max_acceleration = "6 rad/s2"
[[actuator]]
name = "rotors"
driver = "hover.py:Hover"
"""


@pytest.fixture
def drone(tmp_path: Path) -> Path:
    folder = tmp_path / "robots" / "drone"
    folder.mkdir(parents=True)
    for name, text in {"robot.toml": DRONE, "robot.xml": BODY, "hover.py": DRIVER}.items():
        (folder / name).write_text(text, "utf-8")
    return folder / "robot.toml"


def test_the_axes_of_a_body_that_takes_twists_are_found_as_it_was_built(
    drone: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call(["identify", str(drone)]) == 0
    axes = read_identified(drone.with_name("identified.toml")).axes
    assert axes.keys() == BRAKING.keys()
    for axis, of in axes.items():
        top = SPEEDS[axis]
        assert of.max_speed == pytest.approx(top, rel=0.01)
        assert of.lag == pytest.approx(DELAY + LAG - STEP, abs=0.001)
        assert of.latency == pytest.approx(DELAY, abs=0.002)
        assert of.deceleration == pytest.approx(BRAKING[axis], rel=0.02)
        assert of.stop_distance == pytest.approx(top * DELAY + top**2 / (2.0 * BRAKING[axis]), rel=0.02)
    told = capsys.readouterr().out
    assert "vz      0.50 m/s" in told
    assert "deceleration: depends on the declared one" in told
    assert not check_content([drone]).faults
    (fault,) = changed(drone, 'deceleration = "1 m/s2"', 'deceleration = "2 m/s2"').faults
    assert fault.line == line_of(drone, "[locomotion.vy]") + 3
    assert "along vy" in fault.message


def test_a_driver_that_takes_another_number_of_values_is_refused_at_the_axis(drone: Path) -> None:
    text, driver = drone.read_text("utf-8"), drone.with_name("hover.py")
    i, j, k = (text.index(f"[locomotion.{axis}]") for axis in ("vy", "vz", "wz"))
    drone.write_text((text[:i] + text[k:]).replace("flying", "twist"), "utf-8")
    driver.write_text(driver.read_text("utf-8").replace("size = 4", "size = 2"))
    assert not [fault for fault in check_content([drone]).faults if not fault.warning]
    wide = drone.parents[1] / "wide" / "robot.toml"
    wide.parent.mkdir()
    wide.write_text('format = "robot/3"\nbase = "drone"\n' + text[i:j], "utf-8")
    (fault,) = [fault for fault in check_content([wide]).faults if not fault.warning]
    assert fault.message == "Hover takes 2 values, but the locomotion has vx, vy, wz."
    assert (fault.file, fault.line) == (wide, 3)


def test_a_body_that_falls_or_does_not_move_is_refused(drone: Path) -> None:
    model = drone.with_name("robot.xml")
    catalog = Catalog(drone.parents[2])
    model.write_text(BODY.replace('gear="0 1 0 0 0 0"', 'gear="0 0 0 0 0 0"'), "utf-8")
    with pytest.raises(InputError, match=r"does not move along vy: commanded 0.6, reached 0\. Correct .* 'rotors'"):
        identify(catalog.load_robot("drone"), catalog)
    model.write_text(BODY.replace('gear="0 0 0 0 0 0.01"', 'gear="0 0 0 0 0 0"'), "utf-8")
    with pytest.raises(InputError, match=r"along wz: .* It does not turn on the spot, which the actions"):
        identify(catalog.load_robot("drone"), catalog)
    model.write_text(BODY.replace('gear="1 0 0 0 0 0"', 'gear="1 0 0 0 0.3 0"'), "utf-8")
    with pytest.raises(InputError, match=r"the robot fell over with the command 0\.35, 0, 0, 0"):
        identify(catalog.load_robot("drone"), catalog)


def test_a_body_that_begins_inside_the_floor_is_refused(drone: Path) -> None:
    model, catalog = drone.with_name("robot.xml"), Catalog(drone.parents[2])
    model.write_text(BODY.replace('pos="0 0 0.3"', 'pos="0 0 0.023"'), "utf-8")
    with pytest.raises(InputError, match=r"its geom 'hull' would begin 27 mm inside 'floor'") as caught:
        identify(catalog.load_robot("drone"), catalog)
    assert caught.value.faults[0].file == drone
    scenario = drone.parents[2] / "scenarios" / "sunk.toml"
    scenario.parent.mkdir()
    text = 'format = "scenario/2"\nworld = "plane"\nduration = "1 s"\n[[agent]]\nname = "D"\nmission = "go_to"\n'
    scenario.write_text(f'{text}robot = "drone"\nx = "0 m"\ny = "0 m"\n[agent.parameters]\ngoal = "there"\n', "utf-8")
    faults = [fault for fault in check_content([scenario]).faults if "27 mm inside 'floor'" in fault.message]
    assert [(fault.file, fault.line, fault.warning) for fault in faults] == [(scenario, 4, False)]


def test_a_braking_model_that_does_not_fit_is_not_written(
    rover: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rocs_bt.simulation.identify._MISFIT", -1.0)
    measured = identify(CATALOG.load_robot(QUICK), CATALOG).axes["vx"]
    assert (measured.latency, measured.deceleration) == (None, None)
    last = found(QUICK).axes["vx"].braking[-1]
    assert last.distance < measured.stop_distance == pytest.approx(found(QUICK).axes["vx"].stop_distance, rel=0.01)
    vx = replaced(found(QUICK).axes["vx"], latency=None, deceleration=None, stop_distance=0.6, misfit=4.9)
    odd = replaced(found(QUICK), axes={**found(QUICK).axes, "vx": vx})
    monkeypatch.setattr("rocs_bt.simulation.identify.identify", lambda *_: odd)
    assert call(["identify", str(rover)]) == 0
    assert "do not describe the braking along vx" in capsys.readouterr().out
    axes = read_identified(rover.with_name("identified.toml")).axes
    assert (axes["vx"].latency, axes["vx"].deceleration, axes["vx"].stop_distance) == (None, None, 0.6)
    assert axes["wz"].deceleration is not None
    (fault,) = check_content([rover]).faults
    assert fault.line == line_of(rover, "deceleration")
    assert "but it needs 0.66 m: it brakes too late" in fault.message
