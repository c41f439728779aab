# /// script
# requires-python = ">=3.11"
# dependencies = ["rocs_bt"]
# ///
"""Run an agent on a real robot: EXP1's mission and rules, and drivers that communicate with a robot over UDP.

The robot's folder is based on the shipped Pioneer and changes only its drivers; mission, rules and engine are
unchanged. Here a separate process emulates the robot's controller: it receives wheel speeds as datagrams, stops the
robot when none arrives, and sends its sensor values 20 times per second. For a serial line, replace only the class
Link.

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
"""Drivers for a robot's controller over UDP: one Link, and a device for each value of its datagrams."""

import json
import socket
import threading

from rocs_bt import Actuator, DeviceError, Reading, Sensor


def connect(address):
    """Open a socket to the controller.

    Args:
        address: Address of the controller, as `udp://HOST:PORT`.
    """
    connection = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    host, _, port = address.removeprefix("udp://").rpartition(":")
    try:
        connection.connect((host, int(port)))
    except OSError as error:
        raise DeviceError(f"the robot cannot be reached: {error}") from error
    return connection


class Link:
    """Receiver of the newest datagram from the robot, shared by all sensors.

    Args:
        address: Address of the controller, as `udp://HOST:PORT`.
        clock: Clock for time stamps on arrival; the robot's own clock is a different one.
    """

    def __init__(self, address, clock):
        self._socket = connect(address)
        self._socket.settimeout(0.2)
        self._clock = clock
        self._newest = None
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._listen, name="link", daemon=True)
        self._thread.start()
        self._socket.send(b'{"hello": true}')  # gives the controller the address to send to

    def newest(self, key):
        """Values of a key in the newest datagram, with its time stamp; does not wait."""
        if self._newest is None or key not in self._newest[1]:
            raise DeviceError(f"the robot has not sent '{key}' yet")
        stamp, values = self._newest
        # JSON has neither infinity (no echo) nor NaN (broken): they are sent as strings.
        return Reading(stamp, [float(value) for value in values[key]])

    def close(self):
        """End the thread, then the connection."""
        self._closed.set()
        self._thread.join(1.0)
        self._socket.close()

    def _listen(self):
        while not self._closed.is_set():
            try:
                values = json.loads(self._socket.recv(65536))
            except (OSError, ValueError):  # no datagram, no controller yet, or malformed: the last stamp becomes stale
                continue
            self._newest = self._clock.now(), values


class UdpSensor(Sensor):
    """Values of the datagrams under the sensor's name; they become stale when the robot stops sending."""

    address: str

    def __init__(self, name, host):
        super().__init__(name)
        self._link = host.share(self.address, lambda: Link(self.address, host.clock))

    def read(self):
        """Newest sample, without waiting."""
        return self._link.newest(self.name)


class Wheels(Actuator):
    """Wheel linear speeds, left and right; with its own connection, because it runs in its own process."""

    address: str

    def __init__(self, name, host):
        super().__init__(name, 2)
        self._socket = connect(self.address)

    def command(self, values):
        """Send wheel speeds [m/s]; a lost network must not block."""
        try:
            self._socket.send(json.dumps({"wheels": list(values)}).encode())
        except OSError as error:
            raise DeviceError(f"the robot cannot be reached: {error}") from error

    def neutral(self):
        """Brake; must not raise. If the network is lost, the controller's own watchdog stops the robot."""
        try:
            self.command([0.0, 0.0])
        except DeviceError:
            pass

    def close(self):
        """End the connection."""
        self._socket.close()
'''

ROBOT = """
format = "robot/3"
base = "pioneer_p3dx"
doc = "A Pioneer P3-DX connected over UDP."

[[sensor]]
name = "sonar"
driver = "udp.py:UdpSensor"
address = "udp://127.0.0.1:7000"

[[sensor]]
name = "position"
driver = "udp.py:UdpSensor"
address = "udp://127.0.0.1:7000"

[[sensor]]
name = "orientation"
driver = "udp.py:UdpSensor"
address = "udp://127.0.0.1:7000"

[[sensor]]
name = "encoders"
driver = "udp.py:UdpSensor"
address = "udp://127.0.0.1:7000"

[[actuator]]
name = "wheels"
driver = "udp.py:Wheels"
isolated = true
address = "udp://127.0.0.1:7000"
"""

SCENARIO = """
format = "scenario/2"
base = "exp1"
doc = "EXP1's mission and rules, on a real robot."

[[agent]]
name = "R2"
robot = "udp_p3dx"
"""

CONTROLLER = '''
"""Emulates a robot's controller: receives wheel speeds, sends sensor values, and stops without commands."""

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

x, y, yaw, wheels, client = -0.7, 0.7, -0.8, [0.0, 0.0], None
commanded, silence, stopped, until = False, 0, False, time.monotonic() + float(sys.argv[1])
while time.monotonic() < until and not stopped:
    silence += 1
    try:
        while True:
            message, sender = here.recvfrom(65536)
            request = json.loads(message)
            if "hello" in request:
                client = sender
            if "wheels" in request:
                wheels, commanded, silence = request["wheels"], True, 0
    except OSError:
        pass
    if commanded and silence >= WATCHDOG:  # counts periods: datagrams that arrived during a delay are read first
        wheels, stopped = [0.0, 0.0], True
    turn, ahead = (wheels[1] - wheels[0]) / TRACK * PERIOD, 0.5 * (wheels[0] + wheels[1]) * PERIOD
    x, y, yaw = x + ahead * math.cos(yaw + turn / 2), y + ahead * math.sin(yaw + turn / 2), yaw + turn
    # Readings of real sonars vary while the robot moves; here one of them has a varying far echo.
    sonar = ["inf"] * 15 + [0.9 + 0.05 * math.sin(50.0 * time.monotonic())]
    values = {"sonar": sonar, "position": [x, y, 0.0], "orientation": [yaw], "encoders": wheels}
    if client:
        here.sendto(json.dumps(values).encode(), client)
    time.sleep(PERIOD)
print(json.dumps({"x": x, "y": y, "stopped": stopped}), flush=True)
'''


def write_project(project: Path, port: int) -> rocs_bt.Catalog:
    """Write a robot folder with other drivers, and a scenario that uses it."""
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
