"""Campaign: processes of a drive that die, stop or hang at random moments; the robot over UDP holds its last command.

Each row of the page's table that promises a time has ten deaths. The times are raw: a loaded machine makes them longer.
"""

from __future__ import annotations

import random
import signal
import time
from pathlib import Path

import psutil
import pytest

from ..udp_robot import UdpRobot
from .test_drive_ends import creep, driving, robot  # noqa: F401

COUNT = 10
SOON = 0.2 + 0.1  # [s] max_command_age, and what the page allows

TRAP = """
    def command(self, values):
        import ctypes, os, signal, sys, time
        if os.path.exists("trap"):
            exec(open("trap").read())
        self._command(values)

    def _command(self, values):
"""

SIGNALS = {
    "agent killed": ("main", signal.SIGKILL),
    "agent stopped": ("main", signal.SIGSTOP),
    "agent terminated": ("main", signal.SIGTERM),
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


def trapped(text: str) -> str:
    """The driver, with a trap at the begin of its command."""
    return text.replace("    def command(self, values):\n", TRAP[1:])


def until_zero(robot: UdpRobot, fault: float, count: int) -> float:  # noqa: F811
    """Time from the last moving command, or from the fault if that came earlier, to the first zero for good [s]."""
    robot.wait_until_neutral(count)
    with robot.arrived:
        lines = [(at, any(speeds)) for at, (_, speeds) in zip(robot.times, robot.received, strict=True)]
    last = max(i for i, (_, moves) in enumerate(lines) if moves)
    return lines[last + 1][0] - min(lines[last][0], fault)


@pytest.mark.soak
@pytest.mark.parametrize("death", [*SIGNALS, *DRIVERS])
def test_ten_deaths(creep, robot, death):  # noqa: F811
    creep(isolated=True, driver=trapped)
    chance, took = random.Random(death), []
    for _ in range(COUNT):
        Path("trap").unlink(missing_ok=True)
        with driving() as process:
            robot.wait_until_moving()
            (wheels,) = psutil.Process(process.pid).children(recursive=True)
            time.sleep(chance.uniform(0.0, 0.5))
            if death in SIGNALS:
                which, number = SIGNALS[death]
                fault = time.time()
                (process if which == "main" else wheels).send_signal(number)
            else:
                Path("trap.new").write_text(f"if os.getpid() == {wheels.pid}: {DRIVERS[death]}\n")
                fault = time.time()
                Path("trap.new").rename("trap")
            took.append(until_zero(robot, fault, 1 if death == "agent stopped" else 3))
            process.send_signal(signal.SIGCONT)
    print(f"{death}, {COUNT} times: zero after {min(took):.3f} to {max(took):.3f} s")
    assert max(took) <= SOON
