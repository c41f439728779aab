"""Node: what the nodes of our trees add to py_trees' behaviours: ports, conditions, direct ticks and SKIPPED."""

from __future__ import annotations

import inspect
import uuid
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import repeat
from types import MappingProxyType
from typing import Any, ClassVar, TypeGuard

from py_trees.behaviour import Behaviour
from py_trees.common import BlackBoxLevel, Status
from py_trees.logging import Logger

from ...errors import Fault, InputError, unknown
from ..board import Board
from ..error import TreeError
from ..script import Script, ScriptError, parse_script
from ..status import IDLE, RUNNING, Outcome
from .guard import CONDITIONS, Run, Tick, guarded
from .port import REQUIRED, Direction, Port, Reading, pointed
from .runtime import Runtime, Watch
from .visits import Visits


class LazyAttribute:
    """An attribute that is made when it is first asked for.

    Args:
        make: Makes the value for a node.
    """

    def __init__(self, make: Callable[[Any], Any]) -> None:
        self._make = make
        self._name = ""

    def __set_name__(self, owner: type[Any], name: str) -> None:
        self._name = name

    def __get__(self, node: Any, owner: type[Any]) -> Any:
        if node is None:
            return self
        value = self._make(node)
        setattr(node, self._name, value)  # from now on Python finds this one first
        return value


RESERVED = ("ID", "name", "_autoremap")
"""Attributes of files that are no ports."""

MAX_ACCEPTED = 16_384
"""How many values of ports a class remembers as correct."""

_NOTHING: Mapping[str, Any] = MappingProxyType({})

NODE_ATTRIBUTES = frozenset(
    ["id", "name", "status", "parent", "children", "decorated", "current_child", "feedback_message", "logger",
     "iterator", "blackboards", "given", "conditions", "other", "runtime", "visits", "memory", "policy"]
)  # fmt: skip
"""What nodes keep in attributes of these names."""


class Node(Behaviour):
    """The base of all our nodes; `Control`, `Decorator` and `Leaf` are what to derive from.

    A node is ticked by calling `tick_once`, which gives the outcome back and stores it in `status`, SKIPPED apart. Who
    is not RUNNING starts anew when ticked, so nobody resets a child that has ended: what a node came to stays visible
    until it is ticked again. `tick`, the generator of py_trees, does the same and then yields what was ticked, so that
    our nodes work in py_trees' composites and under its visitors.

    Attributes:
        kind: Control, Decorator, Action, Condition or SubTree.
        tag: What files call the class; its name by default.
        ports: The ports of the class by name, those of its bases first.
        min_children: How many children it has at least.
        max_children: How many it has at most; None for any number.
        latches: Whether a parent that does not reset it gets the same outcome again, without ticking it.
        given: What the file or the constructor gave for its ports, by port name.
        conditions: Its pre- and post-conditions by name, such as `_skipIf`.
        other: Attributes that mean nothing here and are kept for editors: their names begin with `_`.
        board: Where its keys live; its own empty one until it is bound.
        runtime: What it shares with its tree.
        origin: What it was made from, such as an XML element that knows its place; None for what Python made.
        visits: Who writes down its ticks; None until somebody ticked it, or a node above it, as a generator.
    """

    kind: ClassVar[str] = "Action"
    tag: ClassVar[str] = ""
    ports: ClassVar[Mapping[str, Port[Any]]] = {}
    min_children: ClassVar[int] = 0
    max_children: ClassVar[int | None] = 0
    latches: ClassVar[bool] = False

    # What py_trees' constructor makes for every behaviour; most nodes never need it.
    id: Any = LazyAttribute(lambda node: uuid.uuid4())
    qualified_name: Any = LazyAttribute(lambda node: f"{type(node).__qualname__}/{node.name}")
    blackboards: Any = LazyAttribute(lambda node: [])
    iterator: Any = LazyAttribute(lambda node: node.tick())
    logger: Any = LazyAttribute(lambda node: Logger(node.name))
    blackbox_level = BlackBoxLevel.NOT_A_BLACKBOX

    _required: ClassVar[tuple[Port[Any], ...]] = ()
    _accepted: ClassVar[set[tuple[str, str]]] = set()
    _shares_keys: ClassVar[bool] = False

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        cls.tag = cls.__dict__.get("tag", "") or cls.__name__
        for attribute, value in vars(cls).items():
            if isinstance(value, Port) and (attribute in NODE_ATTRIBUTES or hasattr(Node, attribute)):
                hint = f'Write: {attribute}_ = {type(value).__name__}(..., name="{attribute}").'
                message = f"{cls.__name__} cannot have a port in '{attribute}', which every node has."
                raise TreeError(Fault(message, hint=hint))
        found: dict[str, Port[Any]] = {}
        for base in reversed(cls.__mro__):
            found.update({p.name: p for p in vars(base).values() if isinstance(p, Port)})
        if found:
            cls.ports = found
            cls._required = tuple(port for port in found.values() if port.required)
        cls._accepted = set()
        cls._shares_keys = False

    def _construct(self, name: str) -> None:
        """Take the place of py_trees' constructor, which makes more than a node needs."""
        if not isinstance(name, str):
            raise TypeError(f"the name of a node must be a string, found {name!r}.")
        # Python keeps attributes outside of a dictionary, which is faster, for names that the first instances had.
        self.name = name
        self.status = IDLE
        self.parent: Behaviour | None = None
        self.feedback_message = ""
        self.origin: Any = None
        self.given: Mapping[str, Any] = _NOTHING
        self.conditions: Mapping[str, Script] = _NOTHING
        self.other: Mapping[str, Any] = _NOTHING
        self.runtime = _UNBOUND
        self.visits: Visits | None = None
        self._board: Board | None = None
        self._guarded: Tick | None = None
        self._on_halted: Run | None = None
        self._readers: dict[str, Callable[[], Any]] | None = None
        self._wired = False
        if not self._shares_keys:
            type(self)._shares_keys = True
            for later in ("id", "logger", "tick_once"):
                setattr(self, later, None)
                delattr(self, later)

    def _prepare(self, attributes: Mapping[str, Any]) -> None:
        """Take the attributes.

        Raises:
            InputError: All that is wrong with them.
        """
        if not attributes and not self._required:
            return
        for name in attributes:
            if name[-1] == "_":  # `if_` is the port `if`
                attributes = {name.rstrip("_"): value for name, value in attributes.items()}
                break
        if faults := self.attribute_faults(attributes):
            raise InputError(*(fault for _, fault in faults))
        given: dict[str, Any] = {}
        conditions: dict[str, Script] = {}
        other: dict[str, Any] = {}
        for name, value in attributes.items():
            if name in self.ports:
                given[name] = value
            elif name in CONDITIONS:
                conditions[name] = parse_script(value)
            else:
                other[name] = value
        self.given, self.other = given or _NOTHING, other or _NOTHING
        if conditions:
            self.conditions = conditions
            self._wired = True
            setattr(self, "tick_once", self._tick_unbound)  # noqa: B010 - a method is hidden on purpose

    @classmethod
    def attribute_faults(cls, attributes: Mapping[str, Any]) -> list[tuple[str, Fault]]:
        """What is wrong with a node's attributes, by attribute; a required port that is missing is under its name.

        Args:
            attributes: Ports and conditions by name; text as in files, or Python values.
        """
        found: list[tuple[str, Fault]] = []
        for item in attributes.items():
            name, value = item
            text = value.__class__ is str
            if text and item in cls._accepted:
                continue
            try:
                if name in CONDITIONS:
                    parse_script(value)
                    continue
                if name in cls.ports:
                    _check_value(cls.ports[name], value)
                elif not name.startswith("_") and name not in RESERVED:
                    raise TreeError(unknown("port", name, cls.ports, cls.tag))
            except InputError as error:
                found += [(name, fault) for fault in error.faults]
            else:
                if text:
                    cls._accept(item)
        for port in cls._required:
            if port.name not in attributes:
                found.append((port.name, Fault(f"{cls.tag} needs '{port.name}'.", hint=port.doc)))
        return found

    @classmethod
    def _accept(cls, known: tuple[str, str]) -> None:
        """Keep a text that is correct for an attribute: a document is checked before its nodes are made."""
        if len(cls._accepted) >= MAX_ACCEPTED:
            cls._accepted.clear()
        cls._accepted.add(known)

    @classmethod
    def description(cls) -> str:
        """What the class is for: the first paragraph of its docstring, in one line."""
        first = (inspect.getdoc(cls) or "").split("\n\n")[0]
        return " ".join(first.split())

    @property
    def board(self) -> Board:
        """Where the node's keys live."""
        if self._board is None:
            self._board = Board(name=self.name)
        return self._board

    def bind(self, board: Board, runtime: Runtime) -> Iterable[tuple[Behaviour, Board]]:
        """Take a place in a tree: find the keys, compile the scripts. Children are bound by the caller.

        Args:
            board: Where its keys live.
            runtime: What it shares with its tree.

        Returns:
            Its children, and the board each of them lives on.

        A key that has another type already, and a name that is no enum's, go to `runtime.faults`: the tree tells all.
        """
        self._board, self.runtime = board, runtime
        self._readers = None
        for port in self.ports.values() if self.given else ():
            try:
                self._bind_port(port, board)
            except InputError as error:
                runtime.faults += ((self, port.name, fault) for fault in error.faults)
        if self.conditions:
            self._guarded, self._on_halted = guarded(self, self.conditions, board)
        if self._wired or runtime.watch is not None or self.visits is not None:
            self.rewire()
        return zip(self.children, repeat(board)) if self.children else ()

    def _bind_port(self, port: Port[Any], board: Board) -> None:
        given = self.given.get(port.name)
        key = pointed(given, port.name)
        if key is not None:
            board.declare(key, None if port.dimension is None and port.kind is str else _fixed_type(port))
        elif isinstance(given, str) and _maybe_enum(port, given):
            port.value(given, board.enums)

    def bound_faults(self) -> Iterable[tuple[str, Fault]]:
        """What is wrong with it for its mission, by attribute, once it is bound; for derived classes.

        A check tells all of it. A run refuses to begin, unless it is only warnings.
        """
        return ()

    def written(self) -> tuple[str, dict[str, str]] | None:
        """Tag and attributes in a document, for nodes that stand there for another one; None for its own ports."""
        return None

    def read(self, port: str) -> Any:
        """The present value of an input port.

        Raises:
            TreeError: It has none, or one of the wrong type.
        """
        readers = self._readers
        if readers is None:
            readers = self._readers = {}
        reader = readers.get(port)
        if reader is None:
            reader = readers[port] = self._reader(self.ports[port])
        return reader()

    def write(self, port: str, value: Any) -> None:
        """Write an output port; nothing happens where the file gave it no key.

        Raises:
            TreeError: It is no output port, or the value does not fit the key.
        """
        declared = self.ports[port]
        if declared.direction is Direction.INPUT:
            raise TreeError(Fault(f"'{port}' of {self.tag} '{self.name}' is an input port: nodes only read it."))
        key = pointed(self.given.get(port, declared.default), port)
        if key is not None:
            self.board[key] = value

    def key(self, port: str) -> str | None:
        """The key that a port points at; None where a literal or nothing was given."""
        return pointed(self.given.get(port, self.ports[port].default), port)

    def tick(self) -> Iterator[Behaviour]:
        """Tick, and yield what was ticked, children before parents, for visitors and for py_trees' composites."""
        yield from (self.visits or Visits(is_own_node)).of(self)

    def tick_once(self) -> Outcome:
        """Tick.

        Returns:
            The outcome, which is in `status` too, unless it is SKIPPED.
        """
        raise NotImplementedError

    def update(self) -> Outcome:
        """What a leaf does in each tick; composites and decorators do not have it."""
        raise NotImplementedError

    def halt(self) -> None:
        """Stop half way. Only a node that is RUNNING is halted, children before their parent, each of them once."""
        self.halted()
        self.status = IDLE
        if self._on_halted is not None:
            self._on_halted()
        if self.runtime.watch is not None:
            self.runtime.watch(self, IDLE)

    def halted(self) -> None:
        """Let go of what runs; for derived classes."""

    def stop(self, new_status: Status = IDLE) -> None:
        """py_trees' word for it: halt if RUNNING, and take that status."""
        if self.status is RUNNING:
            self.halt()
        self.status = new_status

    def _reader(self, port: Port[Any]) -> Callable[[], Any]:
        given = self.given.get(port.name, port.default)
        key = pointed(given, port.name)
        if key is not None:
            return Reading(port, (self.tag, self.name), self.board, key)
        if given is REQUIRED:
            raise TreeError(Fault(f"'{port.name}' of {self.tag} '{self.name}' was not given."))
        value = port.value(given, self.board.enums) if isinstance(given, str) else given
        return lambda: value

    def _tick_unbound(self) -> Outcome:
        """The first tick of a node with conditions that is in no tree."""
        self.rewire()
        return self.tick_once()

    def rewire(self) -> None:
        """Put what has to happen around each tick around it, and nothing where nothing has to."""
        if self.conditions and self._guarded is None:  # in no tree: the board is its own
            self._guarded, self._on_halted = guarded(self, self.conditions, self.board)
        watch, visits = self.runtime.watch, self.visits
        if self._guarded is None and watch is None and visits is None:
            if self._wired:
                delattr(self, "tick_once")
            self._wired = False
            return
        tick = self._guarded or type(self).tick_once.__get__(self)
        if watch is not None:
            tick = _watched(self, tick, watch)
        if visits is not None:
            tick = visits.around(self, tick)
        # Not through `__dict__`: once that was asked for, every look at an attribute is slower.
        setattr(self, "tick_once", tick)  # noqa: B010 - a method is hidden on purpose
        self._wired = True


_UNBOUND = Runtime()


def is_own_node(behaviour: Behaviour) -> TypeGuard[Node]:
    """Whether a behaviour is one of our nodes; `isinstance` takes long for classes with an abstract base."""
    return Node in type(behaviour).__mro__


def _fixed_type(port: Port[Any]) -> Any:
    return None if port.kind is Any else port.kind


def _maybe_enum(port: Port[Any], text: str) -> bool:
    """Whether a text may name a number; quantities and what a port parses itself have no names."""
    return port.kind in (int, float) and port.dimension is None and text.isidentifier()


def _check_value(port: Port[Any], value: Any) -> None:
    key = pointed(value, port.name)
    if key is not None:
        if key.count("@") > 1 or "@" in key[1:]:
            raise TreeError(Fault(f"the key '{key}' of port '{port.name}' may have one '@', at its beginning."))
        return
    if port.direction is Direction.OUTPUT:
        hint = f"Write {port.name}=\"{{{value}}}\" to write to the key '{value}'."
        raise TreeError(Fault(f"the output port '{port.name}' needs a key, found {value!r}.", hint=hint))
    if isinstance(value, str):
        try:
            port.value(value)
        except ScriptError:
            raise
        except InputError as error:
            if _maybe_enum(port, value):
                return  # those are known when the node is bound
            raise TreeError(*(Fault(f"port '{port.name}': {f.message}", hint=f.hint) for f in error.faults)) from error


def _watched(node: Node, tick: Tick, watch: Watch) -> Tick:
    def watched() -> Outcome:
        outcome = tick()
        watch(node, outcome)
        return outcome

    return watched
