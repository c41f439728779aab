"""RclpyTransport: ROS 2 through rclpy, of an installation of ROS 2."""

from __future__ import annotations

import importlib
import os
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ...base.errors import DeviceError, Fault, InputError
from ..messages.type_store import TypeStore
from ..settings import Ros2Settings
from .qos import QoS
from .transport import Endpoint, Sample

_UNKNOWN = ("_NODE_NAME_UNKNOWN_", "_CREATED_BY_BARE_DDS_APP_")
_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
_OTHERS = ("ROS_STATIC_PEERS", "ROS_LOCALHOST_ONLY")  # they extend or override the range


def has_rclpy() -> bool:
    """Whether rclpy can be imported here."""
    try:
        importlib.import_module("rclpy")
    except ImportError:
        return False
    return True


def definition(name: str) -> str | None:
    """Text of the .msg file of an installed ROS package; None if it is not installed."""
    package, _, message = name.split("/")
    try:
        share = importlib.import_module("ament_index_python").get_package_share_directory(package)
        with open(os.path.join(share, "msg", f"{message}.msg"), encoding="utf-8") as file:
            return file.read()
    except (ImportError, LookupError, OSError):
        return None


class RclpyTransport:
    """Node of rclpy, without an executor: endpoints are polled and carry raw CDR.

    Raises:
        InputError: rclpy is not installed, or the environment contradicts `network = "lan"`.
        DeviceError: The network cannot be joined.
    """

    def __init__(self, settings: Ros2Settings, types: TypeStore, node: str) -> None:
        self.name = "rclpy"
        self.types = types
        rclpy = _import("rclpy", "rclpy")
        self.context = _import("rclpy.context", "rclpy").Context()
        try:
            with _discovery(settings.network):
                rclpy.init(
                    context=self.context, domain_id=settings.domain_id, args=[], signal_handler_options=_no_signals()
                )
            namespace = settings.namespace or None
            self.node = rclpy.create_node(
                node, context=self.context, namespace=namespace, start_parameter_services=False
            )
        except Exception as error:  # rclpy raises those of its C library
            self.context.try_shutdown()
            if isinstance(error, InputError):
                raise
            raise DeviceError(f"the ROS domain {settings.domain_id} cannot be joined: {error}") from error

    def reader(self, topic: str, type: str, qos: QoS) -> _Reader:
        return _Reader(self.node, topic, type, qos)

    def writer(self, topic: str, type: str, qos: QoS) -> _Writer:
        return _Writer(self.node, topic, type, qos)

    def endpoints(self) -> list[Endpoint]:
        found = []
        for topic, _ in self.node.get_topic_names_and_types():
            for publishes, listed in (
                (True, self.node.get_publishers_info_by_topic(topic)),
                (False, self.node.get_subscriptions_info_by_topic(topic)),
            ):
                for each in listed:
                    qos = qos_of(each.qos_profile)
                    gid = bytes(each.endpoint_gid)
                    found.append(Endpoint(topic, each.topic_type, node_of(each), publishes, qos, gid))
        return found

    def now(self) -> float:
        return time.time()

    def close(self) -> None:
        self.node.destroy_node()
        self.context.try_shutdown()


class _Reader:
    def __init__(self, node: Any, topic: str, type: str, qos: QoS) -> None:
        self.topic = topic
        self.type = type
        self._class = message_class(type)
        self._node = node
        self._depth = qos.depth
        self._lock = threading.Lock()
        self._subscription = node.create_subscription(self._class, topic, _ignore, _profile(qos), raw=True)

    def take(self) -> Sample | None:
        newest: Sample | None = None
        while found := self.take_all():
            newest = found[-1]
        return newest

    def take_all(self) -> list[Sample]:
        found: list[Sample] = []
        with self._lock:
            while self._subscription is not None and len(found) < self._depth:
                with self._subscription.handle:
                    taken = self._subscription.handle.take_message(self._class, True)
                if taken is None:
                    break
                data, info = taken
                found.append(Sample(bytes(data), info["source_timestamp"] * 1e-9))
        return found

    def close(self) -> None:
        with self._lock:
            if self._subscription is not None:
                self._node.destroy_subscription(self._subscription)
            self._subscription = None


class _Writer:
    def __init__(self, node: Any, topic: str, type: str, qos: QoS) -> None:
        self.topic = topic
        self.type = type
        self._node = node
        self._lock = threading.Lock()
        cls, before = message_class(type), _publishers(node, topic)
        self._publisher = node.create_publisher(cls, topic, _profile(qos))
        # rclpy does not tell the identifier of a publisher, but lists those of a topic.
        self.gid = next(iter(_publishers(node, topic) - before), b"")

    def write(self, data: bytes) -> None:
        with self._lock:
            if self._publisher is None:
                raise DeviceError(f"the publisher of '{self.topic}' was closed.")
            try:
                self._publisher.publish(data)
            except Exception as error:  # rclpy raises those of its C library
                raise DeviceError(f"nothing can be sent on '{self.topic}': {error}") from error

    def matched(self) -> int:
        with self._lock:
            return 0 if self._publisher is None else int(self._publisher.get_subscription_count())

    def close(self) -> None:
        with self._lock:
            if self._publisher is not None:
                self._node.destroy_publisher(self._publisher)
            self._publisher = None


def _publishers(node: Any, topic: str) -> set[bytes]:
    """Identifiers of the publishers of a topic that belong to a node."""
    own = f"{node.get_namespace().rstrip('/')}/{node.get_name()}"
    listed = node.get_publishers_info_by_topic(topic)
    return {bytes(each.endpoint_gid) for each in listed if node_of(each) == own}


def node_of(endpoint: Any) -> str:
    """Full name of the node of a discovered endpoint; empty if the endpoint was discovered before its node."""
    if endpoint.node_name in _UNKNOWN:
        return ""
    return f"{endpoint.node_namespace.rstrip('/')}/{endpoint.node_name}"


def message_class(name: str) -> Any:
    """Class of rclpy for a message type, service type or action type, such as `std_srvs/srv/Trigger`.

    Raises:
        InputError: The ROS package is not installed, or has no such type.
    """
    parts = name.split("/")
    if len(parts) != 3:
        raise InputError(Fault(f"'{name}' is no type of ROS 2.", hint="Write it as 'sensor_msgs/msg/LaserScan'."))
    package, kind, message = parts
    module = _import(f"{package}.{kind}", package)
    if not hasattr(module, message):
        raise InputError(Fault(f"the ROS package '{package}' has no {kind} '{message}'."))
    return getattr(module, message)


def _import(module: str, package: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError as error:
        distro = os.environ.get("ROS_DISTRO", "DISTRO")
        debian = f"ros-{distro}-{package.replace('_', '-')}"
        hint = f"Install the ROS package '{package}' (on Ubuntu: apt install {debian}), and source ROS 2 first."
        raise InputError(Fault(f"'{module}' cannot be imported: {error}.", hint=hint)) from error


def _no_signals() -> Any:
    """Option that leaves SIGINT and SIGTERM to the run, which stops the robot first."""
    return _import("rclpy.signals", "rclpy").SignalHandlerOptions.NO


@contextmanager
def _discovery(network: str) -> Iterator[None]:
    """Environment in which a context is initialised, because discovery has no other setting; raises InputError.

    For the loopback, other variables of discovery do not apply. For the local network, those of the user apply.
    """
    before = {key: os.environ[key] for key in (_RANGE, *_OTHERS) if key in os.environ}
    if network == "lan":
        for key, values in ((_RANGE, ("LOCALHOST", "OFF")), ("ROS_LOCALHOST_ONLY", ("1",))):
            if before.get(key) in values:
                message = f'network = "lan", but the environment has {key}={before[key]}.'
                raise InputError(Fault(message, hint=f'Write unset {key}, or network = "loopback" in [ros2].'))
    try:
        if network == "loopback":
            for key in _OTHERS:
                os.environ.pop(key, None)
            os.environ[_RANGE] = "LOCALHOST"
            if os.environ.get("ROS_DISTRO") == "humble":  # which does not know the range yet
                os.environ["ROS_LOCALHOST_ONLY"] = "1"
        else:
            os.environ.setdefault(_RANGE, "SUBNET")
        yield
    finally:
        for key in (_RANGE, *_OTHERS):
            os.environ.pop(key, None)
        os.environ.update(before)


def _profile(qos: QoS) -> Any:
    module = _import("rclpy.qos", "rclpy")
    return module.QoSProfile(
        depth=qos.depth,
        history=module.HistoryPolicy.KEEP_LAST,
        reliability=getattr(module.ReliabilityPolicy, qos.reliability.upper()),
        durability=getattr(module.DurabilityPolicy, qos.durability.upper()),
    )


def qos_of(profile: Any) -> QoS:
    """Policies of a profile of rclpy."""
    reliable = profile.reliability.name == "RELIABLE"
    latched = profile.durability.name == "TRANSIENT_LOCAL"
    return QoS(
        "reliable" if reliable else "best_effort", "transient_local" if latched else "volatile", max(profile.depth, 1)
    )


def _ignore(data: bytes) -> None:
    """Callback of a subscription that is polled; never called, because nothing spins the node."""
