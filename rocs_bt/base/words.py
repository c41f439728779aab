"""Texts of counts and lists, for messages."""

from __future__ import annotations

from collections.abc import Sequence


def counted(number: int, noun: str, plural: str = "s") -> str:
    """Text of a count with its noun: `1 scene`, `20 scenes`, `2 switches` with `plural="es"`."""
    return f"{number} {noun}{'' if number == 1 else plural}"


def listed(names: Sequence[str]) -> str:
    """Text of a list of quoted names: `'a'`, `'a' and 'b'`, `'a', 'b' and 'c'`."""
    quoted = [f"'{name}'" for name in names]
    return " and ".join([", ".join(quoted[:-1]), quoted[-1]] if len(quoted) > 1 else quoted)


def failed_again(action: str, count: int, reason: str, since: str = "") -> str:
    """Clause about the action of a rule that failed, perhaps many times.

    `since` is a clause such as ` since t = 1.30 s`.
    """
    often = f" {count} times{since}" if count > 1 else ""
    return f"its action {action} failed{often}: {reason}"


def inactive_rule(rule: str, robots: Sequence[str], missing: Sequence[str]) -> str:
    """Sentence about a rule that is inactive on robots, because these lack signals that the rule requires."""
    robot = f"robot {listed(robots)} has" if len(robots) == 1 else f"robots {listed(robots)} have"
    what = f"signal{'' if len(missing) == 1 else 's'} {listed(missing)}"
    return f"rule {rule.rpartition('/')[2]} is inactive: {robot} no {what}."
