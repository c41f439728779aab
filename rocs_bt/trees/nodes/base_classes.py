"""Base classes of nodes: controls with several children, decorators with one child, leaves without children."""

from __future__ import annotations

from collections.abc import Iterator
from collections.abc import Sequence as Many
from typing import Any, ClassVar, cast

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Composite
from py_trees.decorators import Decorator as StockDecorator

from ...base.errors import Fault, interrupts
from ..error import TreeError
from ..status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, Outcome
from .node import Node


def counted_text(what: str, count: int, most: int) -> str:
    """Count of rounds, such as `attempt 2/3`; empty without a limit, because it may change in each tick."""
    return f"{what} {count}/{most}" if most > 0 else ""


def halt(node: Behaviour) -> None:
    """Halt a node if it is RUNNING; a stock py_trees behaviour is stopped with the status INVALID."""
    if node.status is RUNNING:
        if isinstance(node, Node):
            node.halt()
        else:
            node.stop(IDLE)


class Control(Node, Composite):
    """Base class of nodes that decide which of their children are ticked.

    Args:
        name: Name in displays.
        children: Children, in order.
        attributes: Ports and conditions.
    """

    kind = "Control"
    min_children = 1
    max_children: ClassVar[int | None] = None

    def __init__(self, name: str, children: Many[Behaviour] = (), /, **attributes: Any) -> None:
        self._construct(name)
        self.children = [adopted(self, child) for child in children]
        self.current_child = None
        self._prepare(attributes)
        self._index = 0
        self._skipped = 0

    def halted(self) -> None:
        self.halt_children()
        self.current_child = None
        self._index = self._skipped = 0

    def halt_children(self) -> None:
        """Halt the RUNNING children, in order."""
        for child in self.children:
            if child.status is RUNNING:
                halt(child)

    def ended(self, outcome: Outcome, child: Behaviour | None) -> Outcome:
        """End the node with an outcome that `child` decided; children that still have the status RUNNING are halted."""
        if self._skipped:
            # A child that returned SKIPPED after RUNNING still has the status RUNNING.
            self.halt_children()
        self._index = self._skipped = 0
        self.current_child = None if outcome is SKIPPED else child
        if outcome is not SKIPPED:
            self.status = outcome
        return outcome

    def no_outcome(self, child: Behaviour, outcome: object) -> TreeError:
        """Error to raise for a child that returned no valid outcome."""
        return no_outcome(child, outcome)


class Decorator(Node, StockDecorator):
    """Base class of nodes that change the outcome of their one child, or decide whether it is ticked.

    Args:
        name: Name in displays.
        child: The child, or a sequence of exactly one.
        attributes: Ports and conditions.
    """

    kind = "Decorator"
    min_children = max_children = 1

    def __init__(self, name: str, child: Behaviour | Many[Behaviour], /, **attributes: Any) -> None:
        self._construct(name)
        self.decorated: Behaviour = only(name, child) if isinstance(child, Many) else child
        if Behaviour not in type(self.decorated).__mro__:
            raise TypeError(f"the child of '{name}' must be a behaviour, found {child!r}.")
        self.decorated.parent = self  # as in py_trees, a previous parent is allowed
        self.children = [self.decorated]
        self._prepare(attributes)

    def halted(self) -> None:
        halt(self.decorated)

    def tick_child(self) -> Outcome:
        """Tick the child and return its outcome.

        Raises:
            TreeError: The child returned no outcome.
        """
        child: Any = self.decorated
        outcome = child.tick_once() or child.status
        if outcome is IDLE:
            raise no_outcome(child, outcome)
        return outcome

    def stop(self, new_status: Status = IDLE) -> None:
        Node.stop(self, new_status)

    def replace_child(self, child: Behaviour, replacement: Behaviour) -> None:
        """Replace the child, for py_trees' trees; the previous child is halted."""
        halt(child)
        child.parent = None
        self.children[0] = self.decorated = replacement
        replacement.parent = self


class Leaf(Node):
    """Base class of actions and conditions, which have no children.

    As in py_trees, `initialise` starts a leaf, `update` gives the outcome of each tick, and `terminate` is called when
    the leaf ends or is halted. None of them may block.

    Args:
        name: Name in displays.
        attributes: Ports and conditions.
    """

    latches = True
    children = cast("Any", ())

    def __init__(self, name: str = "", /, **attributes: Any) -> None:
        self._construct(name or type(self).tag)
        self._prepare(attributes)

    def tick_once(self) -> Outcome:
        try:
            if self.status is not RUNNING:
                self.feedback_message = ""
                self.initialise()
            outcome = self.update()
            if outcome is RUNNING:
                self.status = outcome
            elif outcome is not SKIPPED:
                if outcome.__class__ is not Status or outcome is IDLE:
                    raise no_outcome(self, outcome)
                self.terminate(outcome)
                self.status = outcome
            elif self.status is not RUNNING:
                self.status = IDLE
        except BaseException as error:  # user code may raise anything
            if interrupts(error):
                raise
            if self.runtime.caught(self, error):
                return RUNNING
            raise
        return outcome

    def tick(self) -> Iterator[Behaviour]:
        self.tick_once()
        yield self

    def halted(self) -> None:
        self.terminate(IDLE)


class Instant(Leaf):
    """Base class of leaves that end within one tick and have no state: only `update` is called."""

    latches = False

    def tick_once(self) -> Outcome:
        try:
            self.feedback_message = ""
            outcome = self.update()
            if outcome is SUCCESS or outcome is FAILURE:
                self.status = outcome
            elif outcome is SKIPPED:
                self.status = IDLE
            else:
                raise no_outcome(self, outcome)
        except BaseException as error:  # user code may raise anything
            if interrupts(error):
                raise
            if self.runtime.caught(self, error):
                return RUNNING
            raise
        return outcome


def adopted(parent: Behaviour, child: Behaviour) -> Behaviour:
    """Set the parent of a child and return the child.

    Raises:
        TypeError: The child is no py_trees behaviour.
        RuntimeError: The child has a parent already.
    """
    if Behaviour not in type(child).__mro__:
        raise TypeError(f"the children of '{parent.name}' must be behaviours, found {child!r}.")
    if child.parent is not None:
        raise RuntimeError(
            f"'{child.name}' cannot be a child of '{parent.name}': it is a child of '{child.parent.name}'."
        )
    child.parent = parent
    return child


def only(name: str, children: Many[Behaviour]) -> Behaviour:
    """Only element of the children of a decorator.

    Raises:
        TreeError: There is not exactly one child.
    """
    if len(children) != 1:
        raise TreeError(Fault(f"the decorator '{name}' needs exactly one child, found {len(children)}."))
    return children[0]


def no_outcome(node: Behaviour, outcome: object) -> TreeError:
    """Error to raise for a node that returned no valid outcome."""
    hint = "Return Status.RUNNING, SUCCESS or FAILURE."
    return TreeError(Fault(f"'{node.name}' ({type(node).__name__}) returned {outcome} instead of a status.", hint=hint))
