"""A program in plain rclpy, without code of rocs_bt: an action server, services, and topics to talk to.

It prints a line of JSON for each thing that happens to it. The goals of `fibonacci`: an order below 0 is rejected, one
of 40 or more is aborted, and any other is computed at 20 numbers a second, with feedback, until it is done or cancelled
(an order of 30 or more refuses that). A goal of DEAF is never answered. Meanwhile it publishes 0.15 m/s on
`cmd_vel_nav2`, as a navigator does. A goal of NAVIGATE begins when that topic has a subscription, because it may be
discovered later than the action, and takes twice as long, because the subscription may receive the first messages up to
3 s later. `lamp` (SetBool) answers; `deaf` (SetBool) never does, for it sleeps. Texts on `say` come back on `echo` and,
latched, on `last`; `beat` (best effort) counts at 20 Hz.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import rclpy
from geometry_msgs.msg import TwistStamped
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from std_msgs.msg import Int32, String
from std_srvs.srv import SetBool
from test_msgs.action import Fibonacci

PRINTING = threading.Lock()
NAVIGATE, DEAF = 39, 38


def happened(what: str, value: Any = None) -> None:
    with PRINTING:
        print(json.dumps([what, value]), flush=True)


def asked(goal: Any) -> GoalResponse:
    happened("asked", goal.order)
    if goal.order == DEAF:
        time.sleep(3600.0)
    return GoalResponse.REJECT if goal.order < 0 else GoalResponse.ACCEPT


def cancel(handle: Any) -> CancelResponse:
    happened("cancel", handle.request.order)
    return CancelResponse.REJECT if handle.request.order >= 30 else CancelResponse.ACCEPT


def execute(handle: Any, drive: Callable[[], None], heard: Callable[[], int]) -> Fibonacci.Result:
    order, sequence = handle.request.order, [0, 1]
    while order == NAVIGATE and not heard():
        time.sleep(0.05)
    while len(sequence) <= order and order < 40:
        if handle.is_cancel_requested:
            handle.canceled()
            happened("cancelled", len(sequence))
            return Fibonacci.Result(sequence=sequence)
        sequence.append((sequence[-1] + sequence[-2]) % 2**31)
        handle.publish_feedback(Fibonacci.Feedback(sequence=sequence))
        for _ in range(2 if order == NAVIGATE else 1):
            drive()
            time.sleep(0.05)
    if order < 40:
        handle.succeed()
    else:
        handle.abort()
    happened("ended", order)
    return Fibonacci.Result(sequence=sequence)


def lamp(request: Any, response: Any) -> Any:
    happened("lamp", request.data)
    response.success, response.message = request.data, "on" if request.data else "no bulb"
    return response


def deaf(request: Any, response: Any) -> Any:
    happened("deaf", request.data)
    time.sleep(3600.0)
    return response


def main() -> None:
    rclpy.init()
    node = rclpy.create_node("servers", namespace=sys.argv[1] if len(sys.argv) > 1 else "")
    group = ReentrantCallbackGroup()
    twists = node.create_publisher(TwistStamped, "cmd_vel_nav2", 1)

    def drive() -> None:
        message = TwistStamped()
        message.twist.linear.x = 0.15
        twists.publish(message)

    callbacks = {"goal_callback": asked, "cancel_callback": cancel, "callback_group": group}
    ActionServer(
        node, Fibonacci, "fibonacci", lambda handle: execute(handle, drive, twists.get_subscription_count), **callbacks
    )
    node.create_service(SetBool, "lamp", lamp, callback_group=group)
    node.create_service(SetBool, "deaf", deaf, callback_group=group)
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    echo, last = node.create_publisher(String, "echo", 10), node.create_publisher(String, "last", latched)
    beat, count = node.create_publisher(Int32, "beat", qos_profile_sensor_data), iter(range(10**9))

    def heard(message: Any) -> None:
        happened("heard", message.data)
        echo.publish(message)
        last.publish(message)

    node.create_subscription(String, "say", heard, 10, callback_group=group)
    node.create_timer(0.05, lambda: beat.publish(Int32(data=next(count))))
    executor = MultiThreadedExecutor(num_threads=6)
    executor.add_node(node)
    happened("ready")
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        executor.spin()


if __name__ == "__main__":
    main()
