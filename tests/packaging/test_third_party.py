"""A package beside rocs_bt adds a command, a driver and a node by its entry points alone (examples/package)."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from .. import needs

PACKAGE = Path(__file__).resolve().parents[2] / "examples" / "package"
ROBOT = """
format = "robot/3"
base = "pioneer_p3dx_ros2"
doc = "It feels the heat."

[[sensor]]
name = "heat"
driver = "thermometer"
port = "heat.txt"
signal = "battery"
monitor = "heat"

[[monitor]]
name = "heat"
class = "BatteryMonitor"
sensors = ["heat"]
"""
MISSION = """<root BTCPP_format="4"><BehaviorTree ID="warm">
  <Warmer port="heat.txt" than="20"/>
</BehaviorTree></root>
"""


@pytest.fixture(scope="module")
def rocs_bt(tmp_path_factory):
    """Runs a command of rocs_bt in a project, with the package installed in a folder of the path."""
    needs.package("hatchling")
    target, project = tmp_path_factory.mktemp("installed"), tmp_path_factory.mktemp("project")
    offline = ("--no-deps", "--no-build-isolation", "--no-index")
    subprocess.run([sys.executable, "-m", "pip", "install", "-q", *offline, "--target", target, PACKAGE], check=True)
    for name, text in {
        "robots/warm/robot.toml": ROBOT,
        "planners/missions/warm.xml": MISSION,
        "heat.txt": "25",
    }.items():
        (project / name).parent.mkdir(parents=True, exist_ok=True)
        (project / name).write_text(text)

    def call(*arguments: str) -> str:
        environment = {**os.environ, "PYTHONPATH": str(target)}
        done = subprocess.run(
            [sys.executable, "-m", "rocs_bt", *arguments], cwd=project, env=environment, capture_output=True, text=True
        )
        return done.stdout + done.stderr

    call.project = project
    return call


def test_its_command_is_listed_and_runs(rocs_bt):
    assert "Print the temperature at PORT." in rocs_bt("--help")
    assert rocs_bt("thermometer", "heat.txt") == "25 °C\n"


def test_its_driver_has_keys_and_a_misspelt_name_suggests_it(rocs_bt):
    file = rocs_bt.project / "robots/warm/robot.toml"
    assert "error" not in rocs_bt("check", str(file))
    file.write_text(ROBOT.replace('"thermometer"', '"thermometre"'))
    assert "Did you mean 'thermometer'" in rocs_bt("check", str(file))
    file.write_text(ROBOT.replace("port =", "prt ="))
    assert "needs 'port'" in rocs_bt("check", str(file))


def test_its_node_is_in_missions_of_every_dialect(rocs_bt):
    for dialect in ("rocs", "nav2"):
        shown = rocs_bt("show", "warm", "--nodes", dialect)
        assert "Warmer" in shown
        assert "error" not in shown
