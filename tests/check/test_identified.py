"""A robot that moves otherwise than its base has no measured values until it is identified itself."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.check import check_content

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
