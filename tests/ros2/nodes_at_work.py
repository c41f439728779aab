"""Nodes for ROS 2 in a tree that is ticked on wall time, and the program of servers.py as their counterpart."""

from __future__ import annotations

import json
import os
import queue
import subprocess
import threading
import time
from pathlib import Path
from typing import Any

from rocs_bt.actions import ACTIONS
from rocs_bt.base.clock import WallClock
from rocs_bt.event import ListSink
from rocs_bt.interfaces.pipeline import Pipeline
from rocs_bt.knowledge import Knowledge
from rocs_bt.plan import Mission, TreePlan, xml_mission
from rocs_bt.ros2.network.node import RosNode
from rocs_bt.ros2.nodes.link import NodeLink
from rocs_bt.ros2.settings import Ros2Settings

from .robot_process import BOOTSTRAPPED, ros_python

PATIENCE = 60.0  # [s] far longer than anything here takes
PERIOD = 0.02  # [s] between two ticks
SHORT_LEASE = """<?xml version="1.0" encoding="UTF-8"?>
<profiles xmlns="http://www.eprosima.com">
  <participant profile_name="short" is_default_profile="true"><rtps><builtin><discovery_config>
    <leaseDuration><sec>2</sec></leaseDuration><leaseAnnouncement><nanosec>500000000</nanosec></leaseAnnouncement>
  </discovery_config></builtin></rtps></participant>
</profiles>
"""
"""Settings of Fast DDS with which others notice after 2 s, not 20 s, that a process was killed."""


class Servers:
    """The program of servers.py as a process."""

    def __init__(self, environment: dict[str, str], folder: Path) -> None:
        profile = folder / "lease.xml"
        profile.write_text(SHORT_LEASE)
        environment = {k: v for k, v in environment.items() if k not in (BOOTSTRAPPED, "LD_LIBRARY_PATH")}
        environment["FASTRTPS_DEFAULT_PROFILES_FILE"] = str(profile)
        command = [str(ros_python("here")), str(Path(__file__).with_name("servers.py")), "/r1"]
        self.process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)
        self.seen: list[list[Any]] = []
        self._lines: queue.Queue[str] = queue.Queue()
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()
        self.until("ready")

    def until(self, what: str, value: Any = None) -> Any:
        """Wait until something happens to the program; returns its value."""
        while True:
            happened = json.loads(self._lines.get(timeout=PATIENCE))
            self.seen.append(happened)
            if happened[0] == what and value in (None, happened[1]):
                return happened[1]

    def kill(self) -> None:
        self.process.kill()
        self.process.wait(PATIENCE)
        self._thread.join(PATIENCE)

    def _read(self) -> None:
        assert self.process.stdout is not None
        with self.process.stdout as lines:
            for line in lines:
                self._lines.put(line)


class AtWork:
    """A tree of one line of XML, with a connection of its own."""

    def __init__(self, line: str, transport: str = "rclpy", dialect: str = "", **keys: Any) -> None:
        settings = Ros2Settings(transport=transport, domain=int(os.environ["ROS_DOMAIN_ID"]), namespace="r1")
        self.clock, self.sink = WallClock(), ListSink()
        self.node: RosNode | None = None
        self.notices: list[str] = []
        self.link = NodeLink(lambda: self._connected(settings), self.notices.append)
        self.mission = Mission(
            "test",
            knowledge=Knowledge("R1", self.clock, self.sink),
            pipeline=Pipeline(self.clock, self.sink, "R1"),
            actions=ACTIONS,
            services={"ros2": self.link},
        )
        for key, value in keys.items():
            self.mission.board.set_local(key, value)
        text = f'<root BTCPP_format="4"><BehaviorTree ID="M">{line}</BehaviorTree></root>'
        try:
            self.plan = TreePlan(xml_mission(text, dialect=dialect)(self.mission), self.mission)
        except BaseException:  # raised again, after the connection is closed
            self.close()
            raise
        self.slowest = 0.0

    def _connected(self, settings: Ros2Settings) -> RosNode:
        self.node = RosNode(settings, self.clock)
        return self.node

    @property
    def board(self) -> Any:
        return self.mission.board

    @property
    def feedback(self) -> str:
        return str(self.plan.root.feedback_message)

    def has(self, key: str) -> bool:
        """Whether a key has a value."""
        entry = self.board.entry(key)
        return entry is not None and entry.value is not None

    def tick(self) -> str:
        begun = time.perf_counter()
        outcome = self.plan.tree.tick()
        self.slowest = max(self.slowest, time.perf_counter() - begun)
        return outcome.name

    def until(self, wanted: Any) -> str:
        """Tick until the root has ended, or until a condition of this object holds; returns the last outcome."""
        end = time.monotonic() + PATIENCE
        while True:
            outcome = self.tick()
            if wanted(self) if callable(wanted) else outcome in wanted:
                return outcome
            assert time.monotonic() < end, f"it never came: {outcome}, {self.feedback}"
            time.sleep(PERIOD)

    def end(self) -> str:
        return self.until(("SUCCESS", "FAILURE"))

    def close(self) -> None:
        if hasattr(self, "plan"):
            self.plan.close()
        self.link.close()
        if self.node is not None:
            self.node.close()
