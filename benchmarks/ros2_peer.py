"""Robot of `bench_ros2` as a process: publishes scans of 720 beams at 20 Hz, and prints when it was told to back off.

A line on standard input, `near` or `far`, moves the obstacle. Each output line has the times [s since 1970] at which
the first near scan was published and the first backward command arrived.
"""

from __future__ import annotations

import math
import os
import sys
import time

import numpy as np

from rocs_bt.ros2.devices.parameters import TWIST
from rocs_bt.ros2.messages.message_types import SCAN
from rocs_bt.ros2.network.connect import open_transport
from rocs_bt.ros2.network.qos import QoS
from rocs_bt.ros2.settings import Ros2Settings

BEAMS, RATE = 720, 20.0
SPAN = 2.0 * math.pi * (BEAMS - 1) / BEAMS
RAYS, NEAR, FAR = 16, 0.15, 1.5  # [m]


def ranges(ahead: float) -> list[float]:
    """Ranges of the beams, as sixteen sectors with an obstacle in two of them."""
    sectors = np.array([2.0 if i > 8 else ahead if i in (3, 4) else 1.5 for i in range(RAYS)])
    places = np.arange(BEAMS) / (BEAMS - 1) * (RAYS - 1)
    values: list[float] = sectors[np.round(places).astype(int)].tolist()
    return values


def main() -> None:
    """Serve until standard input ends."""
    transport = open_transport(Ros2Settings(transport="dds"), "peer")
    types = transport.types
    scans = transport.writer("/scan", SCAN, QoS.SENSOR)
    commands = transport.reader("/cmd_vel", TWIST, QoS.COMMAND)
    geometry = {"angle_min": -0.5 * SPAN, "angle_increment": SPAN / (BEAMS - 1), "range_min": 0.1, "range_max": 10.0}
    near, due, published = False, time.monotonic(), math.nan
    os.set_blocking(0, False)
    while True:
        try:
            if not (told := os.read(0, 100)):
                return
            near, published = told.split()[-1] == b"near", math.nan
        except BlockingIOError:
            pass
        if time.monotonic() >= due:
            due += 1.0 / RATE
            message = types.make(SCAN, ranges=ranges(NEAR if near else FAR), **geometry)
            if near and math.isnan(published):
                published = time.time()
            scans.write(types.serialize(message))
        for sample in commands.take_all():
            if near and types.deserialize(sample.data, TWIST).linear.x < -1e-3 and published > 0.0:
                print(published, time.time(), flush=True)
                near = False
        time.sleep(2e-4)


if __name__ == "__main__":
    sys.exit(main())
