"""RclpyTransport: the environment of discovery, names of nodes, and a start that fails."""

from __future__ import annotations

import os

import pytest
import rclpy

from rocs_bt.base.errors import DeviceError, InputError
from rocs_bt.ros2.messages.type_store import TypeStore
from rocs_bt.ros2.network.rclpy_transport import RclpyTransport
from rocs_bt.ros2.network.services import RosServices
from rocs_bt.ros2.settings import Ros2Settings

RANGE, PEERS, ONLY = "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_STATIC_PEERS", "ROS_LOCALHOST_ONLY"


def opened(network="loopback"):
    return RclpyTransport(Ros2Settings(network=network, namespace="r1"), TypeStore(), "rocs_bt")


@pytest.fixture
def seen(ros_environment, monkeypatch):
    """The variables of discovery when rclpy was initialised."""
    found, init = [], rclpy.init

    def spy(**keys):
        found.append([os.environ.get(key) for key in (RANGE, PEERS, ONLY)])
        init(**keys)

    monkeypatch.setattr(rclpy, "init", spy)
    return found


def test_nothing_in_the_environment_opens_the_loopback(seen, monkeypatch):
    monkeypatch.setenv(PEERS, "192.0.2.1")
    monkeypatch.setenv(ONLY, "0")
    monkeypatch.setenv(RANGE, "SUBNET")
    opened().close()
    assert seen == [["LOCALHOST", None, None]]
    assert [os.environ[key] for key in (RANGE, PEERS, ONLY)] == ["SUBNET", "192.0.2.1", "0"]


def test_humble_restricts_discovery_by_the_variable_that_it_knows(seen, monkeypatch):
    monkeypatch.setenv("ROS_DISTRO", "humble")
    monkeypatch.delenv(ONLY, raising=False)
    opened().close()
    assert seen == [["LOCALHOST", None, "1"]]
    assert ONLY not in os.environ


@pytest.mark.parametrize(("key", "value"), [(RANGE, "LOCALHOST"), (RANGE, "OFF"), (ONLY, "1")])
def test_an_environment_that_contradicts_the_local_network_is_refused(seen, monkeypatch, key, value):
    monkeypatch.delenv(RANGE)
    monkeypatch.setenv(key, value)
    with pytest.raises(InputError, match=f'network = "lan", but the environment has {key}={value}') as caught:
        opened("lan")
    assert f"unset {key}" in caught.value.faults[0].hint
    assert seen == []


def test_a_node_that_cannot_be_created_leaves_the_network(ros_environment, monkeypatch):
    contexts = []

    def refuse(name, *, context, **keys):
        contexts.append(context)
        raise RuntimeError("no memory")

    monkeypatch.setattr(rclpy, "create_node", refuse)
    with pytest.raises(DeviceError, match="cannot be joined: no memory"):
        opened()
    assert not contexts[0].ok()


def test_the_node_of_services_is_in_the_namespace(ros_environment):
    transport = opened()
    services = RosServices(transport.context, "r1")
    assert services.node.get_fully_qualified_name() == "/r1/rocs_bt_services"
    services.close()
    transport.close()
