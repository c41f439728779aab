"""A fake connection to ROS 2: it knows a few types, remembers what was sent, and receives what a test sets."""

from types import SimpleNamespace

from rocs_bt.base.errors import DeviceError, Fault, InputError, unknown
from rocs_bt.ros2.ros_link import GoalState, RosField

from .nav2_msgs import NAV2_MSGS

TIME = "builtin_interfaces/msg/Time"
TYPES = {
    "std_msgs/msg/String": {"data": RosField("string")},
    "std_msgs/msg/Int8": {"data": RosField("int8")},
    "geometry_msgs/msg/Vector3": {axis: RosField("float64") for axis in "xyz"},
    "geometry_msgs/msg/Twist": {
        "linear": RosField("geometry_msgs/msg/Vector3"),
        "angular": RosField("geometry_msgs/msg/Vector3"),
    },
    "geometry_msgs/msg/Polygon": {"points": RosField("geometry_msgs/msg/Vector3", array=True)},
    "sensor_msgs/msg/Scan": {
        "stamp": RosField(TIME),
        "ranges": RosField("float32", array=True),
        "covariance": RosField("float64", array=True, size=4),
        "names": RosField("string", array=True),
        "valid": RosField("bool"),
    },
    TIME: {"sec": RosField("int32"), "nanosec": RosField("uint32")},
    "std_srvs/srv/SetBool_Request": {"data": RosField("bool")},
    "std_srvs/srv/SetBool_Response": {"success": RosField("bool"), "message": RosField("string")},
    "test_msgs/action/Fibonacci_Goal": {"order": RosField("int32")},
    "test_msgs/action/Fibonacci_Feedback": {"sequence": RosField("int32", array=True)},
    "test_msgs/action/Fibonacci_Result": {"sequence": RosField("int32", array=True)},
    **NAV2_MSGS,
}


class Types:
    def fields(self, type):
        if type.split("/")[0] not in {name.split("/")[0] for name in TYPES}:
            return None
        if type not in TYPES:
            raise InputError(unknown("type", type, TYPES))
        return TYPES[type]


class Message:
    def __init__(self, value):
        self.value = value

    def get(self, path=()):
        value = self.value
        for part in path:
            value = value[part]
        return value


class Link:
    """A connection that remembers what was opened and sent; tests set what arrives."""

    def __init__(self):
        self.types = Types()
        self.opened, self.sent, self.closed = [], [], []
        self.here, self.newest, self.refuses = True, None, ""
        self.mismatch, self.servers = "", {"1": "/r1/servers"}
        self.matched, self.calls, self.goals = 1, [], []
        self.accepting, self.asked = False, None
        self.topics, self.triggered = {}, set()

    def open(self, kind, *of):
        if self.refuses:
            raise InputError(Fault(self.refuses))
        self.opened.append((kind, *of))
        return SimpleNamespace(
            matched=lambda: self.matched,
            publish=self.publish,
            newest=lambda: self.topics.get(of[0], self.newest),
            taken=lambda: bool(self.triggered & {of[0]}) and not self.triggered.discard(of[0]),
            ignored="",
            ready=lambda: self.here,
            mismatch=lambda: self.mismatch,
            servers=lambda: self.servers,
            call=lambda request: self.keep(self.calls, request, response=None, error="", forgotten=False),
            send=lambda goal: self.keep(
                self.goals, goal, state=GoalState.SENT, feedback=None, feedback_count=0, result=None, error=""
            ),
            open=self.accept,
            goal=lambda: self.asked,
            close=lambda: self.closed.append((kind, *of)),
        )

    def publish(self, values):
        if not self.here:
            raise DeviceError("the network is down")
        self.sent.append(values)

    def keep(self, kept, values, **fields):
        made = SimpleNamespace(values=values, cancelled=0, **fields)
        made.forget = lambda: setattr(made, "forgotten", True)
        made.cancel = lambda: setattr(made, "cancelled", made.cancelled + 1)
        kept.append(made)
        return made

    def accept(self, accepting):
        self.accepting = accepting

    def publisher(self, *of):
        return self.open("publisher", *of)

    def subscription(self, *of):
        return self.open("subscription", *of)

    def service(self, *of):
        return self.open("service", *of)

    def action(self, *of):
        return self.open("action", *of)

    def action_server(self, *of):
        return self.open("action_server", *of)

    def trigger(self, *of):
        return self.open("trigger", *of)


def after(mind, seconds):
    """Advance the clock of the test robot."""
    mind.rig.clock.advance(round(seconds / mind.rig.clock.step))
