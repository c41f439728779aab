"""KnownTypes: fields of the message, service and action types that are installed."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from functools import cache
from typing import Any

from ...base.errors import InputError, unknown
from ..ros_link import RosField
from ..settings import Ros2Settings
from .plain import rosbags_fields, rosidl_fields
from .type_store import TypeStore


class KnownTypes:
    """Fields of types: messages from a type store, services and actions from installed ROS packages.

    Args:
        messages: Message types; None if the package rosbags is not installed.
    """

    def __init__(self, messages: TypeStore | None) -> None:
        self._messages = messages
        self._found: dict[str, Mapping[str, RosField] | None] = {}

    def fields(self, type: str) -> Mapping[str, RosField] | None:
        if type not in self._found:
            stored = self._stored(type) if "/msg/" in type else None
            self._found[type] = self._installed(type) if stored is None else stored
        return self._found[type]

    def _stored(self, type: str) -> Mapping[str, RosField] | None:
        """Fields of a message type of the type store; None if the store does not know its package."""
        if self._messages is None:
            return None
        try:
            return rosbags_fields(self._messages.fields(type))
        except InputError:
            package = type.partition("/")[0]
            if any(name.startswith(f"{package}/msg/") for name in self._messages.store.types):
                raise
        return None

    def _installed(self, type: str) -> Mapping[str, RosField] | None:
        """Fields of a type of an installed ROS package; None if the package is not installed."""
        package, kind, name = type.split("/")
        name, _, part = name.partition("_") if kind != "msg" else (name, "", "")
        try:
            module = importlib.import_module(f"{package}.{kind}")
        except ImportError:
            return None
        cls: Any = getattr(module, name, None)
        if cls is None:
            known = [each for each in vars(module) if each[:1].isupper() and not each.endswith(("_Event", "Impl"))]
            raise InputError(unknown(f"{_KINDS[kind]} type", name, known, f"The ROS package '{package}'"))
        return rosidl_fields(getattr(cls, part) if part else cls)


_KINDS = {"msg": "message", "srv": "service", "action": "action"}


@cache
def installed_types(settings: Ros2Settings | None = None) -> KnownTypes:
    """Types that are installed here, for checks without a connection.

    Args:
        settings: Settings with the distribution and the folder of own message types; None for the defaults.
    """
    given = Ros2Settings() if settings is None else settings
    try:
        return KnownTypes(TypeStore(given.distro, given.definition))
    except InputError:  # rosbags is not installed
        return KnownTypes(None)
