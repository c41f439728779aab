"""Topics of a recording: standard ROS 2 messages from the events of a run (docs/ros2-without-a-robot.md lists them)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from ... import event as ev
from ...base.geometry import Pose3, Twist3
from ...catalog import RobotSpec
from ...event import Event
from ...record import BodyInfo, RunHeader
from ..messages import fields as messages
from ..messages.message_types import MESSAGES, ODOMETRY, POSE, TRANSFORMS, Channel, pose_values
from ..messages.names import BASE, MAP, ODOM
from .markers import scene
from .messages import BagMessages, Published, different_namespaces
from .sensors import SensorTopics

_ORIGIN = Pose3(0.0, 0.0, 0.0)
_MAP = Channel(MAP)


class RecordedTopics:
    """Converts the events of a recording to messages.

    With one agent, its topics and frames have the usual names (`/scan`, `base_link`); with several, each has the name
    of its agent before it (`/R2/scan`, `R2/base_link`). The frame `map` is common.

    Args:
        header: Header of the recording.
        robots: Robots by agent; without the robot of an agent, topics that need its drivers are missing.
        joints: Joints by agent and motor.
        start: Time of the messages at time 0 of the run [s since 1970].
    """

    def __init__(
        self,
        header: RunHeader,
        robots: Mapping[str, RobotSpec],
        joints: Mapping[str, Mapping[str, str]],
        start: float = 0.0,
    ) -> None:
        self._header = header
        self._start = start
        names = different_namespaces([*(a.name for a in header.agents), *(b.name for b in header.bodies)])
        spaces = _namespaces(header, robots, names)
        self._period = 1.0 / header.rates.get("control", 20.0)
        bodies = {body.name: body for body in header.bodies}
        self._agents: dict[str, AgentTopics] = {}
        for info in header.agents:
            name, robot = info.name, robots.get(info.name)
            body = bodies.get(name) or BodyInfo(name=name, hull=())
            own = BagMessages(spaces[name], start)
            sensors = SensorTopics(body, robot, joints.get(name, {}), own, self._period)
            self._agents[name] = AgentTopics(name, robot, sensors, own)
        self._movers = {body.name: names[body.name] for body in header.bodies if body.name not in self._agents}

    def published(self, events: Iterable[Event]) -> Iterator[Published]:
        """Messages in the order of their times."""
        yield from self._static()
        count = 0
        begin = now = self._header.start
        for event in events:
            if event.t > now:
                yield from self._finished(now)
                now = event.t
            while (tick := begin + count * self._period) <= now + 1e-9:
                at = self._start + tick
                yield Published("/clock", at, "rosgraph_msgs/msg/Clock", messages.clock(at))
                count += 1
            yield from self._of(event)
        yield from self._finished(now, over=True)

    def _static(self) -> Iterator[Published]:
        t, header = self._start + self._header.start, self._header
        frames = [messages.transform(t, *frame) for agent in self._agents.values() for frame in agent.frames()]
        yield Published("/tf_static", t, TRANSFORMS, messages.transforms(frames), latched=True)
        hulls = {self._movers.get(b.name) or self._agents[b.name].names.frame(BASE): b for b in header.bodies if b.hull}
        drawn = scene(t, MAP, header, hulls)
        yield Published("/scene", t, "visualization_msgs/msg/MarkerArray", drawn, latched=True)

    def _finished(self, t: float, *, over: bool = False) -> Iterator[Published]:
        """Messages that are complete when the time advances after t [s], or the recording is over."""
        for agent in self._agents.values():
            yield from agent.finished(t, over=over)

    def _of(self, event: Event) -> Iterator[Published]:
        if event.sentence:
            t, name = self._start + event.t, event.agent or "world"
            stamp = messages.time_fields(t)
            fields = {"stamp": stamp, "level": 10 * event.level, "name": name, "msg": event.sentence}
            yield Published("/rosout", t, "rcl_interfaces/msg/Log", fields)
        if isinstance(event, ev.BodyMoved):
            yield from self._moved(event)
        elif event.agent in self._agents:
            yield from self._agents[event.agent].take(event)

    def _moved(self, event: ev.BodyMoved) -> Iterator[Published]:
        pose = Pose3(event.x, event.y, event.height or 0.0, event.roll or 0.0, event.pitch or 0.0, event.yaw)
        if not self._header.simulated or not _finite(pose):  # on hardware it is the robot's own estimate
            return
        t, agent, frame = self._start + event.t, self._agents.get(event.body), self._movers.get(event.body)
        fields = MESSAGES[POSE].make(t, pose_values(pose), _MAP)
        if agent is not None:
            yield Published(agent.names.topic("ground_truth"), t, POSE, fields)
        elif frame is not None:
            yield Published("/tf", t, TRANSFORMS, MESSAGES[TRANSFORMS].make(t, pose_values(pose), Channel(MAP, frame)))
            yield Published(f"/{frame}/ground_truth", t, POSE, fields)


class AgentTopics:
    """Topics of one agent.

    Args:
        name: Name of the agent.
        robot: Its robot; None if unknown.
        sensors: Topics of its sensors.
        names: Names and times of its messages.
    """

    def __init__(self, name: str, robot: RobotSpec | None, sensors: SensorTopics, names: BagMessages) -> None:
        self.names = names
        self._name = name
        self._sensors = sensors
        self._measured = sensors.topics  # full names of topics
        self._motion = robot.motion.actuator if robot else ""
        self._locomotion = robot.locomotion if robot else None
        self._signals: dict[str, list[float]] = {}
        self._estimated: tuple[float, float] | None = None  # time and stamp of a new estimate of the pose [s]
        self._poses: dict[str, list[float]] = {}
        self._take: Mapping[type[Event], Callable[[Any], Iterable[Published]]] = {
            ev.SensorRead: sensors.take,
            ev.SignalsWritten: self._written,
            ev.ActuatorCommanded: self._commanded,
            ev.CommandExpired: self._expired,
            ev.RuleChanged: self._rule,
            ev.NodeTicked: self._ticked,
            ev.TicketChanged: self._ticket,
            ev.KnowledgeChanged: self._known,
        }

    def frames(self) -> Iterator[tuple[str, str, Pose3]]:
        """Constant transforms: parent, child, and pose in the parent."""
        yield MAP, self.names.frame(ODOM), _ORIGIN
        for frame, pose in self._sensors.frames():
            yield self.names.frame(BASE), frame, pose

    def take(self, event: Event) -> Iterable[Published]:
        """Messages about an event."""
        take = self._take.get(type(event))
        return () if take is None else take(event)

    def finished(self, t: float, *, over: bool) -> Iterator[Published]:
        """Messages that are complete when the time advances after t [s], or the recording is over."""
        yield from self._sensors.finished(t, over=over)
        yield from self._odometry()

    def _odometry(self) -> Iterator[Published]:
        """Odometry, after all monitors of the period have written: the robot's estimate of its pose and motion.

        Not on a topic of the robot's own sensors.
        """
        if self._estimated is None:
            return
        (t, stamp), self._estimated = self._estimated, None
        one = {name: values[0] for name, values in self._signals.items() if len(values) == 1}
        x, y, yaw = self._signals["pose"]
        pose = Pose3(x, y, one.get("height", 0.0), yaw=yaw)
        if not _finite(pose):
            return
        twist = Twist3(*(one.get(name, 0.0) for name in ("speed", "lateral_speed", "climb", "turn_rate")))
        channel = Channel(self.names.frame(ODOM), self.names.frame(BASE))
        values = {**pose_values(pose), "twist": twist}
        for topic, kind in (("odom", ODOMETRY), ("/tf", TRANSFORMS)):
            if self.names.topic(topic) not in self._measured:
                yield self.names.measured(topic, t, stamp, kind, values, channel)

    def _written(self, event: ev.SignalsWritten) -> Iterator[Published]:
        for name, values in event.values.items():
            self._signals[name] = values
            if values and name not in self._sensors.ranging:
                yield self.names.numbers(f"signals/{name}", event.t, values)
        if "pose" in event.signals:
            self._estimated = event.t, event.t if event.stamp is None else event.stamp

    def _commanded(self, event: ev.ActuatorCommanded) -> Iterator[Published]:
        values, locomotion = event.values, self._locomotion
        if locomotion is not None and event.actuator == self._motion and len(values) == len(locomotion.values):
            yield self._twist(event.t, locomotion.twist3(values))
        elif values:
            yield self.names.numbers(f"commands/{event.actuator}", event.t, values)

    def _expired(self, event: ev.CommandExpired) -> Iterator[Published]:
        if event.actuator == self._motion:
            yield self._twist(event.t, Twist3(0.0))

    def _twist(self, t: float, twist: Twist3) -> Published:
        fields = messages.twist_stamped(self.names.start + t, self.names.frame(BASE), twist)
        return self.names.published("cmd_vel", t, "geometry_msgs/msg/TwistStamped", fields)

    def _rule(self, event: ev.RuleChanged) -> Iterator[Published]:
        reading = f": {event.reading}" if event.reading else ""
        yield self.names.text("rules", event.t, f"{event.rule} {event.phase}{reading}")
        if event.phase in ("fired", "ended"):
            active = {"data": event.phase == "fired"}
            yield self.names.published(f"rules/{event.rule}", event.t, "std_msgs/msg/Bool", active)

    def _ticked(self, event: ev.NodeTicked) -> Iterator[Published]:
        feedback = f" ({event.feedback})" if event.feedback else ""
        yield self.names.text("mission", event.t, f"{event.node}: {event.status}{feedback}")

    def _ticket(self, event: ev.TicketChanged) -> Iterator[Published]:
        reason = f": {event.reason}" if event.reason else ""
        yield self.names.text(
            "actions", event.t, f"{event.action} {event.state} ({event.priority}, {event.by}){reason}"
        )

    def _known(self, event: ev.KnowledgeChanged) -> Iterator[Published]:
        """The pose of the goal that the agent begins to pursue."""
        value = event.value
        if event.what == "attribute" and event.name == "pose" and isinstance(value, (list, tuple)) and len(value) == 3:
            self._poses[event.subject] = [float(v) if isinstance(v, (int, float)) else math.nan for v in value]
        elif event.what == "edge added" and event.name == "pursues" and event.subject == self._name:
            x, y, yaw = self._poses.get(str(value), (math.nan,) * 3)
            if _finite((x, y)):
                pose = Pose3(x, y, 0.0, yaw=yaw if math.isfinite(yaw) else 0.0)
                yield self.names.measured("goal_pose", event.t, event.t, POSE, pose_values(pose), _MAP)


def _namespaces(header: RunHeader, robots: Mapping[str, RobotSpec], names: Mapping[str, str]) -> Mapping[str, str]:
    """Namespace of each agent: on hardware that of its robot, if they differ; else none, or one for each of several."""
    agents = [agent.name for agent in header.agents]
    if not header.simulated:
        settings = {name: robots[name].tables["ros2"] for name in agents if "ros2" in robots[name].tables}
        own = {name: each.namespace.strip("/") for name, each in settings.items()}
        if len(own) == len(set(own.values())) == len(agents):
            return own
    return names if len(agents) > 1 else dict.fromkeys(agents, "")


def _finite(values: Iterable[float]) -> bool:
    return all(map(math.isfinite, values))
