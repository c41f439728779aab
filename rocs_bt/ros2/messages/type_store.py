"""Message types of a ROS 2 distribution, and conversion between messages and CDR (by the package rosbags)."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from ...base.errors import DeviceError, Fault, InputError, unknown

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

DISTROS = ("humble", "iron", "jazzy", "kilted", "lyrical")
"""Distributions of ROS 2 with message types."""

INSTALL = "Install it: pip install 'rocs_bt[ros2]'."
"""What to do if a package of the extra is missing."""

FindDefinition = Callable[[str], str | None]
"""Function from the name of a message type to the text of its .msg file; None if it does not know the type."""


def import_rosbags(module: str) -> Any:
    """Import a module of the package rosbags.

    Raises:
        InputError: The package is not installed.
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        message = f"ROS 2 messages need the package 'rosbags', which is not installed ({error})."
        raise InputError(Fault(message, hint=INSTALL)) from error


class TypeStore:
    """Message types of a ROS 2 distribution.

    The distribution must be that of the network, because some types differ.

    Raises:
        InputError: The distribution is unknown, or the package rosbags is not installed.
    """

    def __init__(self, distro: str = "jazzy", find: FindDefinition = lambda name: None) -> None:
        typesys = import_rosbags("rosbags.typesys")
        if distro not in DISTROS:
            raise InputError(unknown("distribution of ROS 2", distro, DISTROS))
        self.distro = distro
        self.store: Typestore = typesys.get_typestore(typesys.Stores[f"ROS2_{distro.upper()}"])
        self._find = find

    def message(self, name: str) -> Any:
        """Class of a message type.

        Raises:
            InputError: The type is unknown, or its definition is faulty.
        """
        if name not in self.store.types:
            text = self._find(name)
            if text is None:
                raise InputError(unknown("message type", name, self.store.types, f"ROS 2 {self.distro.capitalize()}"))
            self.register({name: text})
        return self.store.types[name]

    def fields(self, name: str) -> Mapping[str, Any]:
        """Fields of a message type, by name, as rosbags describes them; see `message`."""
        self.message(name)
        return dict(self.store.fielddefs[name][1])

    def register(self, definitions: Mapping[str, str]) -> None:
        """Add message types: texts of .msg files by the names of the types.

        Raises:
            InputError: A definition is faulty, or contains an unknown type.
        """
        typesys = import_rosbags("rosbags.typesys")
        parsed: dict[str, Any] = {}
        for name, text in definitions.items():
            try:
                parsed |= typesys.get_types_from_msg(text, name)
            except typesys.TypesysError as error:
                raise InputError(Fault(f"the definition of '{name}' is faulty: {error}.")) from error
        known = set(self.store.types)
        self.store.register({name: fields for name, fields in parsed.items() if name not in known})
        for name in set(self.store.types) - known:  # types of their fields
            for of in self.fields(name).values():
                if inner := _message_in(of):
                    self.message(inner)

    def make(self, name: str, /, **values: Any) -> Any:
        """Create a message; nested ones are messages or mappings, and other fields are 0 or empty.

        Raises:
            InputError: The type or a field is unknown.
        """
        known = self.fields(name)
        if wrong := [field for field in values if field not in known]:
            raise InputError(*(unknown("field", field, known, f"'{name}'") for field in wrong))
        return self.message(name)(**{field: self._value(of, values.get(field)) for field, of in known.items()})

    def serialize(self, message: Any) -> bytes:
        """Convert a message to CDR, with its encapsulation header."""
        return bytes(self.store.serialize_cdr(message, message.__msgtype__))

    def deserialize(self, data: bytes, name: str) -> Any:
        """Convert CDR to a message.

        Raises:
            DeviceError: The data is no message of this type.
        """
        try:
            return self.store.deserialize_cdr(data, name)
        except Exception as error:  # of any kind: the data may be anything
            raise DeviceError(f"{len(data)} bytes are no {name}: {error or type(error).__name__}") from error

    def _value(self, of: Any, given: Any) -> Any:
        """Value of a field: the given one, converted, or for None the default."""
        kind, detail = of
        if kind.name == "BASE":
            if given is not None:
                return given
            return {"string": "", "wstring": "", "bool": False}.get(detail[0], 0)
        if kind.name == "NAME":
            return self.make(detail, **(given or {})) if given is None or isinstance(given, Mapping) else given
        element, length = detail
        count = length if kind.name == "ARRAY" else 0
        if element[0].name == "BASE" and element[1][0] not in ("string", "wstring"):
            import numpy as np

            dtype = _DTYPES.get(element[1][0], element[1][0])
            if given is None:
                return np.zeros(count, dtype)
            return np.array(given if isinstance(given, np.ndarray) else list(given), dtype)
        return [self._value(element, value) for value in ([None] * count if given is None else given)]


_DTYPES = {"octet": "uint8", "char": "uint8"}


def _message_in(of: Any) -> str:
    """Name of the message type in the description of a field; empty for a base type."""
    kind, detail = of
    if kind.name in ("ARRAY", "SEQUENCE"):
        return _message_in(detail[0])
    return str(detail) if kind.name == "NAME" else ""
