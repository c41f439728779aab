"""A robot in plain rclpy: a unicycle in the arena of EXP1 with LaserScan, sonars, odometry, wheels and cmd_vel.

`python tests/ros2/counterpart.py --help` lists the options. The robot imports nothing of rocs_bt. It prints one line
of JSON when it is ready, and one at its end (SIGTERM, SIGINT or `--duration`). A line with the name of a fault, or with
`fine`, `emergency_stop` or `released`, on its standard input takes effect at once; `report` prints a line.
"""

from __future__ import annotations

import argparse
import array
import json
import math
import queue
import signal
import sys
import threading
import time
from typing import Any

import numpy as np
import rclpy
from arena import Arena
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import BatteryState, JointState, LaserScan, Range
from std_msgs.msg import Bool, String

STEP = 0.01  # [s]
LATE = 0.02  # [s] delay of the machine that the log tells
STALL = 0.1  # [s] delay of the machine beyond which the world pauses
START = [-1.0, 2.0, math.radians(-63.0)]  # of R2 in EXP1
PEER = 0.25  # [m] radius of the other robot
WHEELS = {"left_wheel": -1, "right_wheel": 1}  # sides by joint
# Sonars of a Pioneer P3-DX: positions x, y [m] and headings [deg], clockwise from the left.
SONARS = [(0.069, 0.136, 90), (0.114, 0.119, 50), (0.148, 0.078, 30), (0.166, 0.027, 10)]
SONARS += [(x, -y, -yaw) for x, y, yaw in reversed(SONARS)]
SONARS += [(-0.157, -0.136, -90), (-0.203, -0.119, -130), (-0.237, -0.078, -150), (-0.255, -0.027, -170)]
SONARS += [(x, -y, -yaw) for x, y, yaw in reversed(SONARS[8:])]
CONE, SONAR_RANGE = math.radians(30.0), (0.1, 1.0)  # opening angle, and limits [m]
STOPPED = 1e-6  # [m/s], [rad/s]
FAULTS = {
    "scan_stops": "no scan is published any more",
    "odom_stops": "no odometry is published any more",
    "scan_nan": "every range is NaN",
    "scan_some_nan": "every tenth range is NaN",
    "scan_short": "a scan has half its ranges",
    "scan_empty": "a scan has no ranges",
    "scan_string": "the scan's topic carries std_msgs/String from the start",
    "odom_nan": "the position is NaN",
    "stamps_zero": "the stamps of headers are zero",
    "stamps_future": "the stamps of headers are of the year 2100",
    "stamps_past": "the stamps of headers are ten minutes old",
}


def qos(policy: str, depth: int) -> QoSProfile:
    """QoS from `best_effort` or `reliable`, with `+latched` for transient local durability."""
    name, _, latched = policy.partition("+")
    durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
    return QoSProfile(depth=depth, reliability=ReliabilityPolicy[name.upper()], durability=durability)


class Peer:
    """Another robot, a disc that drives to and fro between two points and stops before the first robot."""

    def __init__(self, course: str) -> None:
        x, y, self.to_x, self.to_y, self.speed = map(float, course.split(","))
        self.x, self.y, self.from_x, self.from_y = x, y, x, y

    def step(self, x: float, y: float) -> None:
        """Drive for a step, unless the robot at (x, y) is near."""
        if math.hypot(self.x - x, self.y - y) < PEER + 0.45:
            return
        dx, dy = self.to_x - self.x, self.to_y - self.y
        left, go = math.hypot(dx, dy), self.speed * STEP
        if left <= go:
            self.to_x, self.to_y, self.from_x, self.from_y = self.from_x, self.from_y, self.to_x, self.to_y
        else:
            self.x, self.y = self.x + dx / left * go, self.y + dy / left * go


class Robot:
    """Kinematics, and what happened so far."""

    def __init__(self, options: argparse.Namespace) -> None:
        self.options, self.arena = options, Arena()
        self.x, self.y, self.yaw = options.pose
        self.v = self.w = self.wanted_v = self.wanted_w = 0.0
        self.peer = Peer(options.peer) if options.peer else None
        self.commanded: float | None = None  # monotonic time of the last command
        self.first_motion: float | None = None  # monotonic time of the first command that moves
        self.commands, self.expired, self.collided = 0, 0, False
        self.emergency_stop, self.faults = False, set(options.fault if options.after == 0.0 else ())
        self.clearance = self.min_clearance = self.arena.clearance(self.x, self.y, self.yaw, self.disc)

    @property
    def disc(self) -> tuple[float, float, float] | None:
        return None if self.peer is None else (self.peer.x, self.peer.y, PEER)

    @property
    def moves(self) -> bool:
        return abs(self.v) > STOPPED or abs(self.w) > STOPPED

    def command(self, v: float, w: float) -> None:
        self.commands, self.commanded = self.commands + 1, time.monotonic()
        if self.first_motion is None and (v or w):
            self.first_motion = self.commanded
        most_v, most_w = self.options.max_speed, self.options.max_turn_rate
        self.wanted_v, self.wanted_w = min(max(v, -most_v), most_v), min(max(w, -most_w), most_w)

    def step(self) -> None:
        """Advance by STEP, with the robot's own time-out of commands."""
        now = time.monotonic()
        if self.first_motion is not None and now - self.first_motion >= self.options.after:
            self.faults.update(self.options.fault)
        if self.commanded is not None and now - self.commanded > self.options.timeout:
            self.expired += bool(self.wanted_v or self.wanted_w)
            self.wanted_v = self.wanted_w = 0.0
            self.commanded = None
        v, w = (0.0, 0.0) if self.emergency_stop else (self.wanted_v, self.wanted_w)
        most_v, most_w = self.options.max_acceleration * STEP, self.options.max_turn_acceleration * STEP
        self.v += min(max(v - self.v, -most_v), most_v)
        self.w += min(max(w - self.w, -most_w), most_w)
        if self.peer is not None:
            self.peer.step(self.x, self.y)
        middle = self.yaw + 0.5 * self.w * STEP
        x, y = self.x + self.v * math.cos(middle) * STEP, self.y + self.v * math.sin(middle) * STEP
        yaw = math.remainder(self.yaw + self.w * STEP, math.tau)
        self.clearance = self.arena.clearance(x, y, yaw, self.disc)
        self.min_clearance = min(self.min_clearance, self.clearance)
        if self.clearance > 0.0:
            self.x, self.y, self.yaw = x, y, yaw
        else:
            self.collided, self.v, self.w = self.collided or self.moves, 0.0, 0.0

    def report(self) -> dict[str, Any]:
        return {
            "pose": [self.x, self.y, self.yaw],
            "speeds": [self.v, self.w],
            "collided": self.collided,
            "min_clearance": self.min_clearance,
            "commands": self.commands,
            "expired": self.expired,  # times that its own time-out stopped it
            "faults": sorted(self.faults),
        }


class RobotNode:
    """ROS 2 interface of the robot."""

    def __init__(self, robot: Robot) -> None:
        self.robot, self.options = robot, robot.options
        self.node = rclpy.create_node("robot", namespace=self.options.namespace)
        self.angles = np.linspace(-math.pi, math.pi, self.options.beams, endpoint=False)
        scan, odom = qos(self.options.scan_qos, 5), qos(self.options.odom_qos, 5)
        self.scan_type = String if "scan_string" in self.options.fault else LaserScan
        self.scan = self.node.create_publisher(self.scan_type, "scan", scan)
        names = [f"sonar{i}" for i in range(len(SONARS))] if self.options.sonars else []
        self.sonars = {name: self.node.create_publisher(Range, f"range/{name}", scan) for name in names}
        self.odom = self.node.create_publisher(Odometry, "odom", odom)
        self.joints = self.node.create_publisher(JointState, "joint_states", odom)
        self.battery = self.node.create_publisher(BatteryState, "battery_state", qos("reliable", 1))
        self.stopped = self.node.create_publisher(Bool, "emergency_stop", qos("reliable+latched", 1))
        self.diagnostics = self.node.create_publisher(DiagnosticArray, "/diagnostics", qos("reliable", 10))
        self.stopped.publish(Bool(data=False))
        self.stamped = TwistStamped if self.options.stamped else Twist
        self.node.create_subscription(self.stamped, "cmd_vel", self.receive, qos(self.options.cmd_qos, 1))
        self.log = open(self.options.log, "w", buffering=1) if self.options.log else None  # noqa: SIM115 - open to the end
        self.inputs: queue.SimpleQueue[str] = queue.SimpleQueue()
        threading.Thread(target=self.listen, daemon=True).start()
        self.steps = 0

    def listen(self) -> None:
        for line in sys.stdin:
            self.inputs.put(line.strip())

    def receive(self, message: Any, info: dict[str, int]) -> None:
        """Take a command. The log has its times of receipt, publication and header [s since 1970], and its twist."""
        twist = message.twist if self.options.stamped else message
        header = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec if self.options.stamped else None
        self.robot.command(twist.linear.x, twist.angular.z)
        self.note("command", 1e-9 * info["source_timestamp"], header, twist.linear.x, twist.angular.z)

    def note(self, what: str, *values: float | None) -> None:
        """Write a line to the log."""
        if self.log is not None:
            self.log.write(json.dumps([time.time(), what, *values]) + "\n")

    def step(self) -> None:
        while not self.inputs.empty():
            self.obey(self.inputs.get())
        moved = self.robot.moves
        self.robot.step()
        if moved and not self.robot.moves:
            self.note("stopped")
        for rate, publish in (
            (self.options.scan_rate, self.publish_scan),
            (self.options.scan_rate, self.publish_sonars),
            (self.options.odom_rate, self.publish_odom),
            (1.0, self.publish_state),
        ):
            if self.steps % round(1.0 / (rate * STEP)) == 0:
                publish()
        self.steps += 1

    def obey(self, line: str) -> None:
        if line in ("emergency_stop", "released"):
            self.robot.emergency_stop = line == "emergency_stop"
            self.stopped.publish(Bool(data=self.robot.emergency_stop))
        elif line == "report":
            tell(self.robot.report())
        elif line == "fine":
            self.robot.faults.clear()
        elif line in FAULTS:
            self.robot.faults.add(line)
            self.note("fault")

    def stamp(self, header: Any, frame: str) -> None:
        faults, now = self.robot.faults, self.node.get_clock().now()
        if "stamps_past" in faults:
            now -= Duration(seconds=600.0)
        header.frame_id, header.stamp = frame, now.to_msg()
        if "stamps_zero" in faults:
            header.stamp.sec = header.stamp.nanosec = 0
        if "stamps_future" in faults:
            header.stamp.sec = 2**31 - 1 - 86400  # January 2038 is as far as it goes

    def publish_scan(self) -> None:
        robot, faults = self.robot, self.robot.faults
        if "scan_stops" in faults:
            return
        if self.scan_type is String:
            self.scan.publish(String(data="no scan"))
            return
        ranges = robot.arena.ranges(robot.x, robot.y, self.angles + robot.yaw, robot.disc)
        ranges[ranges > self.options.max_range] = math.inf
        if "scan_nan" in faults:
            ranges[:] = math.nan
        if "scan_some_nan" in faults:
            ranges[::10] = math.nan
        count = 0 if "scan_empty" in faults else len(ranges) // 2 if "scan_short" in faults else len(ranges)
        scan = LaserScan(angle_min=-math.pi, range_min=0.05, range_max=self.options.max_range)
        scan.angle_increment = math.tau / len(ranges)
        scan.angle_max = scan.angle_min + (len(ranges) - 1) * scan.angle_increment
        scan.scan_time = 1.0 / self.options.scan_rate
        scan.ranges = array.array("f", ranges[:count].astype(np.float32).tobytes())
        self.stamp(scan.header, "base_scan")
        self.scan.publish(scan)

    def publish_sonars(self) -> None:
        """Publish the nearest echo in the cone of each sonar."""
        robot, (low, high) = self.robot, SONAR_RANGE
        cos, sin, cone = math.cos(robot.yaw), math.sin(robot.yaw), np.linspace(-CONE / 2, CONE / 2, 5)
        for (name, publisher), (x, y, heading) in zip(self.sonars.items(), SONARS, strict=False):
            place, yaw = (robot.x + x * cos - y * sin, robot.y + x * sin + y * cos), robot.yaw + math.radians(heading)
            nearest = float(robot.arena.ranges(*place, cone + yaw, robot.disc).min())
            echo = Range(radiation_type=Range.ULTRASOUND, field_of_view=CONE, min_range=low, max_range=high)
            echo.range = math.inf if nearest > high else nearest
            self.stamp(echo.header, name)
            publisher.publish(echo)

    def publish_odom(self) -> None:
        robot, faults = self.robot, self.robot.faults
        if "odom_stops" in faults:
            return
        odom = Odometry(child_frame_id="base_link")
        odom.pose.pose.position.x = math.nan if "odom_nan" in faults else robot.x
        odom.pose.pose.position.y = robot.y
        odom.pose.pose.orientation.z, odom.pose.pose.orientation.w = math.sin(robot.yaw / 2), math.cos(robot.yaw / 2)
        odom.twist.twist.linear.x, odom.twist.twist.angular.z = robot.v, robot.w
        self.stamp(odom.header, "odom")
        self.odom.publish(odom)
        turning = 0.5 * self.options.wheel_separation * robot.w
        joints = JointState(name=list(WHEELS))
        joints.velocity = [(robot.v + side * turning) / self.options.wheel_radius for side in WHEELS.values()]
        self.stamp(joints.header, "")
        self.joints.publish(joints)

    def publish_state(self) -> None:
        spent = self.steps * STEP / 3600.0
        battery = BatteryState(voltage=12.6 - spent, percentage=max(0.9 - spent, 0.0), present=True)
        self.stamp(battery.header, "base_link")
        self.battery.publish(battery)
        level = DiagnosticStatus.ERROR if self.robot.emergency_stop else DiagnosticStatus.OK
        state = DiagnosticStatus(level=level, name="robot: base", message="emergency stop" * self.robot.emergency_stop)
        array_ = DiagnosticArray(status=[state])
        self.stamp(array_.header, "")
        self.diagnostics.publish(array_)


def tell(values: dict[str, Any]) -> None:
    print(json.dumps(values), flush=True)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--namespace", default="")
    parser.add_argument("--pose", type=float, nargs=3, default=START, help="x, y [m], yaw [rad]")
    parser.add_argument("--max-speed", type=float, default=1.2, help="[m/s]")
    parser.add_argument("--max-turn-rate", type=float, default=4.0, help="[rad/s]")
    parser.add_argument("--max-acceleration", type=float, default=3.0, help="[m/s2]")
    parser.add_argument("--max-turn-acceleration", type=float, default=18.0, help="[rad/s2]")
    parser.add_argument("--wheel-separation", type=float, default=0.331, help="wheel separation [m]")
    parser.add_argument("--wheel-radius", type=float, default=0.0975, help="[m]")
    parser.add_argument("--timeout", type=float, default=0.3, help="age of a command at which the robot stops [s]")
    parser.add_argument("--stamped", action="store_true", help="cmd_vel is a TwistStamped")
    parser.add_argument("--sonars", action="store_true", help="sixteen sonars, range/sonar0 to range/sonar15")
    parser.add_argument("--beams", type=int, default=360)
    parser.add_argument("--max-range", type=float, default=8.0, help="[m]")
    parser.add_argument("--scan-rate", type=float, default=20.0, help="[Hz], a divisor of 100")
    parser.add_argument("--odom-rate", type=float, default=50.0, help="[Hz], a divisor of 100")
    parser.add_argument("--peer", default="", help="another robot: x,y,to_x,to_y,speed")
    parser.add_argument("--duration", type=float, default=120.0, help="[s]")
    parser.add_argument("--log", default="", help="file of JSON lines: commands, stops, faults, delays of the machine")
    parser.add_argument("--fault", action="append", default=[], choices=FAULTS, help=str(FAULTS))
    parser.add_argument("--after", type=float, default=0.0, help="time from the first motion to the faults [s]")
    for name, default in (("scan", "best_effort"), ("odom", "reliable"), ("cmd", "reliable")):
        parser.add_argument(f"--{name}-qos", default=default, help="best_effort or reliable; +latched")
    return parser.parse_args()


def main() -> None:
    options, ended = arguments(), threading.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: ended.set())
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    robot = Robot(options)
    node, executor = RobotNode(robot), SingleThreadedExecutor()
    executor.add_node(node.node)
    tell({"ready": True, "node": node.node.get_fully_qualified_name()})
    begun = due = last = time.monotonic()
    while not ended.is_set() and (now := time.monotonic()) < begun + options.duration:
        if now - last > LATE:
            node.note("late", now - last - STEP)
        last = now
        if now - due > STALL:
            due = now + STEP  # commands that wait are received first
        if now < due:
            executor.spin_once(timeout_sec=due - now)
        else:
            node.step()
            due += STEP
    tell(robot.report())


if __name__ == "__main__":
    main()
