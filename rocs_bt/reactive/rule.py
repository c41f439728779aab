"""Rules as frozen values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from ..expression import Expression


class OnInvalid(Enum):
    """What a rule does while its guard has no value, since a signal that it reads is stale or broken."""

    TRIP = "trip"  # as if there were danger: it latches, and stays latched
    HOLD = "hold"  # it stays as it is, for max_hold at most; then it trips
    CLEAR = "clear"  # as if there were none: it does not latch, and releases


@dataclass(frozen=True)
class Argument:
    """A parameter of a rule's action.

    Attributes:
        value: An expression, several of them for a list, or a plain value.
        fallback: What stands in while the value is invalid; None where it cannot be.
        blind: Whether the fallback stands in while the guard is invalid, too; so it is where the file gives it.
    """

    value: Expression | tuple[Expression | float, ...] | Any
    fallback: Any = None
    blind: bool = False


@dataclass(frozen=True)
class Rule:
    """A reflex rule.

    Attributes:
        name: `file/Rule`.
        doc: One sentence for people.
        when: The guard: once it has held for `hold`, the rule latches.
        until: While latched, what releases it; None: as soon as the guard does not hold.
        hold: How long the guard must hold [s], on the snapshots' time.
        cooldown: How long after it fired (edge) or released (level) it cannot latch anew [s].
        level: True: the action is cancelled on release. False (edge): it runs to its own end.
        priority: A strictly higher one pre-empts.
        on_invalid: What an invalid guard means.
        max_hold: How long HOLD may last [s].
        action: The action's name.
        arguments: The action's parameters.
        tags: Such as `safety`.
    """

    name: str
    when: Expression
    priority: int
    action: str
    until: Expression | None = None
    hold: float = 0.0
    cooldown: float = 0.0
    level: bool = False
    on_invalid: OnInvalid = OnInvalid.CLEAR
    max_hold: float = 0.0
    arguments: Mapping[str, Argument] = field(default_factory=dict)
    tags: tuple[str, ...] = ()
    doc: str = ""

    def parameters(self, x: Sequence[float], blind: bool) -> dict[str, Any]:
        """The action's parameters for a snapshot, SI units.

        Args:
            x: The snapshot.
            blind: Whether the guard is invalid, so that the fallbacks of the file stand in.
        """
        return {name: _value(argument, x, blind) for name, argument in self.arguments.items()}


@dataclass(frozen=True)
class RuleSet:
    """The rules of one file.

    Attributes:
        name: The file's name without its ending.
        doc: What the file says of itself.
        rules: In the order of the file.
    """

    name: str
    rules: tuple[Rule, ...]
    doc: str = ""


def _value(argument: Argument, x: Sequence[float], blind: bool) -> Any:
    if blind and argument.blind:
        return argument.fallback
    if isinstance(argument.value, Expression):
        value = argument.value.function(x)
        return argument.fallback if value is None else value
    if isinstance(argument.value, tuple):
        values = [part.function(x) if isinstance(part, Expression) else part for part in argument.value]
        return argument.fallback if None in values else values
    return argument.value
