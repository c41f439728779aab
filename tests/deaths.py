"""Ways in which the two processes of a drive with isolated wheels die, stop or hang; times until the robot is stopped.

The robot has no time-out of its own: it holds its last command. Both are for `make soak`: times are raw, and a loaded
machine makes them longer.
"""

from __future__ import annotations

import random
import signal
import subprocess
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Protocol

import psutil

COUNT = 10
SOON = 0.2 + 0.1  # [s] max_command_age, and what the page allows

SIGNALS = {
    "agent killed": ("agent", signal.SIGKILL),
    "agent stopped": ("agent", signal.SIGSTOP),
    "agent terminated": ("agent", signal.SIGTERM),
    "wheels killed": ("wheels", signal.SIGKILL),
    "wheels stopped": ("wheels", signal.SIGSTOP),
    "wheels terminated": ("wheels", signal.SIGTERM),
}
DRIVERS = {
    "driver raises": "raise OSError('the fuse blew')",
    "driver hangs": "time.sleep(1e6)",
    "driver holds the interpreter": "ctypes.PyDLL(None).sleep(1000000)",
    "driver exits": "os._exit(3)",
    "driver crashes": "os.kill(os.getpid(), signal.SIGSEGV)",
}
DEATHS = [*SIGNALS, *DRIVERS]

TRAP = """
import ctypes, os, signal, sys, time

def spring():
    "Execute the file `trap` of the current folder, if it is there."
    if os.path.exists("trap"):
        exec(open("trap").read())
"""


class Driven(Protocol):
    """A robot that is driven: its agent's process, the agent's current folder, and what the robot is commanded."""

    agent: subprocess.Popen[str] | subprocess.Popen[bytes]
    folder: Path

    def wait_until_moving(self) -> None:
        """Wait until it is commanded to move."""

    def until_zero(self, fault: float, count: int) -> float:
        """Wait until its newest commands are zero.

        Args:
            fault: Time of the fault [s since 1970].
            count: Number of commands.

        Returns:
            Time from the last moving command, or from the fault if that came earlier, to the first zero [s].
        """


def die(death: str, driven: Driven) -> float:
    """Let one of DEATHS happen; returns its time [s since 1970]. The driver calls `spring` of TRAP in its command."""
    (wheels,) = psutil.Process(driven.agent.pid).children(recursive=True)
    if death in SIGNALS:
        which, number = SIGNALS[death]
        at = time.time()
        (wheels if which == "wheels" else driven.agent).send_signal(number)
    else:
        (driven.folder / "trap.new").write_text(f"if os.getpid() == {wheels.pid}: {DRIVERS[death]}\n")
        at = time.time()
        (driven.folder / "trap.new").rename(driven.folder / "trap")
    return at


def ten_deaths(death: str, drive: Callable[[int], AbstractContextManager[Driven]]) -> None:
    """Let a death happen at ten random moments, of ten drives.

    Args:
        death: One of DEATHS.
        drive: Starts the drive of a number.
    """
    chance, took = random.Random(death), []
    for number in range(COUNT):
        with drive(number) as driven:
            driven.wait_until_moving()
            time.sleep(chance.uniform(0.0, 0.5))
            took.append(driven.until_zero(die(death, driven), 1 if death == "agent stopped" else 3))
            driven.agent.send_signal(signal.SIGCONT)
    print(f"{death}, {COUNT} times: zero after {min(took):.3f} to {max(took):.3f} s")
    assert max(took) <= SOON
