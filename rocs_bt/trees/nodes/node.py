"""Node, the base class of all nodes: adds ports, conditions, direct ticks and SKIPPED to py_trees' behaviours."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import repeat
from types import MappingProxyType
from typing import Any, ClassVar, TypeGuard

from py_trees.behaviour import Behaviour
from py_trees.common import BlackBoxLevel, Status
from py_trees.logging import Logger

from ...base.errors import Fault, InputError, unknown
from ...declare import MISSING
from ..board import Board
from ..error import TreeError
from ..script import Script, ScriptError, parse_script
from ..status import IDLE, RUNNING, Outcome
from ..value import Enums
from .guard import CONDITIONS, PRE, Run, Tick, guarded
from .port import Direction, Port, PortReader, declared_ports, parse_condition, pointed
from .runtime import Runtime, Watch
from .visits import Visits


class LazyAttribute:
    """Attribute that is created on first access."""

    def __init__(self, make: Callable[[Any], Any]) -> None:
        self._make = make
        self._name = ""

    def __set_name__(self, owner: type[Any], name: str) -> None:
        self._name = name

    def __get__(self, node: Any, owner: type[Any]) -> Any:
        if node is None:
            return self
        value = self._make(node)
        setattr(node, self._name, value)  # hides this descriptor on the next access
        return value


RESERVED = ("ID", "name", "_autoremap")
"""Attributes in files that are not ports."""

MAX_ACCEPTED = 16_384
"""Maximum number of checked attribute texts that a node class caches."""

_NOTHING: Mapping[str, Any] = MappingProxyType({})

NODE_ATTRIBUTES = frozenset(
    [
        "id",
        "name",
        "status",
        "parent",
        "children",
        "decorated",
        "current_child",
        "feedback_message",
        "logger",
        "iterator",
        "blackboards",
        "given",
        "conditions",
        "other",
        "runtime",
        "visits",
        "memory",
        "policy",
    ]
)
"""Instance attributes of nodes, which are not available as port names."""


class Node(Behaviour):
    """Base class of all nodes; derive from `Control`, `Decorator` or `Leaf`.

    `tick_once` ticks a node, returns the outcome and stores it in `status`, except SKIPPED. A node that is not RUNNING
    restarts on its next tick, so parents never reset finished children, and a node's last outcome remains visible until
    its next tick. `tick`, py_trees' generator, does the same and then yields the ticked nodes, so that these nodes work
    in py_trees' composites and with its visitors.

    Attributes:
        kind: Control, Decorator, Action, Condition or SubTree.
        tag: Name of the class in files; the class name by default.
        ports: Ports of the class by name, those of its base classes first.
        min_children: Minimum number of children.
        max_children: Maximum number of children; None for no limit.
        latches: Whether the node keeps its outcome after it has ended, so that a WhileDoElse does not tick it again in
            the same run.
        given: Values of ports from the file or the constructor, by port name.
        conditions: Pre- and post-conditions by name, such as `_skipIf`.
        other: Attributes that this package does not use and keeps for editors; their names begin with `_`.
        board: Blackboard of the node; until the node is bound, an empty one of its own.
        runtime: State shared by all nodes of the tree.
        origin: Source of the node, such as an XML element with its position; None if Python code made it.
        initial_keys: Values by key that a tree with this root writes to its blackboard, unless the keys have values.
        visits: Recorder of ticks; None until the node or an ancestor is ticked as a generator.
    """

    kind: ClassVar[str] = "Action"
    tag: ClassVar[str] = ""
    ports: ClassVar[Mapping[str, Port]] = {}
    min_children: ClassVar[int] = 0
    max_children: ClassVar[int | None] = 0
    latches: ClassVar[bool] = False

    # py_trees' constructor creates these for every behaviour; most nodes never need them.
    id: Any = LazyAttribute(lambda node: uuid.uuid4())
    qualified_name: Any = LazyAttribute(lambda node: f"{type(node).__qualname__}/{node.name}")
    blackboards: Any = LazyAttribute(lambda node: [])
    iterator: Any = LazyAttribute(lambda node: node.tick())
    logger: Any = LazyAttribute(lambda node: Logger(node.name))
    blackbox_level = BlackBoxLevel.NOT_A_BLACKBOX
    initial_keys: Mapping[str, Any] = MappingProxyType({})

    _own: ClassVar[Mapping[str, Port]] = {}
    _required: ClassVar[tuple[Port, ...]] = ()
    _accepted: ClassVar[set[tuple[str, str]]] = set()
    _shares_keys: ClassVar[bool] = False

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        cls.tag = cls.__dict__.get("tag", "") or cls.__name__
        own = declared_ports(cls)
        for attribute, of in own.items():
            of_all = attribute in NODE_ATTRIBUTES or hasattr(Node, attribute)
            inherited = getattr(super(cls, cls), attribute, None)
            if of_all or callable(inherited) or isinstance(inherited, property):
                owner = "every node" if of_all else "its base"
                hint = f"Write '{attribute}_', which is the port '{attribute}' in files."
                message = f"{cls.__name__} cannot have a port in '{attribute}', which {owner} has."
                raise TreeError(Fault(message, hint=hint))
            setattr(cls, attribute, of)
        cls._own = own
        found = {p.name: p for base in reversed(cls.__mro__) for p in vars(base).get("_own", {}).values()}
        if found:
            cls.ports = found
            cls._required = tuple(port for port in found.values() if port.required)
        cls._accepted = set()
        cls._shares_keys = False

    def _construct(self, name: str) -> None:
        """Initialise the node in place of py_trees' constructor, which creates more than a node needs."""
        if not isinstance(name, str):
            raise TypeError(f"the name of a node must be a string, found {name!r}.")
        # Attributes that exist on the first instances are stored without a dictionary, which is faster.
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
        # So are those that come later, once the first node of a class has had them.
        if not self._shares_keys:
            type(self)._shares_keys = True
            for later in ("id", "logger", "tick_once"):
                setattr(self, later, None)
                delattr(self, later)

    def _prepare(self, attributes: Mapping[str, Any]) -> None:
        """Check and store the ports, conditions and other attributes of the node; raises InputError."""
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
        """Faults of a node's attributes, each with the name of its attribute or of a required port that is missing.

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
                    (parse_condition if name in PRE else parse_script)(value)
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
        """Cache that an attribute's text is correct, so that it is not checked again when the node is created."""
        if len(cls._accepted) >= MAX_ACCEPTED:
            cls._accepted.clear()
        cls._accepted.add(known)

    @property
    def board(self) -> Board:
        """Blackboard of the node."""
        if self._board is None:
            self._board = Board(name=self.name)
        return self._board

    def bind(self, board: Board, runtime: Runtime) -> Iterable[tuple[Behaviour, Board]]:
        """Bind the node to a blackboard: declare its keys and compile its scripts. The caller binds the children.

        Keys with a conflicting type and unknown enum names are added to `runtime.faults`, so that the tree can report
        all of them together.

        Args:
            board: Blackboard of the node.
            runtime: State shared by all nodes of the tree.

        Returns:
            Children, each with its blackboard.
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

    def _bind_port(self, port: Port, board: Board) -> None:
        given = self.given.get(port.name)
        key = pointed(given, port.name)
        if key is not None:
            kind = None if port.dimension is None and port.kind is str else _fixed_type(port)
            board.declare(key, kind, None if kind is None else port.parser)
        elif isinstance(given, str) and _maybe_enum(port, given):
            _literal(port, given, board.enums)

    def bound_faults(self) -> Iterable[tuple[str, Fault]]:
        """Faults that can be found only after the node is bound, each with its attribute.

        A check of the tree reports all of them. A run does not start if one of them is an error. Derived classes
        override this method.
        """
        return ()

    def begins_running(self) -> bool:
        """Whether the first tick of each run returns RUNNING, such as that of a motion; checks of trees use it."""
        return False

    def written(self) -> tuple[str, dict[str, str]] | None:
        """Tag and attributes to write to a document, if the node represents another one; None to write its own."""
        return None

    def wait_text(self) -> str:
        """What the node waits for while its tree is RUNNING, such as `until 12.30 s`; by default its feedback."""
        return self.feedback_message

    def read(self, port: str) -> Any:
        """Current value of an input port.

        Raises:
            TreeError: The port has no value, or one of the wrong type.
        """
        readers = self._readers
        if readers is None:
            readers = self._readers = {}
        reader = readers.get(port)
        if reader is None:
            reader = readers[port] = self._reader(self.ports[port])
        return reader()

    def write(self, port: str, value: Any) -> None:
        """Write an output port; does nothing if the port has no key.

        Raises:
            TreeError: The port is an input port, or the value does not fit the key.
        """
        declared = self.ports[port]
        if declared.direction is Direction.INPUT:
            hint = f"Annotate it as Output[...]; or write '_{port}' if it is an attribute and no port."
            message = f"'{port}' of {self.tag} '{self.name}' is an input port and cannot be written."
            raise TreeError(Fault(message, hint=hint))
        key = pointed(self.given.get(port, declared.default), port)
        if key is not None:
            self.board[key] = value if value is None else declared.converted(value, self.board.enums)

    def key(self, port: str) -> str | None:
        """Blackboard key to which a port refers; None if the port has a literal or no value."""
        return pointed(self.given.get(port, self.ports[port].default), port)

    def tick(self) -> Iterator[Behaviour]:
        """Tick the node and yield the ticked nodes, children before parents, for visitors and py_trees' composites."""
        yield from (self.visits or Visits(is_own_node)).of(self)

    def tick_once(self) -> Outcome:
        """Tick the node.

        Returns:
            Outcome, also stored in `status` unless it is SKIPPED.
        """
        raise NotImplementedError

    def update(self) -> Outcome:
        """Action of a leaf in each tick; composites and decorators have none."""
        raise NotImplementedError

    def halt(self) -> None:
        """Interrupt a RUNNING node and its RUNNING descendants, children before parents."""
        self.halted()
        self.status = IDLE
        if self._on_halted is not None:
            self._on_halted()
        if self.runtime.watch is not None:
            self.runtime.watch(self, IDLE)

    def halted(self) -> None:
        """Halt the children and release resources when the node is halted; derived classes override this."""

    def stop(self, new_status: Status = IDLE) -> None:
        """py_trees' interface: halt the node if it is RUNNING, then set its status."""
        if self.status is RUNNING:
            self.halt()
        self.status = new_status

    def _reader(self, port: Port) -> Callable[[], Any]:
        given = self.given.get(port.name, port.default)
        key = pointed(given, port.name)
        if key is not None:
            return PortReader(port, (self.tag, self.name), self.board, key)
        if given is MISSING:
            raise TreeError(Fault(f"'{port.name}' of {self.tag} '{self.name}' has no value and no default."))
        value = None if given is None else _literal(port, given, self.board.enums)
        return lambda: value

    def _tick_unbound(self) -> Outcome:
        """First tick of a node that has conditions but is not in a tree: compiles the conditions, then ticks."""
        self.rewire()
        return self.tick_once()

    def rewire(self) -> None:
        """Wrap `tick_once` with the conditions, the watcher and the visit recorder, as far as the node has them."""
        if self.conditions and self._guarded is None:  # not in a tree: the node's own blackboard
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
        # Not through `__dict__`: accessing it slows down every later attribute access.
        setattr(self, "tick_once", tick)  # noqa: B010 - a method is hidden on purpose
        self._wired = True


_UNBOUND = Runtime()


def is_own_node(behaviour: Behaviour) -> TypeGuard[Node]:
    """Whether a behaviour is a node of this package; faster than `isinstance` for classes with an abstract base."""
    return Node in type(behaviour).__mro__


def _fixed_type(port: Port) -> Any:
    return None if port.kind is Any else port.kind


def _maybe_enum(port: Port, text: str) -> bool:
    """Whether a port's text may have names of enum values, which ports for numbers and lists of numbers accept."""
    if port.dimension is not None:
        return False
    if port.kind in (list[int], list[float]):
        return any(part.isidentifier() for part in text.split(";"))
    return port.kind in (int, float) and text.isidentifier()


def _check_value(port: Port, value: Any) -> None:
    key = pointed(value, port.name)
    if key is not None:
        if not key.strip("@ "):
            raise TreeError(Fault(f"port '{port.name}': a key needs a name, found {value!r}."))
        if key.count("@") > 1 or "@" in key[1:]:
            raise TreeError(
                Fault(f"the key '{key}' of port '{port.name}' may contain one '@', as its first character.")
            )
        return
    if port.direction is Direction.OUTPUT:
        hint = f"Write {port.name}=\"{{{value}}}\" to write to the key '{value}'."
        raise TreeError(Fault(f"the output port '{port.name}' must be a key, found {value!r}.", hint=hint))
    if value is not None and not (isinstance(value, str) and _maybe_enum(port, value)):  # enums are not known yet
        _literal(port, value)


def _literal(port: Port, value: Any, enums: Enums | None = None) -> Any:
    """Value of a literal or default of a port; raises ScriptError or TreeError."""
    try:
        return port.converted(value, enums)
    except ScriptError:
        raise
    except InputError as error:
        raise TreeError(*(Fault(f"port '{port.name}': {f.message}", hint=f.hint) for f in error.faults)) from error


def _watched(node: Node, tick: Tick, watch: Watch) -> Tick:
    def watched() -> Outcome:
        outcome = tick()
        watch(node, outcome)
        return outcome

    return watched
