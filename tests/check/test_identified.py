"""A robot that moves otherwise than its base has no measured values until it is identified itself."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from rocs_bt.base.toml_edit import with_values
from rocs_bt.catalog import Catalog, RobotSpec
from rocs_bt.check import check_content
from rocs_bt.check.identified import as_quantities, corrections, differences
from rocs_bt.declare import replaced
from rocs_bt.simulation.identified_file import IdentifiedFile, WheelFigures, model_hash, read_identified

SHIPPED = Catalog().shipped / "robots"
BASED = 'format = "robot/3"\nbase = "pioneer_p3dx"\ndoc = "As its base."\n'
DELAY = '[[actuator]]\nname = "wheels"\ndelay = "0.4 s"\n'


def not_identified(folder: Path, text: str) -> list[str]:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.toml").write_text(text)
    found = [str(fault) for fault in check_content([folder / "robot.toml"]).faults]
    return [fault for fault in found if "is not identified" in fault]


@pytest.mark.parametrize(
    ("change", "warned"),
    [
        ("", False),
        ('[locomotion]\nlag = "0.2 s"\n', False),  # compared with the values of the base
        ('[[sensor]]\nname = "sonar"\nrate = "10 Hz"\n', False),
        (DELAY, True),
        ('model = "own.xml"\n', True),
    ],
)
def test_a_robot_that_moves_otherwise_than_its_base_is_not_identified(tmp_path, change, warned):
    folder = tmp_path / "robots" / "own"
    folder.mkdir(parents=True)
    model = (SHIPPED / "pioneer_p3dx" / "robot.xml").read_text()
    (folder / "own.xml").write_text(model.replace("<mujoco", "<!-- slippery --><mujoco", 1))
    found = not_identified(folder, BASED + change)
    assert len(found) == warned, found
    if warned:
        assert "robot.toml:2:1: warning: 'own' is not identified" in found[0]
        assert "rocs-bt identify own" in found[0]


def test_its_own_measured_values_end_the_warning(tmp_path):
    folder = tmp_path / "robots" / "own"
    folder.mkdir(parents=True)
    shutil.copy(SHIPPED / "pioneer_p3dx" / "identified.toml", folder)
    assert not not_identified(folder, BASED + DELAY)
    found = [str(fault) for fault in check_content([folder / "robot.toml"]).faults]
    assert any("was measured with another model or actuator" in fault for fault in found)


def test_every_shipped_robot_is_identified():
    found = [str(f) for file in sorted(SHIPPED.glob("*/robot.toml")) for f in check_content([file]).faults]
    assert not [fault for fault in found if "identif" in fault or "measured" in fault]


def derived(folder: Path, base: str) -> Path:
    """A robot of a project that is its base, with a comment and keys that must stay."""
    file = folder / "robots" / "mine" / "robot.toml"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(f'format = "robot/3"\nbase = "{base}"  # ours\ndoc = "Mine."\n', "utf-8")
    return file


def other_figures(random: np.random.Generator, measured: IdentifiedFile, robot: RobotSpec) -> IdentifiedFile:
    """Figures of a body that differs from the measured one in each value, as by worn tyres, load or other motors."""

    def worse(value: float, low: float, high: float) -> float:
        return value * float(random.uniform(low, high))

    axes = {}
    for axis, of in measured.axes.items():
        fits = of.latency is not None and random.random() < 0.7
        axes[axis] = replaced(
            of,
            max_speed=worse(of.max_speed, 0.4, 1.2),
            lag=worse(of.lag + 0.05, 0.2, 6.0),
            latency=worse(of.latency + 0.02, 0.2, 6.0) if fits else None,
            deceleration=worse(of.deceleration, 0.1, 2.0) if fits else None,
            stop_distance=worse(of.stop_distance, 0.3, 5.0),
        )
    wheels = measured.wheels
    if wheels is not None:
        size = worse(wheels.effective_wheel_separation, 0.6, 1.6)
        wheels = WheelFigures(effective_wheel_separation=size, icr_offset=float(random.uniform(-0.2, 0.2)))
    return replaced(measured, **axes, wheels=wheels, model=model_hash(robot))


@pytest.mark.parametrize("base", ["pioneer_p3dx", "jackal", "quadrotor"])
def test_a_stop_distance_without_a_braking_model_is_compared_from_the_maximum_speed(base: str) -> None:
    robot, measured = Catalog().load_robot(base), read_identified(SHIPPED / base / "identified.toml")
    axis, top = measured.axes["vx"], robot.locomotion.axis_limits("vx").max_speed
    longer = replaced(axis, latency=None, deceleration=None, max_speed=1.5 * top, stop_distance=6.0)
    (told,) = [each.message for each in differences(robot, replaced(measured, vx=longer)) if "too late" in each.message]
    needed = float(re.search(r"needs ([\d.]+) m", told)[1])
    latest = 0.1 * top  # of a reading of the wheels, at most
    assert 6.0 / 1.5**2 < needed < 6.0 / 1.5**2 + latest


@pytest.mark.parametrize("base", [file.parent.name for file in sorted(SHIPPED.glob("*/identified.toml"))])
def test_the_corrections_end_every_difference_that_values_can_end(tmp_path: Path, base: str) -> None:
    random, catalog = np.random.default_rng(sum(map(ord, base))), Catalog(tmp_path)
    for _ in range(4):
        file = derived(tmp_path, base)
        robot = catalog.load_robot(str(file))
        measured = other_figures(random, read_identified(SHIPPED / base / "identified.toml"), robot)
        values = as_quantities(corrections(robot, measured))
        text = with_values(file.read_text(), {("locomotion", *k.split(".")): v for k, v in values.items()}, file, "m")
        assert text.startswith(file.read_text())
        file.write_text(text, "utf-8")
        left = list(differences(catalog.load_robot(str(file)), measured))
        assert not [difference for difference in left if difference.values], (values, left)
        assert not corrections(catalog.load_robot(str(file)), measured)
