"""DdsTransport: ROS 2 topics without ROS, by the DDS of the package cyclonedds."""

from __future__ import annotations

import functools
import importlib
import os
import threading
import time
from typing import TYPE_CHECKING, Any, TypeVar

from ...base.errors import DeviceError, Fault, InputError
from ..messages.type_store import INSTALL, TypeStore
from ..settings import Ros2Settings
from .qos import QoS
from .transport import Endpoint, Sample

if TYPE_CHECKING:
    from cyclonedds.domain import Domain

_ANYWHERE = "<Compatibility><IgnoreTypeInformation>1.1,1.15,1.16</IgnoreTypeInformation></Compatibility>"
_LOOPBACK = """
<General><AllowMulticast>false</AllowMulticast>
<Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces></General>
<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>100</MaxAutoParticipantIndex>
<Peers><Peer address="127.0.0.1"/></Peers></Discovery>
"""
_DISCOVERY = "rmw_dds_common/msg/ParticipantEntitiesInfo"
_SEND_TIMEOUT = 100_000_000  # [ns] for which a full queue may block a reliable publisher
_MOST = 1000  # endpoints that are read at once

E = TypeVar("E", bound="_Endpoint")

_domains: dict[int, tuple[str, Domain]] = {}  # DDS allows one domain object per process, with one configuration
_opening = threading.Lock()  # concurrent opening of endpoints raises in cyclonedds


class DdsTransport:
    """Participant of a ROS 2 network through DDS, for topics only; services and actions need rclpy.

    Raises:
        InputError: The package cyclonedds is not installed, or the process uses the domain with another configuration.
        DeviceError: The network cannot be joined.
    """

    def __init__(self, settings: Ros2Settings, types: TypeStore, node: str) -> None:
        domain, participant = _import("domain"), _import("domain").DomainParticipant
        self.name = "dds"
        self.types = types
        self._number = settings.domain_id
        try:
            _open_domain(domain, self._number, settings.network)
            self._participant = participant(self._number)
        except _import("core").DDSException as error:
            raise DeviceError(f"the ROS domain {self._number} cannot be joined: {error}") from error
        self._endpoints: list[_Endpoint] = []
        builtin = _import("builtin")
        self._publications = builtin.BuiltinDataReader(self._participant, builtin.BuiltinTopicDcpsPublication)
        self._subscriptions = builtin.BuiltinDataReader(self._participant, builtin.BuiltinTopicDcpsSubscription)
        latched = QoS("reliable", "transient_local", 1)
        self._announced = _Writer(self, "ros_discovery_info", _DISCOVERY, latched, prefix="")
        self._others = _Reader(
            self, "ros_discovery_info", _DISCOVERY, QoS("reliable", "transient_local", 100), prefix=""
        )
        self._nodes: dict[bytes, str] = {}  # names of nodes by GID of endpoint
        self._node, self._namespace = node, "/" + settings.namespace.strip("/")

    def reader(self, topic: str, type: str, qos: QoS) -> _Reader:
        return self._opened(_Reader(self, topic, type, qos))

    def writer(self, topic: str, type: str, qos: QoS) -> _Writer:
        return self._opened(_Writer(self, topic, type, qos))

    def endpoints(self) -> list[Endpoint]:
        self._read_names()
        return [*self._found(self._publications, True), *self._found(self._subscriptions, False)]

    def now(self) -> float:
        return time.time()

    def close(self) -> None:
        for endpoint in [*self._endpoints, self._announced, self._others]:
            endpoint.close()
        self._endpoints.clear()
        del self._publications, self._subscriptions, self._participant

    def topic(self, name: str, type: str) -> Any:
        """DDS topic of an endpoint."""
        return _import("topic").Topic(self._participant, name, _struct(self.types, type))

    @property
    def participant(self) -> Any:
        """Participant of cyclonedds."""
        return self._participant

    def _opened(self, endpoint: E) -> E:
        self._endpoints = [*(each for each in self._endpoints if each.is_open), endpoint]
        self._announce()
        return endpoint

    def _announce(self) -> None:
        """Tell other nodes the name of this node and its endpoints, as rmw implementations do."""
        types = self.types
        readers = [e.gid for e in self._endpoints if isinstance(e, _Reader)]
        writers = [e.gid for e in self._endpoints if isinstance(e, _Writer)]
        gid = "rmw_dds_common/msg/Gid"
        info = types.make(
            "rmw_dds_common/msg/NodeEntitiesInfo",
            node_namespace=self._namespace,
            node_name=self._node,
            reader_gid_seq=[types.make(gid, data=_padded(types, each)) for each in readers],
            writer_gid_seq=[types.make(gid, data=_padded(types, each)) for each in writers],
        )
        own = types.make(gid, data=_padded(types, self._participant.guid.bytes))
        self._announced.write(types.serialize(types.make(_DISCOVERY, gid=own, node_entities_info_seq=[info])))

    def _read_names(self) -> None:
        for sample in self._others.take_all():
            try:
                message = self.types.deserialize(sample.data, _DISCOVERY)
            except DeviceError:  # of another distribution: nodes stay without names
                continue
            for node in message.node_entities_info_seq:
                name = f"{node.node_namespace.rstrip('/')}/{node.node_name}"
                for gid in (*node.reader_gid_seq, *node.writer_gid_seq):
                    self._nodes[bytes(gid.data)[:16]] = name

    def _found(self, source: Any, publishes: bool) -> list[Endpoint]:
        found = []
        for each in source.read(N=_MOST):
            # An endpoint that was closed has no names.
            topic, kind = getattr(each, "topic_name", None) or "", getattr(each, "type_name", None) or ""
            if topic.startswith("rt/") and "::dds_::" in kind:
                name = kind.replace("::dds_::", "/").replace("::", "/").removesuffix("_")
                gid = each.key.bytes
                node = self._nodes.get(gid, "")
                found.append(Endpoint(topic.removeprefix("rt"), name, node, publishes, _qos_of(each.qos), gid))
        return found


class _Endpoint:
    """Publisher or subscription of a transport."""

    def __init__(self, topic: str, type: str, entity: Any) -> None:
        self.topic = topic
        self.type = type
        self.gid: bytes = entity.guid.bytes  # 16 bytes
        self._entity = entity
        self._lock = threading.Lock()

    @property
    def is_open(self) -> bool:
        """Whether the endpoint was not closed."""
        return self._entity is not None

    def close(self) -> None:
        """Close the endpoint."""
        with self._lock:
            self._entity = None


class _Reader(_Endpoint):
    def __init__(self, transport: DdsTransport, topic: str, type: str, qos: QoS, prefix: str = "rt") -> None:
        sub = _import("sub")
        with _opening:
            entity = sub.DataReader(transport.participant, transport.topic(prefix + topic, type), qos=_dds_qos(qos))
        super().__init__(topic, type, entity)
        self._depth = qos.depth

    def take(self) -> Sample | None:
        newest: Sample | None = None
        while found := self.take_all():
            newest = found[-1]
        return newest

    def take_all(self) -> list[Sample]:
        with self._lock:
            taken = [] if self._entity is None else self._entity.take(N=self._depth)
        return [Sample(s.data, s.sample_info.source_timestamp * 1e-9) for s in taken if isinstance(s, _Raw)]


class _Writer(_Endpoint):
    def __init__(self, transport: DdsTransport, topic: str, type: str, qos: QoS, prefix: str = "rt") -> None:
        pub, self._cls = _import("pub"), _struct(transport.types, type)
        with _opening:
            entity = pub.DataWriter(transport.participant, transport.topic(prefix + topic, type), qos=_dds_qos(qos))
        super().__init__(topic, type, entity)

    def write(self, data: bytes) -> None:
        message = self._cls.__new__(self._cls)  # without its fields: the data is serialised already
        message.cdr = data
        with self._lock:
            if self._entity is None:
                raise DeviceError(f"the publisher of '{self.topic}' was closed.")
            try:
                self._entity.write(message)
            except _import("core").DDSException as error:
                raise DeviceError(f"nothing can be sent on '{self.topic}': {error}") from error

    def matched(self) -> int:
        with self._lock:
            return 0 if self._entity is None else len(self._entity.get_matched_subscriptions())


class _Raw:
    """Received message as CDR, which cyclonedds completes by its `sample_info`."""

    __slots__ = ("data", "sample_info")

    def __init__(self, data: bytes) -> None:
        self.data = data
        self.sample_info: Any = None


def _import(module: str) -> Any:
    """Import a module of cyclonedds; raises InputError."""
    try:
        return importlib.import_module(f"cyclonedds.{module}")
    except ModuleNotFoundError as error:
        hint = (
            f"{INSTALL} cyclonedds has no wheel for Python 3.14 and for Linux on ARM; there, install ROS 2, and run in "
            "its environment: rclpy is used."
        )
        raise InputError(Fault(f"DDS without ROS needs the package 'cyclonedds': {error}.", hint=hint)) from error


def _open_domain(module: Any, number: int, network: str) -> None:
    """Create the domain of this process, unless it exists."""
    body = _ANYWHERE + (_LOOPBACK if network == "loopback" else "")
    own = os.environ.get("CYCLONEDDS_URI", "") if network == "lan" else ""
    config = own or f"<CycloneDDS><Domain>{body}</Domain></CycloneDDS>"
    with _opening:
        if number not in _domains:
            _domains[number] = config, module.Domain(number, config)
        elif _domains[number][0] != config:
            message = f"this process already uses the ROS domain {number}, but not with network = '{network}'."
            raise InputError(Fault(message, hint="Give all robots of a run the same network, or another domain."))


def _dds_qos(qos: QoS) -> Any:
    core = _import("core")
    policy = core.Policy
    reliable, latched = qos.reliability == "reliable", qos.durability == "transient_local"
    return core.Qos(
        policy.Reliability.Reliable(_SEND_TIMEOUT) if reliable else policy.Reliability.BestEffort,
        policy.Durability.TransientLocal if latched else policy.Durability.Volatile,
        policy.History.KeepLast(qos.depth),
    )


def _qos_of(qos: Any) -> QoS:
    policy = _import("core").Policy
    reliable = isinstance(qos[policy.Reliability], policy.Reliability.Reliable)
    latched = qos[policy.Durability] == policy.Durability.TransientLocal
    history = qos[policy.History] if policy.History in qos else None  # noqa: SIM401 - a Qos has no get
    depth = max(getattr(history, "depth", 1), 1)
    return QoS("reliable" if reliable else "best_effort", "transient_local" if latched else "volatile", depth)


def _padded(types: TypeStore, gid: bytes) -> list[int]:
    """GID as the numbers of a message, of which older distributions have more."""
    size = types.fields("rmw_dds_common/msg/Gid")["data"][1][1]
    return list(gid.ljust(size, b"\0"))


@functools.cache
def _struct(types: TypeStore, name: str) -> Any:
    """Type of cyclonedds for a message type, which carries raw CDR."""
    idl = _import("idl")
    types.message(name)
    package, _, message = name.split("/")
    fields = {field: _hint(types, of) for field, of in types.fields(name).items()}
    fields = fields or {"structure_needs_at_least_one_member": _import("idl.types").uint8}
    cls = idl.make_idl_struct(message, f"{package}.msg.dds_.{message}_", fields)
    cls.serialize = lambda self, *args, **options: self.cdr
    cls.deserialize = classmethod(lambda _, data, *args, **options: _Raw(data))
    return cls


def _hint(types: TypeStore, of: Any) -> Any:
    """Cyclonedds' type of a field."""
    idl = _import("idl.types")
    kind, detail = of
    if kind.name == "NAME":
        return _struct(types, detail)
    if kind.name == "BASE":
        base, bound = detail
        if base == "string":
            return idl.bounded_str[bound] if bound else str
        return {"bool": bool, "octet": idl.byte, "char": idl.uint8}.get(base) or getattr(idl, base)
    element, length = detail
    inner = _hint(types, element)
    if kind.name == "ARRAY":
        return idl.array[inner, length]
    return idl.sequence[inner, length] if length else idl.sequence[inner]
