"""Events of Plan and of the reflexes: rules, the mission's tree, its blackboards and messages, and tickets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import msgspec

from .sink import Event, Level, Value


class RuleChanged(Event, frozen=True, kw_only=True):
    """A reflex rule changed its state.

    Attributes:
        rule: Rule as `file/Rule`.
        phase: New state: `latched`, `fired` (its activation began), `fired again` (the action had ended while the rule
            was latched), `stopped` (the action raised an exception, so Stop replaces it), `waits` (another reflex is
            active), `updated` (parameters changed), `released`, `ended` (its activation ended).
        priority: Priority of the rule.
        reading: Guard values of the rule, such as `min(front) = 0.21 m`.
        parameters: Parameters of the action, SI units.
        refirings: Number of times that the rule has fired again since this activation.
    """

    rule: str
    phase: str
    priority: int
    reading: str = ""
    parameters: Mapping[str, Value] = {}
    refirings: int = 0

    @property
    def sentence(self) -> str:
        return f"rule {self.rule} {self.phase}" + (f" ({self.reading})" if self.reading else "")

    @property
    def level(self) -> Level:
        return Level.WARNING if self.phase.startswith("fired") else Level.DEBUG


class GuardInfo(msgspec.Struct, frozen=True, kw_only=True):
    """Guard of a reflex rule.

    Attributes:
        rule: Rule as `file/Rule`.
        when: Condition on which the rule latches, as written.
        until: Condition that releases it, as written; empty if there is none.
        sources: Both conditions over signals and numbers only, or only the first.
        comparisons: Texts of all comparisons in both conditions, as written, in order; of a chain one for each sign. A
            `held` or `once` has its own, behind those that it is about.
        units: Unit of each comparison's sides; may be empty.
        doc: Description of the rule in one sentence.
        action: Name of the action that the robot executes.
        priority: Priority of the rule.
        place: File and line of the rule, such as `avoid_collision.toml:38`.
        thresholds: Values of the named thresholds in both conditions, with units, after overrides by the robot.
        hold: Time for which `when` must hold until the rule latches [s].
        cooldown: Time from latching, or from release if `level`, to the next latching [s].
        level: Whether the rule is a level rule.
        modes: Modes of the agent in which the rule is active; empty for all.
        on_invalid: Policy while `when` is not known: `clear`, `trip` or `hold`.
        max_hold: Time after which `hold` becomes `trip` [s].
        limits: Limits of the range sensors with signals that the guard reads: value [m], and a sentence about it.
        only_invalid: Whether `when` can never hold, so that only invalid signals make the rule act.
    """

    rule: str
    when: str
    until: str = ""
    sources: tuple[str, ...] = ()
    comparisons: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    doc: str = ""
    action: str = ""
    priority: int = 0
    place: str = ""
    thresholds: Mapping[str, str] = {}
    hold: float = 0.0
    cooldown: float = 0.0
    level: bool = False
    modes: tuple[str, ...] = ()
    on_invalid: str = "clear"
    max_hold: float = 0.0
    limits: tuple[tuple[float, str], ...] = ()
    only_invalid: bool = False

    @property
    def faults(self) -> str:
        """Contradiction that only a damaged recording has, as a sentence; empty if there is none."""
        if not 1 <= len(self.sources) <= 2:
            return f"the guard of '{self.rule}' has no condition"
        if len(self.units) != len(self.comparisons):
            return f"the comparisons of '{self.rule}' do not have one unit each"
        return ""


class RulesReplaced(Event, frozen=True, kw_only=True):
    """A rule file changed during the run: its new rules were activated, or refused, and the old rules kept.

    Attributes:
        rules: Name of the rule file.
        accepted: Whether the new rules are active.
        detail: Description of the active rules, or faults of the file.
        before: Texts of the old rules, by path relative to the rule file's folder; empty if the new ones were refused.
        texts: Texts of the new rules, likewise.
        guards: Guards of the new rules.
    """

    rules: str
    accepted: bool
    detail: str
    before: Mapping[str, str] = {}
    texts: Mapping[str, str] = {}
    guards: tuple[GuardInfo, ...] = ()

    @property
    def sentence(self) -> str:
        return f"{self.rules}: {self.detail}"

    @property
    def level(self) -> Level:
        return Level.INFO if self.accepted else Level.WARNING


class NodeTicked(Event, frozen=True, kw_only=True):
    """A node of the mission's tree changed its status, or the mission waits in it and what it waits for changed.

    Attributes:
        node: Path of the node: names from the root, joined by `/`.
        status: Status of the node.
        feedback: Feedback of the node; while the mission waits in it, the values and deadline for which it waits.
    """

    node: str
    status: str
    feedback: str = ""


class TreeNode(msgspec.Struct, frozen=True, kw_only=True):
    """Node of a mission's tree.

    Attributes:
        path: Names from the root, joined by `/`; of siblings with the same name, the second ends in `#2`.
        type: Class of the node.
        children: Paths of the children.
        ports: Given ports, to be shown after the name, such as `(goal="kitchen")`.
        board: Subtree with the node's blackboard, as in `BlackboardChanged`.
        keys: Blackboard entries to which ports refer, by port: `subtree` and `key` of `BlackboardChanged`, joined by a
            line break, with remapped keys resolved. Ports with literals are omitted.
    """

    path: str
    type: str
    children: tuple[str, ...] = ()
    ports: str = ""
    board: str = ""
    keys: Mapping[str, str] = {}


class SubtreeSwapped(Event, frozen=True, kw_only=True):
    """A subtree of the running mission was replaced.

    Attributes:
        node: Path of the root of the removed subtree.
        by: Path of the root of the new subtree.
        nodes: The whole new tree, parents before children.
    """

    node: str
    by: str
    nodes: tuple[TreeNode, ...]

    @property
    def sentence(self) -> str:
        return f"'{self.node}' was replaced by '{self.by}'"


class SwapRefused(Event, frozen=True, kw_only=True):
    """A subtree of the running mission was not replaced as requested; the old one remains in use.

    Attributes:
        node: Path or name of the subtree's root, as requested.
        detail: Reason.
    """

    node: str
    detail: str
    level: ClassVar[Level] = Level.WARNING

    @property
    def sentence(self) -> str:
        return f"'{self.node}' was not replaced: {self.detail}"


class Replanned(Event, frozen=True, kw_only=True):
    """A leaf submitted its action again after a reflex; `count` is the number of times that it did so far."""

    node: str
    count: int

    @property
    def sentence(self) -> str:
        return f"{self.node} replans ({self.count})"


class BlackboardChanged(Event, frozen=True, kw_only=True):
    """A value on a blackboard of the mission's tree changed in a tick.

    Attributes:
        key: Key on this blackboard.
        value: New value as a text of at most 120 characters; empty if the key has no value any more.
        subtree: Path of the subtree with this blackboard; empty for the blackboard of the main tree.
    """

    key: str
    value: str
    subtree: str = ""
    level: ClassVar[Level] = Level.DEBUG

    @property
    def sentence(self) -> str:
        at = f" in {self.subtree}" if self.subtree else ""
        return f"{self.key} = {self.value}{at}" if self.value else f"{self.key} has no value{at}"


class Said(Event, frozen=True, kw_only=True):
    """A leaf of a mission issued a message.

    Attributes:
        node: Path of the leaf.
        text: The message.
        aloud: Whether the message is for people near the robot, and not for the log only.
    """

    node: str
    text: str
    aloud: bool = False

    @property
    def sentence(self) -> str:
        return self.text


class TicketChanged(Event, frozen=True, kw_only=True):
    """The ticket of an action changed its state.

    Attributes:
        ticket: Number of the ticket, counted from 1 in each agent.
        action: Name of the action.
        parameters: Parameters of the action, SI units.
        priority: `NORMAL` or `HIGH`.
        state: New state: `QUEUED`, `RUNNING`, `SUCCEEDED`, `FAILED`, `CANCELLED`.
        by: Block, leaf or rule that submitted or cancelled the ticket.
        reason: Reason of a failure, with evidence.
    """

    ticket: int
    action: str
    priority: str
    state: str
    by: str
    reason: str = ""
    parameters: Mapping[str, Value] = {}
    level: ClassVar[Level] = Level.WARNING

    @property
    def sentence(self) -> str:
        return f"action {self.action} failed: {self.reason}" if self.state == "FAILED" else ""
