"""A simulation that diverges is an error with its time, and MuJoCo leaves no log in the current folder."""

import re
import subprocess
import sys

import pytest

SCENARIO = """
format = "scenario/2"
base = "exp1"
doc = "A push that no physics survives."

[[push]]
robot = "R2"
at = "0.2 s"
force = { forward = "100000 N" }
duration = "60 s"
"""
WARNED = """
from rocs_bt.devices.mujoco.library import mujoco
model = mujoco.MjModel.from_xml_string(
    "<mujoco><worldbody><body><joint name='j'/><geom size='1'/></body></worldbody>"
    "<actuator><motor joint='j'/></actuator></mujoco>"
)
data = mujoco.MjData(model)
data.ctrl[0] = float("nan")
mujoco.mj_step(model, data)
data.qvel[0] = 1e20
mujoco.mj_step(model, data)
"""


@pytest.mark.soak
@pytest.mark.parametrize(("command", "code"), [("run diverge --no-report", 3), ("compare tree --scenario diverge", 1)])
def test_a_command_that_diverges_says_when_and_leaves_no_log(rocs_bt, tmp_path, command, code):
    (tmp_path / "scenarios").mkdir()
    (tmp_path / "scenarios/diverge.toml").write_text(SCENARIO)
    done = rocs_bt(*command.split())
    assert done.code == code, done
    assert re.search(r"the simulation became unstable by \d+\.\d\d s", done.text)
    assert not list(tmp_path.rglob("MUJOCO_LOG*"))


def test_mujocos_other_warnings_are_printed_once_and_leave_no_log(tmp_path):
    done = subprocess.run([sys.executable, "-c", WARNED], cwd=tmp_path, capture_output=True, text=True, check=True)
    (line,) = done.stderr.splitlines()
    assert line.startswith("MuJoCo: ")
    assert "CTRL" in line
    assert list(tmp_path.iterdir()) == []
