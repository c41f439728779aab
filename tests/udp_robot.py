"""A robot's controller over UDP in this process, and a project whose drivers connect to it: those of the manual."""

from __future__ import annotations

import json
import math
import re
import socket
import struct
import threading
from pathlib import Path
from types import TracebackType

PAGE = Path(__file__).resolve().parents[1] / "docs/put-it-on-your-robot.md"
TRACK, PERIOD = 0.331, 0.05  # [m], [s]
SO_TIMESTAMPNS = 35  # of Linux


class UdpRobot:
    """Kinematic robot that takes wheel speeds and sends its sensor values 20 times per second.

    Attributes:
        port: UDP port on the loopback.
        silent: Keys that are not sent.
        extra: Values that are sent instead of the robot's own, by key.
        received: Wheel speeds in the order of arrival, each with the time since the start in periods.
        times: Times of these arrivals by the system's stamps [s since 1970].
    """

    def __init__(self) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.setblocking(False)
        self._socket.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)  # however late this thread runs
        self.port = self._socket.getsockname()[1]
        self.silent: set[str] = set()
        self.extra: dict[str, list[object]] = {}
        self.received: list[tuple[int, list[float]]] = []
        self.times: list[float] = []
        self.arrived = threading.Condition()
        self._x, self._y, self._yaw = -0.7, 0.7, -0.8
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> UdpRobot:
        self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None):
        self._closed.set()
        self._thread.join()
        self._socket.close()

    @property
    def commands(self) -> list[list[float]]:
        """Wheel speeds in the order of arrival [m/s]."""
        with self.arrived:
            return [speeds for _, speeds in self.received]

    @property
    def moved(self) -> bool:
        """Whether a command has turned a wheel."""
        return any(any(speeds) for speeds in self.commands)

    def wait_until_moving(self) -> None:
        """Wait until it gets five further commands that turn its wheels."""
        with self.arrived:
            begun = len(self.received)
            assert self.arrived.wait_for(lambda: sum(any(s) for _, s in self.received[begun:]) >= 5, 60.0)

    def wait_until_neutral(self, count: int = 3) -> None:
        """Wait until its newest commands are neutral."""
        with self.arrived:
            assert self.arrived.wait_for(lambda: [s for _, s in self.received[-count:]] == [[0.0, 0.0]] * count, 60.0)

    def _run(self) -> None:
        client, count = None, 0
        while not self._closed.wait(PERIOD):
            count += 1
            try:
                while True:
                    message, (stamp, *_), _, sender = self._socket.recvmsg(65536, 64)
                    request = json.loads(message)
                    client = sender if "hello" in request else client
                    if "wheels" in request:
                        with self.arrived:
                            self.received.append((count, request["wheels"]))
                            seconds, nanoseconds = struct.unpack("ll", stamp[2])
                            self.times.append(seconds + 1e-9 * nanoseconds)
                            self.arrived.notify_all()
            except BlockingIOError:
                pass
            wheels = self.received[-1][1] if self.received else [0.0, 0.0]
            turn, ahead = (wheels[1] - wheels[0]) / TRACK * PERIOD, 0.5 * sum(wheels) * PERIOD
            self._x += ahead * math.cos(self._yaw + turn / 2)
            self._y += ahead * math.sin(self._yaw + turn / 2)
            self._yaw += turn
            if client is not None:
                values = {
                    "sonar": ["inf"] * 15 + [0.9 + 0.001 * math.sin(count)],
                    "position": [self._x, self._y, 0.0],
                    "orientation": [self._yaw],
                    "encoders": wheels,
                } | self.extra
                sent = {key: value for key, value in values.items() if key not in self.silent}
                self._socket.sendto(json.dumps(sent).encode(), client)


def write_project(folder: Path, port: int, *, isolated: bool = True, robot: str = "", scenario: str = "") -> Path:
    """Write the manual's robot and scenario `real`, for a controller at this port.

    Args:
        folder: Folder of the project.
        port: UDP port of the controller.
        isolated: Whether the wheels' driver runs in its own process.
        robot: Text to append to robot.toml.
        scenario: Text to append to the scenario's agent.
    """
    blocks = re.findall(r"```(?:toml|python)\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    toml, code, scene = (
        next(block for block in blocks if mark in block) for mark in ('format = "robot/3"', "class Link", "scenario/2")
    )
    toml = toml.replace(":7000", f":{port}").replace("isolated = true", f"isolated = {str(isolated).lower()}")
    files = {
        "robots/udp_p3dx/robot.toml": toml + robot,
        "robots/udp_p3dx/udp.py": code,
        "scenarios/real.toml": scene + scenario,
    }
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, "utf-8")
    return folder
