"""DryLink: ROS connection of a dry run, which receives but sends nothing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NoReturn

from ...base.errors import DeviceError
from ..ros_link import (
    AcceptedGoal,
    RosActionClient,
    RosActionServer,
    RosLink,
    RosPublisher,
    RosServiceClient,
    RosSubscription,
    RosTrigger,
    RosTypes,
)


class DryLink:
    """ROS connection of a dry run: topics are received, but nothing is published, called or served; see `RosLink`."""

    def __init__(self, link: RosLink) -> None:
        self._link = link

    @property
    def types(self) -> RosTypes:
        """Types that the connection knows."""
        return self._link.types

    def publisher(self, topic: str, type: str, qos: str) -> RosPublisher:
        """Publisher that sends nothing."""
        return _DryPublisher()

    def subscription(self, topic: str, type: str, qos: str) -> RosSubscription:
        return self._link.subscription(topic, type, qos)

    def service(self, name: str, type: str) -> RosServiceClient:
        """Client that refuses every call."""
        return _DryService(name, self._link.service(name, type))

    def action(self, name: str, type: str) -> RosActionClient:
        """Client that refuses every goal."""
        return _DryAction(name, self._link.action(name, type))

    def action_server(self, name: str, type: str) -> RosActionServer:
        """Server that gets no goals."""
        return _DryServer()

    def trigger(self, name: str) -> RosTrigger:
        """Server that gets no requests."""
        return _DryServer()


class _DryPublisher:
    def matched(self) -> int:
        return 1

    def mismatch(self) -> str:
        return ""

    def publish(self, values: Mapping[str, Any]) -> None:
        pass

    def close(self) -> None:
        pass


class _DryService:
    def __init__(self, name: str, client: RosServiceClient) -> None:
        self._name = name
        self.ready = client.ready
        self.mismatch = client.mismatch
        self.close = client.close

    def call(self, request: Mapping[str, Any]) -> NoReturn:
        raise DeviceError(f"the service '{self._name}' is not called in a dry run")


class _DryAction:
    def __init__(self, name: str, client: RosActionClient) -> None:
        self._name = name
        self.ready = client.ready
        self.mismatch = client.mismatch
        self.servers = client.servers
        self.close = client.close

    def send(self, goal: Mapping[str, Any]) -> NoReturn:
        raise DeviceError(f"no goal is sent to '{self._name}' in a dry run")


class _DryServer:
    def open(self, accepting: bool) -> None:
        pass

    def goal(self) -> AcceptedGoal | None:
        return None

    def taken(self) -> bool:
        return False

    def close(self) -> None:
        pass
