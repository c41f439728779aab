"""A project whose mission and node print in every way, when they are loaded and while they run."""

from pathlib import Path

_PRINT = """
import os, subprocess, sys

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Sequence

from rocs_bt.trees.nodes import SUCCESS, Instant
from rocs_bt.base.units import MetresPerSecond


def make_noise(where):
    print(f"print {where}", flush=True)
    os.write(1, f"fd 1 {where}\\n".encode())
    subprocess.run([sys.executable, "-c", f"print('child {where}')"])
    os.write(1, bytes([255, 0, 10]))


make_noise("import")
"""

_MISSION = f"""{_PRINT}
# It outlives the run, with the standard output and error of the run.
subprocess.Popen([sys.executable, "-c", "import time; time.sleep(ALIVE)"])


class Shout(Behaviour):
    def update(self):
        make_noise("tick")
        return Status.SUCCESS


def build(mission, *, goal: str = "goal", cruise: MetresPerSecond = 0.5):
    return Sequence("loud", memory=True, children=[Shout("shout"), mission.act("GoTo", goal=goal)])
"""

_NODE = f"""{_PRINT}
class Shout(Instant):
    \"\"\"Prints.\"\"\"

    def update(self):
        make_noise("tick")
        return SUCCESS
"""

_SCENARIO = """base = "exp1"
[[agent]]
name = "R2"
mission = "loud"
"""

WAYS = ("print", "fd 1", "child")
"""First words of the lines that are printed at each of `import` and `tick`."""


def write_noisy_project(folder: Path, *, alive: float = 0.0) -> Path:
    """Write a project with the scenario `loud`, its mission `loud` and a node.

    Args:
        folder: Folder of the project.
        alive: Time for which a process lives that the mission starts [s].
    """
    for name in ("scenarios", "planners/missions", "planners/nodes"):
        (folder / name).mkdir(parents=True)
    (folder / "scenarios" / "loud.toml").write_text(_SCENARIO)
    (folder / "planners" / "missions" / "loud.py").write_text(_MISSION.replace("ALIVE", str(alive)))
    (folder / "planners" / "nodes" / "shout.py").write_text(_NODE)
    return folder
