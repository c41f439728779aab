"""EXP1 on the robot in plain rclpy, through `rocs_bt.drive`."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rocs_bt import ListSink, RunResult, drive
from rocs_bt.catalog import Catalog

from .robot_process import RobotProcess

ROBOT = Path(__file__).with_name("robot.toml").read_text()
OPTIONS = ("--stamped", "--namespace", "r1")  # of the robot of robot.toml
SCENARIO = 'format = "scenario/2"\nbase = "exp1"\n[[agent]]\nname = "R2"\nrobot = "own"\n'
GOAL = 0.1  # [m] tolerance of EXP1
HERE = {"rclpy": "here", "dds": "jazzy"}


def write_project(folder: Path, **changes: str) -> Catalog:
    """A project with the scenario `real` and the robot of robot.toml.

    Args:
        folder: Folder of the project.
        changes: Values of keys, as `transport="dds"`; those of devices replace that of the first device with the key,
            or with `DEVICE_KEY` that of the device, as `wheels_reliability="best_effort"`.
    """
    text = ROBOT
    for name, value in changes.items():
        device, _, key = name.rpartition("_")
        begin = text.index(f'name = "{device}"') if device else 0
        at = text.index(f"\n{key} = ", begin) + 1
        text = f'{text[:at]}{key} = "{value}"{text[text.index(chr(10), at) :]}'
    for path, content in (("robots/own/robot.toml", text), ("scenarios/real.toml", SCENARIO)):
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(content)
    return Catalog(folder)


def drive_exp1(folder: Path, sink: ListSink | None = None, *, duration: float = 60.0, **changes: str) -> RunResult:
    """Drive EXP1's mission with files in the folder; see `write_project`."""
    catalog = write_project(folder, **changes)
    return drive("real", catalog, duration=duration, out=folder / "out", sinks=[] if sink is None else [sink])


def start_of(seed: int) -> list[str]:
    """Options of the robot for one episode: EXP1's start with its jitter, and R1 on a course beside the goal."""
    chance = random.Random(seed)
    near = [chance.uniform(-0.05, 0.05), chance.uniform(-0.05, 0.05), chance.uniform(-10.0, 10.0)]
    pose = [-1.0 + near[0], 2.0 + near[1], math.radians(-63.0 + near[2])]
    course = [chance.uniform(1.2, 1.8), -1.2, chance.uniform(1.2, 1.8), 1.6, 0.3]
    return ["--pose", *map(str, pose), "--peer", ",".join(map(str, course))]


def episode(counterpart: Callable[..., RobotProcess], folder: Path, transport: str, seed: int = 1) -> dict[str, Any]:
    """One run of EXP1.

    Returns:
        The robot's last report, with `outcome` and `reason` of the run, `time` to the goal [s], `off`, the distance
        from the goal [m], `clean`, and `neutral`, whether the last three commands were zero.
    """
    robot = counterpart(*OPTIONS, *start_of(seed), distribution=HERE[transport])
    found = drive_exp1(folder, transport=transport)
    agent = found.summary.agents["R2"]
    robot.until("speeds == [0.0, 0.0]")
    ended = robot.end()
    ended |= {"outcome": agent.outcome, "reason": agent.reason, "time": agent.time_to_goal}
    ended["neutral"] = all(line.rests for line in [each for each in robot.lines() if each.what == "command"][-3:])
    ended["off"] = math.hypot(*ended["pose"][:2])
    ended["clean"] = agent.outcome == "success" and not ended["collided"] and ended["off"] < GOAL + 0.02
    ended["clean"] &= ended["neutral"]
    return ended


def campaign(counterpart: Callable[..., RobotProcess], folder: Path, transport: str) -> None:
    """Twenty runs, of which nineteen must be clean."""
    runs = []
    for seed in range(20):
        runs.append(episode(counterpart, folder / str(seed), transport, seed))
        names = ("clean", "outcome", "reason", "time", "off", "min_clearance", "expired")
        print(f"seed {seed}:", {name: runs[-1][name] for name in names})
    times, off = [run["time"] for run in runs if run["clean"]], [run["off"] for run in runs if run["clean"]]
    print(f"EXP1 by {transport}: {len(times)} of 20 clean, {min(times):.1f} to {max(times):.1f} s,", end=" ")
    print(f"{1e3 * min(off):.0f} to {1e3 * max(off):.0f} mm from the goal,", end=" ")
    print(f"clearance at least {min(run['min_clearance'] for run in runs):.2f} m")
    assert len(times) >= 19
