"""Ports: typed inputs and outputs of a node class, with values from the file or the blackboard."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable
from enum import Enum
from typing import Any, Final, Generic, NamedTuple, Protocol, TypeVar, overload

from ...base.errors import Fault, InputError
from ...base.units import Dimension, convert
from ..board import Board
from ..error import TreeError
from ..script import Script, parse_script
from ..value import Enums, converted, from_string

T = TypeVar("T")


class Ported(Protocol):
    """Interface of a node with ports."""

    def read(self, port: str) -> Any: ...
    def write(self, port: str, value: Any) -> None: ...


class Direction(Enum):
    """Direction of a port; the enum values are the tags that declare such a port in a TreeNodesModel."""

    INPUT = "input_port"
    OUTPUT = "output_port"
    INOUT = "inout_port"


class _Required(Enum):
    REQUIRED = "required"


REQUIRED: Final = _Required.REQUIRED
"""Default of a port for which a file must give a value."""


class KeyUse(NamedTuple):
    """Blackboard key inside the text of a port.

    Attributes:
        key: Name of the key.
        column: Position in the text, counted from 0.
        writes: Whether the node writes the key; otherwise it reads the key.
    """

    key: str
    column: int
    writes: bool


class Port(Generic[T]):
    """Port of a node class, a descriptor: a node reads and writes it like an attribute.

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
        name: Name of the port in files, if it cannot be a Python attribute; by default the attribute's name.
        dimension: Dimension of the numbers. With one, files contain quantities such as `0.5 m`, and blackboards contain
            numbers in SI units.
        parse: Function from text to a value, for a `kind` that has no standard conversion.

    Attributes:
        direction: Whether the node reads the port, writes it, or both.
        names_places: Whether texts of the port are names of places in the world model.
    """

    direction = Direction.INPUT
    names_places = False

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

    @property
    def parser(self) -> Callable[[str, Enums | None], T] | None:
        """Converter of texts if the port has another one than its type, as for quantities; else None."""
        return None if self._parse is None and self.dimension is None else self.value

    def value(self, text: str, enums: Enums | None = None) -> T:
        """Convert a text to a value of the port.

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
        except Exception as error:  # a user's parser may raise anything
            raise InputError(Fault(f"{text!r} cannot be converted: {type(error).__name__}: {error}.")) from error
        value: T = found
        return value

    def converted(self, value: Any, enums: Enums | None = None) -> T:
        """Convert a value of any source to a value of the port: the rule of `rocs_bt.trees.value`.

        Raises:
            InputError: The value cannot be converted to this port's type.
        """
        found: T = self.value(value, enums) if value.__class__ is str else converted(value, self.kind, enums or {})
        return found

    def keys_in(self, text: str) -> Iterable[KeyUse]:
        """Keys inside a text that is not itself a key; derived classes with such a syntax override this."""
        return ()


class Input(Port[T]):
    """Port that the node reads."""


class Code(Input[str]):
    """Input port for a script; the syntax of the script is checked when the file is loaded.

    With `condition`, the script must not be empty.
    """

    def __init__(self, default: Any = REQUIRED, doc: str = "", *, name: str = "", condition: bool = False) -> None:
        super().__init__(str, default, doc, name=name, parse=_condition if condition else _script)


class Output(Port[T]):
    """Port that the node writes. In a file its value is a blackboard key, such as `{pose}`; it may be omitted."""

    direction = Direction.OUTPUT

    def __init__(self, kind: type[T], doc: str = "", *, name: str = "", default: Any = None) -> None:
        super().__init__(kind, default, doc, name=name)


class InOut(Port[T]):
    """Port that the node reads and writes."""

    direction = Direction.INOUT


def _script(text: str) -> str:
    parse_script(text)
    return text


def _condition(text: str) -> str:
    parse_condition(text)
    return text


def parse_condition(text: str) -> Script:
    """Parse a script that must have a value.

    Raises:
        InputError: The text is not a script, or is empty.
    """
    if not text.strip("; \t\r\n"):
        raise TreeError(Fault("the condition is empty.", hint="Write an expression, or remove it."))
    return parse_script(text)


def key_name(text: str) -> str:
    """Check the name of a key that is written without braces.

    Raises:
        TreeError: The name is empty.
    """
    if not text.strip("@ "):
        raise TreeError(Fault(f"a key needs a name, found {text!r}."))
    return text


class ExactKey(str):
    """Key with a literal name, even if the name is `=`, which otherwise means the key with the port's name."""

    __slots__ = ()


def pointer(text: object) -> str | None:
    """Key in a text such as `{key}`, without the braces and the spaces around them; None if the text is a literal."""
    return _pointer(text) if isinstance(text, str) else None


@functools.lru_cache(maxsize=4096)
def _pointer(text: str) -> str | None:
    stripped = text.strip(" ")
    if stripped == "=":
        return "="
    return stripped[1:-1] if len(stripped) >= 3 and stripped[0] == "{" and stripped[-1] == "}" else None


def pointed(text: object, port: str) -> str | None:
    """Key in a text, as in `pointer`; `{=}` and `=` mean the key with the port's name."""
    key = pointer(text)
    return port if key == "=" else key


class Reading:
    """Reader of a port's blackboard key. It keeps a reference to the entry, so that the key is looked up only once.

    Args:
        port: Port to read.
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
        if kind is str and entry.text is not None:
            value = entry.text  # the attribute id="007" of a subtree is a number on its board
        try:
            return self._port.converted(value, self._board.enums)
        except InputError as error:
            tag, name = self._owner
            where = f"'{self._port.name}' of {tag} '{name}' cannot take the value of the key '{self._key}'"
            raise TreeError(*(Fault(f"{where}: {f.message}", hint=f.hint) for f in error.faults)) from error
