"""Nodes that read topics of a running Nav2, or are commanded by services, with the names and ports of Nav2's nodes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar, Final

from ...base.errors import DeviceError, InputError
from ...nav2.decorators import GoalUpdater as CopiesGoal
from ...nav2.nodes import NAV2
from ...nav2.poses import list_of, pose_of
from ...nav2.tables import BatteryCondition, Selector, made_node
from ...plan.context import MissionContext, mission_of
from ...trees.nodes import FAILURE, SUCCESS, Node, Outcome, Syntax, port_of
from ...trees.nodes.control.navigation import PauseResumeController as Pausing
from ..ros_link import NO_LINK, RosLink
from .nav2_messages import STAMPED, stamped_message
from .uses_ros import Endpoint, parse_name

Open = Callable[[RosLink], Endpoint]


class Connected(Node):
    """Base of nodes with endpoints of the robot's ROS connection, which are opened before the run, or when first used.

    Without a connection, or if the network refuses it, an endpoint is None.
    """

    _endpoints: dict[str, Any] | None = None

    def endpoints(self) -> Mapping[str, Open]:
        """Functions that open the endpoints, by name of the topic or service."""
        raise NotImplementedError

    def setup(self, **kwargs: Any) -> None:
        super().setup(**kwargs)
        self.opened()

    def opened(self) -> dict[str, Any]:
        """Endpoints that are open, by name."""
        if self._endpoints is None:
            owner = self.runtime.owner
            link = owner.services.get("ros2") if isinstance(owner, MissionContext) else None
            self._endpoints = {}
            if link is not None:
                self._connect(link, self._endpoints)
        return self._endpoints

    def _connect(self, link: RosLink, endpoints: dict[str, Any]) -> None:
        for name, connect in self.endpoints().items():
            try:
                endpoints[name] = connect(link)
            except (InputError, DeviceError) as error:
                self.feedback_message = str(error)

    def newest(self, topic: str) -> Any:
        """Plain values of the newest message of a topic; None if there is none."""
        found = self.opened().get(topic)
        received = None if found is None else found.newest()
        return None if received is None else received.message.get()

    def shutdown(self) -> None:
        for endpoint in (self._endpoints or {}).values():
            endpoint.close()
        self._endpoints = None
        super().shutdown()


def _topic(name: str, type: str, qos: str) -> tuple[str, Open]:
    return name, lambda link: link.subscription(name, type, qos)


class _Selector(Connected, Selector):
    def endpoints(self) -> Mapping[str, Open]:
        return dict([_topic(self.read("topic_name"), "std_msgs/msg/String", "latched")])

    def selected(self) -> str:
        newest = self.newest(self.read("topic_name"))
        return str(newest["data"]) if newest else ""


CHARGING = 1
"""Status of a charging battery in sensor_msgs/BatteryState."""


class _Battery(Connected, BatteryCondition):
    def endpoints(self) -> Mapping[str, Open]:
        return dict([_topic(self.read("battery_topic"), "sensor_msgs/msg/BatteryState", "sensor_data")])

    def update(self) -> Outcome:
        state = self.newest(topic := self.read("battery_topic"))
        self.feedback_message = "" if state else f"there is no message on '{topic}'" if self.opened() else NO_LINK
        return SUCCESS if state and self.holds(state) else FAILURE

    def holds(self, state: Mapping[str, Any]) -> bool:
        """Whether the condition is true for a message."""
        raise NotImplementedError


class _BatteryLow(_Battery):
    def holds(self, state: Mapping[str, Any]) -> bool:
        value = state["voltage" if self.read("is_voltage") else "percentage"]
        return bool(value <= self.read("min_battery"))


class _BatteryCharging(_Battery):
    def holds(self, state: Mapping[str, Any]) -> bool:
        return bool(state["power_supply_status"] == CHARGING)


class GoalUpdater(Connected, CopiesGoal):
    """Ticks its child with the goal, or with a newer one from the topic `goal_update`, or `goals_update` for a list."""

    topics: ClassVar[Mapping[str, tuple[str, str]]] = {
        "goal": ("goal_update", STAMPED),
        "goals": ("goals_update", "nav_msgs/msg/Goals"),
    }

    def endpoints(self) -> Mapping[str, Open]:
        used = [topic for name, topic in self.topics.items() if self.key(f"output_{name}") is not None]
        return dict(_topic(name, type, "reliable") for name, type in used)

    def goal(self, name: str) -> Any:
        given, newest = super().goal(name), self.newest(self.topics[name][0])
        stamp = _stamp(newest)
        value = newest if stamp > (0, 0) and stamp >= _stamp(given) else given
        # The output always has the form of the topic, because the first write of a key fixes its type.
        if name == "goals":
            return None if value is None else [self._stamped(each) for each in list_of(value)]
        return None if value in (None, "") else self._stamped(value)

    def _stamped(self, value: Any) -> Any:
        if isinstance(value, Mapping):
            return value
        pose = pose_of(mission_of(self), value)
        return value if pose is None else stamped_message(pose, "map")


def _stamp(message: Any) -> tuple[int, int]:
    """Time of the plain values of a message; zero for other values."""
    stamp = message.get("header", {}).get("stamp", {}) if isinstance(message, Mapping) else {}
    return int(stamp.get("sec", 0)), int(stamp.get("nanosec", 0))


class PauseResumeController(Connected, Pausing):
    """Ticks its first child, or its second while paused; its third when a pause begins, its fourth when the pause ends.

    Any program pauses and resumes it by its two services (std_srvs/Trigger). Without their names, or without ROS, the
    port `paused` does.
    """

    def endpoints(self) -> Mapping[str, Open]:
        names = filter(None, (self.read("pause_service_name"), self.read("resume_service_name")))
        return {parse_name(name): _triggered(name) for name in names}

    def wanted(self) -> bool:
        opened = self.opened()
        if not opened:
            return super().wanted()
        asked = {name: trigger.taken() for name, trigger in opened.items()}
        if any(asked.values()):
            self._paused = asked.get(self.read("pause_service_name"), False)
        return self._paused

    _paused = False


def _triggered(name: str) -> Open:
    return lambda link: link.trigger(name)


def _selector(tag: str) -> type[Node]:
    default = NAV2[tag].tag.removesuffix("Selector")
    topic = "".join(f"_{c.lower()}" if c.isupper() else c for c in default).strip("_") + "_selector"
    port = port_of(str, "topic with the name, latched", Syntax(parse_name), default=topic)
    what = f"Writes the last text of `topic_name` to its output; the default before there is one. ({default})"
    return made_node(tag, _Selector, what, {**_own(tag), "topic_name": port}, __name__)


def _own(tag: str) -> dict[str, Any]:
    what = vars(NAV2[tag]).get("what", "")
    return {**NAV2[tag].ports, **({"what": what} if what else {})}


_BATTERY: Final = {"battery_topic": port_of(str, "topic with the state", Syntax(parse_name), default="/battery_status")}
_LOW: Final = "SUCCESS if the percentage (0 to 1) or voltage is at most `min_battery`; FAILURE before a message."
_CHARGES: Final = "SUCCESS if the battery is charging; FAILURE before a message."

TOPIC_NODES: Final[tuple[type[Node], ...]] = (
    *(_selector(tag) for tag in NAV2 if tag.endswith("Selector")),
    made_node("IsBatteryLow", _BatteryLow, _LOW, {**_own("IsBatteryLow"), **_BATTERY}, __name__),
    made_node("IsBatteryCharging", _BatteryCharging, _CHARGES, _BATTERY, __name__),
    GoalUpdater,
    PauseResumeController,
)
"""Nodes that read topics or are commanded by services."""
