"""Whether rules fit the agent that lives by them: its period, its modes, and the ages of its signals."""

from __future__ import annotations

from collections.abc import Collection

from ...expression.node import TEMPORAL_OPS
from ..rule import Rule
from .case import Case, placed, short

_SLACK = 1e-9  # [s]


def check_times(case: Case, rule: Rule) -> None:
    """A cooldown that is over before the guard could fire anew."""
    if 0.0 < rule.cooldown <= rule.hold + _SLACK:
        case.tell(
            rule, "cooldown",
            f"the cooldown of {short(rule)}, {rule.cooldown:g} s, has no effect, since the guard must hold for "
            f"{rule.hold:g} s anyway: let go at 0 s, it cannot fire before {rule.hold:g} s.",
            "Make the cooldown longer than for, or leave it out.",
        )  # fmt: skip


def check_period(case: Case, rule: Rule, period: float) -> None:
    """Signals that are too old before the next control period, and windows with a single sample.

    Args:
        case: The rule set.
        rule: One of its rules.
        period: The control period [s].
    """
    told = set()
    for key, guard in (("when", rule.when), ("until", rule.until)):
        for node, column in placed(guard.node) if guard is not None else ():
            if node.op in TEMPORAL_OPS and 0.0 < node.value < period - _SLACK:
                case.tell(
                    rule, key,
                    f"in the {key} of {short(rule)} the window of '{node.text}' is {node.value:g} s, shorter than the "
                    f"control period of {period:g} s: at 1 s it holds the sample of 1 s alone.",
                    f"Make it several periods long, such as {3 * period:g} s.",
                    node, column,
                )  # fmt: skip
            for name in case.signals_of(node) if node.op == "read" else ():
                age = case.environment.signals[name].max_age
                if age < period - _SLACK and name not in told:
                    told.add(name)
                    case.tell(
                        rule, key,
                        f"{short(rule)} reads {name}, whose max_age of {age:g} s is less than the control period of "
                        f"{period:g} s: written at 0 s it is invalid at {period:g} s.",
                        f"Give its sensor a max_age of several periods, such as {3 * period:g} s, in robot.toml.",
                        node, column,
                    )  # fmt: skip


def check_modes(case: Case, rule: Rule, modes: Collection[str]) -> None:
    """A rule that lives in no mode that the agent ever has.

    Args:
        case: The rule set.
        rule: One of its rules.
        modes: The modes that the agent's mission can set.
    """
    for mode in rule.modes:
        if mode not in modes:
            rest = [other for other in rule.modes if other in modes]
            case.tell(
                rule, "modes",
                f"{short(rule)} lives in the mode '{mode}', which the mission never sets"
                + (f"; only {', '.join(rest)} can be." if rest else ", so it never acts."),
                "Let the mission set the mode, or name one that it sets.",
            )  # fmt: skip
