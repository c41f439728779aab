"""Wheels that tell a test what they do, and when; by themselves, or under a robot with a process of its own.

The wheels write a line for each thing that happens to them, with the system's monotonic time, into a named pipe. The
test reads that pipe and so waits for what happens, never for a time.
"""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rocs_bt.devices.isolated import DeviceMaker, IsolatedActuator

MAX_AGE = 0.2  # [s] max_command_age
HOLD = 2.5  # [s] that the leaf keeps the interpreter
PATIENCE = 60.0  # [s] far longer than anything here may take
DURATION = 200.0  # [s] of a run that nothing ends
AWAKE = str(Path(__file__).resolve().parent / "awake.py")
HEAVY = ("casadi", "matplotlib", "mujoco", "networkx", "numpy", "py_trees", "scipy")

WHEELS = f'''
import ctypes
import os
import signal
import sys
import threading
import time

from rocs_bt import Actuator
from rocs_bt.base.errors import DeviceError

HEAVY = {HEAVY!r}


class Wheels(Actuator):
    """Wheels that tell what happens to them, and break as `plan` says."""

    plan: str
    log: str

    def __init__(self, name, host):
        super().__init__(name, 2)
        self.count, self.go = 0, self.log + ".go"
        self.log, self.open, self.telling = os.open(self.log, os.O_WRONLY), True, threading.Lock()
        self.tell("process", os.getpid(), os.getsid(0), *sorted(set(sys.modules) & set(HEAVY)))
        if self.plan == "absent":
            raise DeviceError("there is no robot at the other end")
        if self.plan == "raises at the start":
            raise RuntimeError("a worm")
        if self.plan == "dies at the start":
            os._exit(7)
        self.gate = threading.Lock()
        threading.Thread(target=self.witness, daemon=True).start()

    def tell(self, *words):
        with self.telling:
            if self.open:
                os.write(self.log, (" ".join(map(str, (time.monotonic(), *words))) + "\\n").encode())

    def witness(self):
        """Tell of each time at which this process got no processor."""
        last = time.monotonic()
        while self.open:
            time.sleep(0.002)
            now = time.monotonic()
            if now - last > 0.012:
                self.tell("late", now - last)
            last = now

    def command(self, values):
        if self.plan == "is stopped" and self.count == 19:
            begun = time.monotonic()
            os.kill(os.getpid(), signal.SIGSTOP)
            while time.monotonic() - begun < 0.1:  # this thread may run on for a moment
                time.sleep(0.01)
        self.tell("command", *values)
        self.count += 1
        if self.plan == "waits" and self.count == 1:
            with open(self.go) as go:  # until the test writes to it
                go.read()
        if self.count == 20 and self.plan == "exits":
            os._exit(7)
        if self.count == 20 and self.plan == "crashes":
            os.kill(os.getpid(), signal.SIGSEGV)
        if self.count == 20 and self.plan == "holds the interpreter":
            ctypes.PyDLL(None).usleep(int(60e6))
        if self.count == 20 and self.plan == "refuses":
            raise DeviceError("the fuse blew")
        if self.count == 20 and self.plan == "raises":
            raise RuntimeError("a worm")
        if self.count == 20 and self.plan == "calls for an exit":
            sys.exit(7)
        with self.gate:
            if self.count == 20 and self.plan.startswith("hangs"):
                threading.Event().wait()

    def neutral(self):
        self.tell("neutral")
        if self.plan == "stops slowly" and self.count == 0:
            with open(self.go) as go:  # until the test writes to it
                go.read()
            self.tell("stopped")
        if self.plan == "does not stop" or (self.plan == "does not stop apart" and "pytest" not in sys.modules):
            raise OSError("the wire is cut")
        if self.plan == "hangs for good":
            self.gate.acquire()

    def close(self):
        self.tell("closed")
        with self.telling:
            self.open = False
            os.close(self.log)
'''

SENSORS = '''
import math

from rocs_bt import Reading, Sensor


class Sense(Sensor):
    """Sensors of a robot that drives at 0.2 m/s for ever, far from everything."""

    def __init__(self, name, host):
        super().__init__(name)
        self.clock, self.count = host.clock, 0

    def read(self):
        t = self.clock.now()
        self.count += 1
        values = {
            "sonar": [math.inf] * 15 + [0.9 + 1e-6 * self.count],
            "position": [0.2 * t, 1e-9 * self.count, 0.0],
            "orientation": [0.0],
            "encoders": [0.2 + 1e-9 * self.count] * 2,
        }
        return Reading(t, values[self.name])
'''

ROBOT = f"""
format = "robot/3"
base = "pioneer_p3dx"

[[actuator]]
name = "wheels"
driver = "wheels.py:Wheels"
isolated = {{isolated}}
max_command_age = "{MAX_AGE} s"
plan = "{{plan}}"
log = "{{log}}"

"""

SCENARIO = """
format = "scenario/2"
base = "exp1"

[[agent]]
name = "R2"
robot = "own"
mission = "hold"
[agent.parameters]
hold = "{hold}"
log = "{log}"
"""

# The leaf calls a function of C that keeps the interpreter: no other thread of this process runs meanwhile.
MISSION = f"""
import ctypes
import os
import time

from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel

from rocs_bt.base.units import Seconds


class Hold(Behaviour):
    def __init__(self, mission, every, log):
        super().__init__("Hold")
        self.clock, self.every, self.at, self.log = mission.clock, every, every, log

    def tell(self, what):
        pipe = os.open(self.log, os.O_WRONLY)
        os.write(pipe, f"{{time.monotonic()}} {{what}}\\n".encode())
        os.close(pipe)

    def update(self):
        if self.clock.now() >= self.at:
            self.tell("held")
            ctypes.PyDLL(None).usleep({int(1e6 * HOLD)})
            self.tell("freed")
            self.at = self.clock.now() + self.every
        return Status.RUNNING


def build(mission, *, hold: Seconds = 1e9, log: str = ""):
    leaves = [mission.act("SetWheelSpeed", speeds=[0.2, 0.2]), Hold(mission, hold, log)]
    return Parallel("both", ParallelPolicy.SuccessOnAll(synchronise=False), leaves)
"""

MAIN = """
import json, time
from pathlib import Path
from rocs_bt.catalog import Catalog
from rocs_bt.base.errors import RocsError
from rocs_bt.event import BlockFailed, CommandExpired, MotionHeld, MotionReleased
from rocs_bt import drive

class Tell:
    def emit(self, event):
        if isinstance(event, (BlockFailed, CommandExpired, MotionHeld, MotionReleased)):
            reason = getattr(event, "reason", "")
            print(json.dumps([time.monotonic(), type(event).__name__, event.t, reason]), flush=True)

try:
    result = drive("real", Catalog(Path({project!r})), duration={duration}, sinks=[Tell()], out={out!r})
    found = result.summary.agents["R2"]
    print(json.dumps([found.outcome, found.reason]), flush=True)
except RocsError as error:
    print(json.dumps([type(error).__name__, str(error)]), flush=True)
"""


@dataclass(frozen=True)
class Line:
    """What happened to the wheels.

    Attributes:
        t: Monotonic system time [s].
        what: `process`, `command`, `neutral`, `stopped`, `closed` or `late`; `held` and `freed` of the interpreter.
        values: Values of a command [m/s]; process and session number; the time without a processor [s].
    """

    t: float
    what: str
    values: tuple[Any, ...]

    @property
    def moves(self) -> bool:
        """Whether it is a command that turns the wheels."""
        return self.what == "command" and any(self.values)


class Log:
    """What the wheels tell.

    Args:
        path: The pipe that they write to; made here.

    Attributes:
        lines: What was read so far.
    """

    def __init__(self, path: Path) -> None:
        os.mkfifo(path)
        self._path = path
        self.lines: list[Line] = []
        self._pipe = os.open(path, os.O_RDONLY | os.O_NONBLOCK)  # else it would wait here for the wheels
        self._text = b""

    def begin(self) -> Log:
        """Wait until the wheels write."""
        self._wait(time.monotonic() + PATIENCE)
        return self

    def follow(self) -> Iterator[Line]:
        """What happens next, until the wheels' process ends; not for ever."""
        end = time.monotonic() + PATIENCE
        while b"\n" in self._text or self._read(end):
            text, _, self._text = self._text.partition(b"\n")
            t, what, *values = text.decode().split()
            self.lines.append(Line(float(t), what, tuple(values if what == "process" else map(float, values))))
            yield self.lines[-1]

    def _wait(self, end: float) -> None:
        poll = select.poll()
        poll.register(self._pipe, select.POLLIN)
        shown = [line for line in self.lines if line.what != "late"][-5:]
        assert poll.poll(max(1e3 * (end - time.monotonic()), 0.0)), f"it never came; the last lines: {shown}"

    def _read(self, end: float) -> bool:
        """Read what the wheels have written, at least a line; False if their process has ended."""
        while b"\n" not in self._text:
            self._wait(end)
            if not (text := os.read(self._pipe, 65536)):
                return False
            self._text += text
        return True

    def until(self, wanted: Callable[[Line], bool]) -> Line:
        """The next line that is wanted."""
        for line in self.follow():
            if wanted(line):
                return line
        raise AssertionError(f"the process has ended; its last lines: {self.lines[-5:]}")

    def drive(self, periods: int = 10) -> None:
        """Wait until the wheels have turned for some periods."""
        for _ in range(periods):
            self.until(lambda line: line.moves)

    def stop(self) -> tuple[float, float]:
        """Wait until the wheels are neutral.

        Returns:
            Time from the last command to neutral [s], and what of it their process was awake [s].
        """
        return self.measure(self.until(lambda line: line.what == "neutral"))

    def measure(self, neutral: Line) -> tuple[float, float]:
        """As `stop`, of a neutral that was read already."""
        last = next(line for line in reversed(self.lines) if line.what == "command" and line.t <= neutral.t)
        gaps = [(line.t - line.values[0] + 0.002, line.t) for line in self.lines if line.what == "late"]
        late = sum(max(min(end, neutral.t) - max(begin, last.t), 0.0) for begin, end in gaps)
        return neutral.t - last.t, neutral.t - last.t - late

    def end(self) -> list[Line]:
        """Wait until the wheels' process has ended; its lines from then on."""
        begun = len(self.lines)
        for _ in self.follow():
            pass
        return self.lines[begun:]

    @contextmanager
    def kept_open(self) -> Iterator[None]:
        """While the context is open, the pipe does not end with the last process that writes to it."""
        end = os.open(self._path, os.O_WRONLY)
        try:
            yield
        finally:
            os.close(end)

    def close(self) -> None:
        """Close the pipe."""
        os.close(self._pipe)

    @property
    def last(self) -> list[str]:
        """The last four things that happened."""
        return [line.what for line in self.lines if line.what != "late"][-4:]

    @property
    def process(self) -> int:
        """The number of the wheels' process."""
        return int(next(line for line in self.lines if line.what == "process").values[0])


@contextmanager
def linked(
    folder: Path, plan: str = "", max_age: float = 60.0, *, two_owners: bool = False
) -> Iterator[tuple[IsolatedActuator, Log]]:
    """The link to isolated wheels, which by default never expire; afterwards their process has ended."""
    (folder / "wheels.py").write_text(WHEELS)
    log = Log(folder / "log")
    os.mkfifo(folder / "log.go")
    try:
        parameters = {"plan": plan, "log": str(folder / "log")}
        link = IsolatedActuator(DeviceMaker(folder / "wheels.py", "Wheels", "wheels", parameters, two_owners), max_age)
        try:
            yield link, log
        finally:
            link.close()
            log.end()
    finally:
        log.close()


@contextmanager
def driven(
    project: Path,
    plan: str = "",
    *,
    hold: str = "1000000 s",
    real_time: bool = False,
    isolated: bool = True,
    two_owners: bool = False,
    out: str | None = None,
    first: str = "",
) -> Iterator[Robot]:
    """A robot that drives; afterwards no process of it is left.

    With `isolated` false its wheels live in the main process; with `two_owners` they can be open there too. Files of
    the run go to the folder `out` of the project. The main process runs the code `first` at its start.

    Its main process runs on the time of tests/awake.py, so that a machine which is held up is no hanging block; its
    wheels always run on real time.
    """
    write_project(project, plan, hold, isolated=isolated, two_owners=two_owners, out=out)
    (project / "main.py").write_text(first + (project / "main.py").read_text())
    log = Log(project / "log")
    command = [sys.executable, *([] if real_time else [AWAKE]), "main.py"]
    with subprocess.Popen(command, cwd=project, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as main:
        try:
            yield Robot(main, log.begin())
        finally:
            main.kill()
            log.end()  # it ends when the wheels' process has ended, and so has closed the pipe
            log.close()


@dataclass
class Robot:
    """A robot with isolated wheels.

    Attributes:
        main: The main process.
        wheels: What the wheels tell.
    """

    main: subprocess.Popen[str]
    wheels: Log

    def tells(self, event: str) -> Any:
        """Wait until the main process prints an event of a kind: its line."""
        assert self.main.stdout is not None
        while (line := json.loads(self.main.stdout.readline()))[1] != event:
            pass
        return line

    def told(self) -> list[Any]:
        """Wait until the main process has ended: what it has printed."""
        out, error = self.main.communicate(timeout=PATIENCE)
        assert error == ""
        return [json.loads(line) for line in out.splitlines()]


def write_project(project: Path, plan: str, hold: str, *, isolated: bool, two_owners: bool, out: str | None) -> None:
    """A project with the scenario `real`."""
    names = ("sonar", "position", "orientation", "encoders")
    sensors = [f'[[sensor]]\nname = "{name}"\ndriver = "sensors.py:Sense"\n' for name in names]
    files = {
        "robots/own/wheels.py": f"{WHEELS}\n    two_owners = {two_owners}\n",
        "robots/own/sensors.py": SENSORS,
        "robots/own/robot.toml": "".join(
            [ROBOT.format(plan=plan, log=project / "log", isolated=str(isolated).lower()), *sensors]
        ),
        "planners/missions/hold.py": MISSION,
        "scenarios/real.toml": SCENARIO.format(hold=hold, log=project / "log"),
        "main.py": MAIN.format(project=str(project), duration=DURATION, out=out),
    }
    for name, text in files.items():
        (project / name).parent.mkdir(parents=True, exist_ok=True)
        (project / name).write_text(text)
