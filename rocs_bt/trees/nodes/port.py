"""Ports: typed inputs and outputs of a node class, with values from the file or the blackboard."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from enum import Enum
from typing import Annotated, Any, NamedTuple, TypeVar

from ...base.errors import Fault, InputError
from ...base.units import Bounds, Dimension
from ...declare import MISSING, Field, own_fields, read_value
from ..board import Board
from ..error import TreeError
from ..script import Script, parse_script
from ..value import Enums, converted, from_string

T = TypeVar("T")


class Direction(Enum):
    """Direction of a port, a mark in its annotation; the enum values are the tags of such ports in a TreeNodesModel."""

    INPUT = "input_port"
    OUTPUT = "output_port"
    INOUT = "inout_port"


Output = Annotated[T, Direction.OUTPUT]
"""Port that the node writes. In a file its value is a blackboard key, such as `{pose}`; it may be omitted."""

InOut = Annotated[T, Direction.INOUT]
"""Port that the node reads and writes."""


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


@dataclass(frozen=True)
class Syntax:
    """Mark of a port with texts that have a syntax of their own.

    Attributes:
        parse: Function from a text to a value.
        keys: Function from a text to the keys in it, for a text that is not itself a key; None if there are none.
        names_places: Whether texts are names of places in the world model.
    """

    parse: Callable[[str], Any]
    keys: Callable[[str], Iterable[KeyUse]] | None = None
    names_places: bool = False


class Port:
    """Port of a node class, a descriptor: a node reads and writes it like an attribute.

    Annotations of a node class declare its ports, as those of an action declare its parameters: the type, the unit,
    the direction and a description; their defaults are those of the ports. `if_` is the port `if`.

        class Greet(Leaf):
            person: Annotated[str, "name of the person"]
            times: int = 1
            said: Output[str]

            def update(self) -> Outcome:
                self.said = f"hello {self.person}" * self.times
                return SUCCESS

    Types are bool, int, float, str, Status, an Enum, `list[...]` of them, a class, and Any for a port that accepts
    every type and fixes none. With a dimension, as in `Seconds`, files contain quantities such as `0.5 s`, and
    blackboards contain numbers in SI units.

    Args:
        declared: Declaration of the port.

    Attributes:
        name: Name of the port in files.
        kind: Type of the values.
        default: Value if a file gives none, possibly text such as `{key}`; MISSING if a file must give one.
        direction: Whether the node reads the port, writes it, or both.
        dimension: Dimension of the numbers; None for values without one.
        syntax: Syntax of the texts, if it is not that of the type.
    """

    def __init__(self, declared: Field) -> None:
        self.declared, self.name = declared, declared.key.rstrip("_")
        self.direction = declared.mark(Direction) or Direction.INPUT
        needs_none = declared.required and self.direction is Direction.OUTPUT
        self.default = None if needs_none else declared.default
        self.dimension = declared.dimension if declared.parts else declared.mark(Dimension)
        self.kind, self.syntax = self._kind(), declared.mark(Syntax)
        self._limited = bool(declared.mark(Bounds) or declared.options)

    def __get__(self, node: Any, owner: type[Any]) -> Any:
        return self if node is None else node.read(self.name)

    def __set__(self, node: Any, value: Any) -> None:
        node.write(self.name, value)

    @property
    def required(self) -> bool:
        """Whether a file must give a value."""
        return self.default is MISSING

    @property
    def doc(self) -> str:
        """Description of the port."""
        return self.declared.doc

    @property
    def is_code(self) -> bool:
        """Whether texts of the port are scripts."""
        return self.syntax is not None and self.syntax.parse in (_script, _condition)

    @property
    def names_places(self) -> bool:
        """Whether texts of the port are names of places in the world model."""
        return self.syntax is not None and self.syntax.names_places

    @property
    def parser(self) -> Callable[[str, Enums | None], Any] | None:
        """Converter of texts if the port has another one than its type, as for quantities; else None."""
        return None if self.syntax is None and self.dimension is None else self.value

    def value(self, text: str, enums: Enums | None = None) -> Any:
        """Convert a text to a value of the port; items of a list are separated by `;`, numbers of a point by `,`.

        Raises:
            InputError: The text cannot be converted to this port's type.
        """
        try:
            if self.syntax is not None:
                return self.syntax.parse(text)
            if self.dimension is not None:
                return self._quantities(text)
            found = from_string(text, self.kind, enums)
        except InputError:
            raise
        except Exception as error:  # a user's parser may raise anything
            raise InputError(Fault(f"{text!r} cannot be converted: {type(error).__name__}: {error}.")) from error
        if self._limited and (faults := self.declared.faults(found, self.name)):
            raise InputError(*faults)
        return found

    def converted(self, value: Any, enums: Enums | None = None) -> Any:
        """Convert a value of any source to a value of the port: the rule of `rocs_bt.trees.value`.

        Raises:
            InputError: The value cannot be converted to this port's type, or is out of its bounds.
        """
        if value.__class__ is str:
            return self.value(value, enums)
        found = converted(value, self.kind, enums or {})
        if self._limited and (faults := self.declared.faults(found, self.name)):
            raise InputError(*faults)
        return found

    def keys_in(self, text: str) -> Iterable[KeyUse]:
        """Keys inside a text that is not itself a key."""
        return () if self.syntax is None or self.syntax.keys is None else self.syntax.keys(text)

    def _kind(self) -> Any:
        each = self.declared
        if each.hint is object or each.parts or (each.many and self.dimension is not None):
            return Any
        one: Any = str if each.options else each.hint
        return list[one] if each.many else one

    def _quantities(self, text: str) -> Any:
        each = self.declared
        values: list[Any] = [part.strip() for part in text.split(";")] if each.many else [text]
        if each.parts:
            values = [[x.strip() for x in value.split(",")] for value in values]
        return read_value(each, values if each.many else values[0])


def port_of(kind: Any, *marks: Any, default: Any = MISSING, name: str = "") -> Field:
    """Member of a class that a program makes, which declares a port: `port_of(int, "number of rounds", default=1)`.

    Args:
        kind: Type of the values, possibly with marks.
        marks: Marks of the annotation, such as a description.
        default: Default of the port.
        name: Name of the port, if it is not that of the member.
    """
    declared = Field.annotated(name, kind, default, object)
    return replace(declared, marks=(*declared.marks, *marks))


def declared_ports(cls: type[Any]) -> dict[str, Port]:
    """Ports that a class declares by its annotations or members, or gives another default, by attribute.

    Raises:
        TreeError: A method or property has the name of a port.
    """
    own = {each.name: each for each in own_fields(cls)}
    found = dict[str, Port]()
    for attribute in {**own, **vars(cls)}:
        member = own[attribute].default if attribute in own else vars(cls)[attribute]
        inherited = _inherited(cls, attribute)
        if isinstance(member, Port):
            found[attribute] = member
        elif isinstance(member, Field):
            found[attribute] = Port(replace(member, name=attribute, key=attribute) if not member.name else member)
        elif (declared := own.get(attribute, inherited)) is None:
            continue
        elif hasattr(member, "__get__"):
            hint = f"Rename it; '{attribute}' is a port, which a node reads and writes as an attribute."
            raise TreeError(Fault(f"{cls.__name__} has a port '{attribute}' and a method of that name.", hint=hint))
        else:
            default = member if member is not MISSING or inherited is None else inherited.default
            found[attribute] = Port(replace(declared, default=default))
    return found


def _inherited(cls: type[Any], attribute: str) -> Field | None:
    """Declaration of the port that an attribute of the bases of a class is; None if it is none."""
    of = next((vars(base)[attribute] for base in cls.__mro__[1:] if attribute in vars(base)), None)
    return of.declared if isinstance(of, Port) else None


def _script(text: str) -> str:
    parse_script(text)
    return text


def _condition(text: str) -> str:
    parse_condition(text)
    return text


ScriptText = Annotated[str, Syntax(_script)]
"""Script; its syntax is checked when the file is loaded."""

ConditionText = Annotated[str, Syntax(_condition)]
"""Script that must not be empty."""


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


class PortReader:
    """Reader of a port's blackboard key. It keeps a reference to the entry, so that the key is looked up only once.

    Args:
        port: Port to read.
        owner: Tag and name of the port's node, for messages.
        board: Blackboard of the node.
        key: Key of the port.
    """

    __slots__ = ("_board", "_entry", "_key", "_kind", "_owner", "_port")

    def __init__(self, port: Port, owner: tuple[str, str], board: Board, key: str) -> None:
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
