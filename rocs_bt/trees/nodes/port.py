"""Ports: typed inputs and outputs of a node class, with values from the file or the blackboard."""

from __future__ import annotations

import functools
from collections.abc import Callable
from enum import Enum
from typing import Any, Final, Generic, Protocol, TypeVar, overload

from ...errors import Fault, InputError
from ...units import Dimension, convert
from ..board import Board, Enums, from_string, to_string
from ..error import TreeError
from ..script import parse_script

T = TypeVar("T")


class Ported(Protocol):
    """Interface of a node with ports."""

    def read(self, port: str) -> Any: ...
    def write(self, port: str, value: Any) -> None: ...


class Direction(Enum):
    """Direction of a port's values; the enum values are the tags of a palette."""

    INPUT = "input_port"
    OUTPUT = "output_port"
    INOUT = "inout_port"


class _Required(Enum):
    REQUIRED = "required"


REQUIRED: Final = _Required.REQUIRED
"""Marks a port without a default."""


class Port(Generic[T]):
    """Port of a node class; read and written like an attribute of the node.

        class Greet(Leaf):
            name = Input(str, doc="person to greet")
            times = Input(int, default=1)
            said = Output(str)

            def update(self) -> Outcome:
                self.said = f"hello {self.name}" * self.times
                return SUCCESS

    Args:
        kind: Type of the values: bool, int, float, str, Status, an Enum, `list[...]` of them, a class, or object for a
            port that accepts every type and fixes none.
        default: Value if a file gives none, possibly text such as `{key}`; REQUIRED if a file must give one.
        doc: Description of the port.
        name: Name in files, if that is not a valid Python name.
        dimension: Dimension of the numbers; files then give quantities such as `0.5 m`, blackboards hold SI numbers.
        parse: Conversion from text to a value, for a class of its own.

    Attributes:
        direction: Direction of the values.
    """

    direction = Direction.INPUT

    def __init__(
        self,
        kind: type[T],
        default: Any = REQUIRED,
        doc: str = "",
        *,
        name: str = "",
        dimension: Dimension | None = None,
        parse: Callable[[str], T] | None = None,
    ) -> None:
        self.kind: Any = Any if kind is object else kind
        self.default = default
        self.doc = doc
        self.name = name
        self.dimension = dimension
        self._parse = parse

    def __set_name__(self, owner: type[Any], attribute: str) -> None:
        self.name = self.name or attribute

    @overload
    def __get__(self, node: None, owner: type[Any]) -> Port[T]: ...
    @overload
    def __get__(self, node: Ported, owner: type[Any]) -> T: ...
    def __get__(self, node: Ported | None, owner: type[Any]) -> Port[T] | T:
        if node is None:
            return self
        value: T = node.read(self.name)
        return value

    def __set__(self, node: Ported, value: T) -> None:
        node.write(self.name, value)

    @property
    def required(self) -> bool:
        """Whether a file must give a value."""
        return self.default is REQUIRED

    def value(self, text: str, enums: Enums | None = None) -> T:
        """Convert a text to a value.

        Raises:
            InputError: The text cannot be converted to this port's type.
        """
        found: Any
        try:
            if self._parse is not None:
                found = self._parse(text)
            elif self.dimension is not None:
                found = convert(text, self.dimension, self.name)
            else:
                found = from_string(text, self.kind, enums)
        except InputError:
            raise
        except Exception as error:  # a user's parser may raise anything; the text is at fault
            raise InputError(Fault(f"{text!r} cannot be converted: {type(error).__name__}: {error}.")) from error
        value: T = found
        return value


class Input(Port[T]):
    """Port that the node reads."""


class Code(Input[str]):
    """Input port that contains a script, which is parsed when its file is loaded."""

    def __init__(self, default: Any = REQUIRED, doc: str = "", *, name: str = "") -> None:
        super().__init__(str, default, doc, name=name, parse=_script)


class Output(Port[T]):
    """Port that the node writes; in a file it is always a key, such as `{pose}`. It may be omitted."""

    direction = Direction.OUTPUT

    def __init__(self, kind: type[T], doc: str = "", *, name: str = "", default: Any = None) -> None:
        super().__init__(kind, default, doc, name=name)


class InOut(Port[T]):
    """Port that the node reads and writes."""

    direction = Direction.INOUT


def _script(text: str) -> str:
    parse_script(text)
    return text


class ExactKey(str):
    """Name of a key that is taken literally, where `=` would otherwise mean the port's own name."""

    __slots__ = ()


def pointer(text: object) -> str | None:
    """Key that `{key}` refers to, without braces and the spaces around them; None for a literal."""
    return _pointer(text) if isinstance(text, str) else None


@functools.lru_cache(maxsize=4096)
def _pointer(text: str) -> str | None:
    stripped = text.strip(" ")
    if stripped == "=":
        return "="
    return stripped[1:-1] if len(stripped) >= 3 and stripped[0] == "{" and stripped[-1] == "}" else None


def pointed(text: object, port: str) -> str | None:
    """Like `pointer`, with `{=}` and `=` resolved to the key of the port's own name."""
    key = pointer(text)
    return port if key == "=" else key


class Reading:
    """Reads the blackboard key of a port; keeps a reference to the entry once it is found.

    Args:
        port: The port.
        owner: Tag and name of the port's node, for messages.
        board: Blackboard of the node.
        key: Key of the port.
    """

    __slots__ = ("_board", "_entry", "_key", "_kind", "_owner", "_port")

    def __init__(self, port: Port[Any], owner: tuple[str, str], board: Board, key: str) -> None:
        self._port, self._owner, self._board, self._key = port, owner, board, key
        self._kind, self._entry = port.kind, board.entry(key)

    def __call__(self) -> Any:
        entry = self._entry
        if entry is None or not entry.alive:
            entry = self._entry = self._board.entry(self._key)
        if entry is None or entry.value is None:
            if self._port.default is None:
                return None
            tag, name = self._owner
            where = f"'{self._port.name}' of {tag} '{name}'"
            raise TreeError(Fault(f"{where} reads the key '{self._key}', which has no value."))
        value, kind = entry.value, self._kind
        if kind is Any or value.__class__ is kind:
            return value
        if value.__class__ is str:
            return self._port.value(value, self._board.enums)
        if kind is str and isinstance(value, (int, float)):
            return to_string(value)  # a subtree's literal such as a="1" is a number on its board
        return self._board.fitted(self._key, kind, value)
