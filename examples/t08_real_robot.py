# /// script
# requires-python = ">=3.11"
# dependencies = ["rocs_bt"]
# ///
"""Put a mind on a real robot: EXP1's mission and rules, and drivers that speak with a robot over UDP.

The robot folder is based on the shipped Pioneer and changes its table of drivers, nothing else: not one line of the
mission, of the rules or of the engine. What answers here is a process of its own that stands in for a robot's
controller: it takes wheel speeds as datagrams, stops by itself when none comes, and tells twenty times a second what
it senses. For a serial line replace the class Link; the rest stays.

Output:

    R2: success, 0.1 m or less from the goal
    changed from the simulated robot: sonar, position, orientation, encoders, wheels
    in a process of its own: wheels
    the controller stopped by itself when the datagrams ended: True
"""

import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import rocs_bt
from rocs_bt import drive

DRIVERS = '''
"""A robot's controller at the other end of UDP: one Link, and a device for each thing that its datagrams tell."""

import json
import socket
import threading

from rocs_bt import Actuator, Reading, Sensor
from rocs_bt.errors import DeviceError


def connect(address):
    """A socket to the controller.

    Args:
        address: The controller's, as `udp://HOST:PORT`.
    """
    connection = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    host, _, port = address.removeprefix("udp://").rpartition(":")
    try:
        connection.connect((host, int(port)))
    except OSError as error:
        raise DeviceError(f"the robot cannot be reached: {error}") from error
    return connection


class Link:
    """The newest datagram from the robot, and when it came; one for all sensors.

    Args:
        address: The controller's, as `udp://HOST:PORT`.
        clock: Stamps what comes, on arrival: the robot's own clock is another one.
    """

    def __init__(self, address, clock):
        self._socket = connect(address)
        self._socket.settimeout(0.2)
        self._clock = clock
        self._newest = None
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._listen, name="link", daemon=True)
        self._thread.start()
        self._socket.send(b'{"hello": true}')  # so that the controller knows where to

    def newest(self, key):
        """The values under a key in the newest datagram, with its time; nothing is waited for."""
        if self._newest is None or key not in self._newest[1]:
            raise DeviceError(f"the robot has not told of '{key}' yet")
        stamp, told = self._newest
        # JSON knows neither infinity, which is no echo, nor NaN, which is broken: they travel as texts.
        return Reading(stamp, [float(value) for value in told[key]])

    def close(self):
        """End the thread, then the connection."""
        self._closed.set()
        self._thread.join(1.0)
        self._socket.close()

    def _listen(self):
        while not self._closed.is_set():
            try:
                told = json.loads(self._socket.recv(65536))
            except (OSError, ValueError):  # nothing came, nobody is there yet, or it is garbled: the stamp grows old
                continue
            self._newest = self._clock.now(), told


class Told(Sensor):
    """What the datagrams hold under its name; a robot that falls silent repeats an old stamp, and so goes stale."""

    def __init__(self, name, host, *, address: str):
        super().__init__(name)
        self._link = host.share(address, lambda: Link(address, host.clock))

    def read(self):
        """The newest sample, at once."""
        return self._link.newest(self.name)


class Wheels(Actuator):
    """Rim speeds, left and right; with a connection of their own, as they live in a process of their own."""

    def __init__(self, name, host, *, address: str):
        super().__init__(name, 2)
        self._socket = connect(address)

    def command(self, values):
        """Ask for these speeds [m/s]; a network that is gone is no reason to hang."""
        try:
            self._socket.send(json.dumps({"wheels": list(values)}).encode())
        except OSError as error:
            raise DeviceError(f"the robot cannot be reached: {error}") from error

    def neutral(self):
        """Brake. Must not raise: when the network is gone the controller's own watchdog stops the robot."""
        try:
            self.command([0.0, 0.0])
        except DeviceError:
            pass

    def close(self):
        """End the connection."""
        self._socket.close()
'''

ROBOT = """
format = "robot/1"
base = "pioneer_p3dx"
doc = "A Pioneer P3-DX at the other end of UDP."

[[sensor]]
name = "sonar"
driver = "udp.py:Told"
address = "udp://127.0.0.1:7000"

[[sensor]]
name = "position"
driver = "udp.py:Told"
address = "udp://127.0.0.1:7000"

[[sensor]]
name = "orientation"
driver = "udp.py:Told"
address = "udp://127.0.0.1:7000"

[[sensor]]
name = "encoders"
driver = "udp.py:Told"
address = "udp://127.0.0.1:7000"

[[actuator]]
name = "wheels"
driver = "udp.py:Wheels"
isolated = true
address = "udp://127.0.0.1:7000"
"""

SCENARIO = """
format = "scenario/1"
base = "exp1"
doc = "EXP1's mission and rules, on a real robot."

[[agent]]
name = "R2"
robot = "udp_p3dx"
"""

CONTROLLER = '''
"""Stands in for a robot's controller: takes wheel speeds, tells what it senses, stops when nobody speaks to it."""

import json
import math
import socket
import sys
import time

TRACK, PERIOD, WATCHDOG = 0.331, 0.05, 6  # [m], [s], periods of silence after which it stops: 0.3 s

here = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
here.bind(("127.0.0.1", 0))
here.setblocking(False)
print(here.getsockname()[1], flush=True)

x, y, yaw, wheels, friend = -0.7, 0.7, -0.8, [0.0, 0.0], None
heard, silence, stopped, until = False, 0, False, time.monotonic() + float(sys.argv[1])
while time.monotonic() < until and not stopped:
    silence += 1
    try:
        while True:
            message, sender = here.recvfrom(65536)
            asked = json.loads(message)
            if "hello" in asked:
                friend = sender
            if "wheels" in asked:
                wheels, heard, silence = asked["wheels"], True, 0
    except OSError:
        pass
    if heard and silence >= WATCHDOG:  # counted, not timed: what came while it was held up itself is read first
        wheels, stopped = [0.0, 0.0], True
    turn, ahead = (wheels[1] - wheels[0]) / TRACK * PERIOD, 0.5 * (wheels[0] + wheels[1]) * PERIOD
    x, y, yaw = x + ahead * math.cos(yaw + turn / 2), y + ahead * math.sin(yaw + turn / 2), yaw + turn
    # A real ring of sonars never says the same twice while the robot moves; this one hears something far away.
    sonar = ["inf"] * 15 + [0.9 + 0.05 * math.sin(50.0 * time.monotonic())]
    told = {"sonar": sonar, "position": [x, y, 0.0], "orientation": [yaw], "encoders": wheels}
    if friend:
        here.sendto(json.dumps(told).encode(), friend)
    time.sleep(PERIOD)
print(json.dumps({"x": x, "y": y, "stopped": stopped}), flush=True)
'''


def write_project(project: Path, port: int) -> rocs_bt.Catalog:
    """A robot folder that changes the drivers, and a scenario that names it."""
    folder = project / "robots" / "udp_p3dx"
    folder.mkdir(parents=True)
    (folder / "udp.py").write_text(DRIVERS)
    (folder / "robot.toml").write_text(ROBOT.replace(":7000", f":{port}"))
    (project / "scenarios").mkdir()
    (project / "scenarios" / "real.toml").write_text(SCENARIO)
    return rocs_bt.Catalog(project)


with tempfile.TemporaryDirectory() as folder:
    arguments = [sys.executable, "-c", CONTROLLER, "120"]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True) as controller:
        catalog = write_project(Path(folder), int(controller.stdout.readline()))
        result = drive("real", catalog, duration=30.0)
        robot = json.loads(controller.stdout.readline())
    near = math.hypot(robot["x"], robot["y"]) <= 0.1
    print(f"R2: {result.outcomes['R2']}, {'0.1 m or less' if near else 'far'} from the goal")
    own, base = catalog.load_robot("udp_p3dx"), catalog.load_robot("pioneer_p3dx")
    devices = zip([*own.sensors, *own.actuators], [*base.sensors, *base.actuators], strict=True)
    print(f"changed from the simulated robot: {', '.join(a.name for a, b in devices if a.driver != b.driver)}")
    print(f"in a process of its own: {', '.join(a.name for a in own.actuators if a.isolated)}")
    print(f"the controller stopped by itself when the datagrams ended: {robot['stopped']}")
