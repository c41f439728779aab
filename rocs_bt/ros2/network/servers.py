"""Servers of services and actions on the network: their identities, and why one of them does not match a client."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from .qos import QoS, mismatch
from .rclpy_transport import node_of, qos_of

_CLIENT = QoS("reliable", "volatile", 10)
"""Quality of service of our clients, for requests, responses and feedback."""


def action_servers(node: Any, name: str, type: str) -> dict[str, str]:
    """Servers of an action with a full name: the full name of their node, empty if unknown, by endpoint."""
    found = node.get_publishers_info_by_topic(f"{name}/_action/feedback")
    return {bytes(e.endpoint_gid).hex(): node_of(e) for e in found if e.topic_type == f"{type}_FeedbackMessage"}


def service_mismatch(node: Any, name: str, type: str) -> str:
    """Reason why a server of a service with a full name does not match; empty if there is none, or no such server."""
    replies = node.get_publishers_info_by_topic(f"rr{name}Reply", no_mangle=True)
    requests = node.get_subscriptions_info_by_topic(f"rq{name}Request", no_mangle=True)
    return next(_service_mismatches(replies, requests, type), "")


def action_mismatch(node: Any, name: str, type: str) -> str:
    """Reason why a server of an action with a full name does not match; see `service_mismatch`."""
    return next(_action_mismatches(node, name, type), "")


def _service_mismatches(replies: Iterable[Any], requests: Iterable[Any], type: str) -> Iterator[str]:
    for each in replies:
        served = each.topic_type.replace("::dds_::", "::").replace("::", "/").removesuffix("_Response_")
        if served != type:
            yield f"{_server(each)} has another type, {served}"
        elif why := mismatch(qos_of(each.qos_profile), _CLIENT):
            yield f"the quality of service of {_server(each)} does not match in {why}"
    for each in requests:
        if why := mismatch(_CLIENT, qos_of(each.qos_profile)):
            yield f"the quality of service of {_server(each)} does not match in {why}"


def _action_mismatches(node: Any, name: str, type: str) -> Iterator[str]:
    for topic, suffix, qos in (("feedback", "_FeedbackMessage", _CLIENT), ("status", "", QoS.LATCHED)):
        for each in node.get_publishers_info_by_topic(f"{name}/_action/{topic}"):
            served = each.topic_type.removesuffix(suffix) if suffix else type
            if served != type:
                yield f"{_server(each)} has another type, {served}"
            elif why := mismatch(qos_of(each.qos_profile), qos):
                yield f"the quality of service of {_server(each)} does not match in {why} of its {topic}"
    services = (("send_goal", "_SendGoal"), ("get_result", "_GetResult"))
    others = ((part, f"{type}{suffix}") for part, suffix in services)
    for part, wanted in (*others, ("cancel_goal", "action_msgs/srv/CancelGoal")):
        if why := service_mismatch(node, f"{name}/_action/{part}", wanted):
            yield f"{why} of its {part}"


def _server(endpoint: Any) -> str:
    name = node_of(endpoint)
    return f"the server in the node '{name}'" if name else "the server"
