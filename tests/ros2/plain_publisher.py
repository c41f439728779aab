"""A plain publisher of ranges and odometry over DDS: `plain_publisher.py LATE`, with header stamps LATE seconds old."""

import sys
import time

from rocs_bt.ros2.network.connect import open_transport
from rocs_bt.ros2.network.qos import QoS
from rocs_bt.ros2.settings import Ros2Settings

late = float(sys.argv[1])
transport = open_transport(Ros2Settings(transport="dds"), "plain")
types = transport.types
ranges = transport.writer("/range", "sensor_msgs/msg/Range", QoS.SENSOR)
odom = transport.writer("/odom", "nav_msgs/msg/Odometry", QoS.SENSOR)
commands = transport.reader("/cmd_vel", "geometry_msgs/msg/Twist", QoS.COMMAND)
print("ready", flush=True)
while True:
    now = time.time() - late
    header = {"stamp": {"sec": int(now), "nanosec": int(1e9 * (now % 1.0))}, "frame_id": "odom"}
    ranges.write(types.serialize(types.make(ranges.type, header=header, range=0.5, max_range=1.0)))
    pose = {"pose": {"orientation": {"w": 1.0}}}
    odom.write(types.serialize(types.make(odom.type, header=header, pose=pose)))
    time.sleep(0.02)
