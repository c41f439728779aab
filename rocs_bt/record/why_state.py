"""State of an agent at one time of a recording, from which explanations are made."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

from ..event import (
    ActuatorCommanded,
    AgentStopped,
    AtomicStarted,
    BlockFailed,
    BodyMoved,
    Change,
    CommandLimited,
    ContentRaised,
    Event,
    FollowerStepped,
    MotionHeld,
    RobotPushed,
    RuleChanged,
    TicketChanged,
)
from ..knowledge.history import State
from .tree_state import TreeState


@dataclass(frozen=True)
class Drive:
    """Command of an actuator with its cause.

    Attributes:
        t: Time [s].
        ticket: Ticket of the action that commanded; None for a command outside of actions.
        neutral: Whether all values are zero.
    """

    t: float
    ticket: TicketChanged | None
    neutral: bool


@dataclass
class WhyState:
    """State of one agent at a requested time: the latest recorded value of everything.

    Attributes:
        t: Requested time [s].
        agent: Name of the agent.
        signals: Time of writing [s] and values by signal, SI units.
        graph: Knowledge graph.
        tree: Statuses of the nodes of the mission tree.
        ports: Given ports of its nodes as text, by path.
        rules: Last event of each active rule.
        inactive: Sentences about the rules that were inactive at the start of the run.
        fired: Firings of rules so far, newest last.
        latched: Last event of the phase `latched` by rule.
        causes: That event at the last firing of each rule.
        waited: Rule that was active when a rule began to wait, by the waiting rule.
        tickets: Open tickets by number.
        atomic: Atomic action that started last.
        commands: Last command by actuator.
        drives: Newest commands with their causes, newest last.
        limited: Last command that the safety gate scaled, by actuator.
        held: Actuators that a safety gate holds in neutral, each with the event.
        pushed: Last push of the robot; None before the first.
        followed: Last command computed by the trajectory follower.
        bodies: Last ground-truth pose by body.
        changes: Last change of each kind.
        raised: Exceptions of content so far.
        failed: First failure of a block; None if there is none.
        stopped: Event that the agent was stopped; None before it.
        recent: Newest events, except those emitted every period.
    """

    t: float
    agent: str
    signals: dict[str, tuple[float, list[float]]] = field(default_factory=dict)
    graph: State = field(default_factory=lambda: State(""))
    tree: TreeState = field(default_factory=TreeState)
    ports: dict[str, str] = field(default_factory=dict)
    rules: dict[str, RuleChanged] = field(default_factory=dict)
    inactive: list[str] = field(default_factory=list)
    fired: list[RuleChanged] = field(default_factory=list)
    latched: dict[str, RuleChanged] = field(default_factory=dict)
    causes: dict[str, RuleChanged] = field(default_factory=dict)
    waited: dict[str, str] = field(default_factory=dict)
    tickets: dict[int, TicketChanged] = field(default_factory=dict)
    atomic: AtomicStarted | None = None
    commands: dict[str, ActuatorCommanded] = field(default_factory=dict)
    drives: deque[Drive] = field(default_factory=lambda: deque(maxlen=64))
    limited: dict[str, CommandLimited] = field(default_factory=dict)
    held: dict[str, MotionHeld] = field(default_factory=dict)
    pushed: RobotPushed | None = None
    followed: FollowerStepped | None = None
    bodies: dict[str, BodyMoved] = field(default_factory=dict)
    changes: dict[str, Change] = field(default_factory=dict)
    raised: list[ContentRaised] = field(default_factory=list)
    failed: BlockFailed | None = None
    stopped: AgentStopped | None = None
    recent: deque[Event] = field(default_factory=lambda: deque(maxlen=400))

    @property
    def running(self) -> TicketChanged | None:
        """Ticket of the running action, of a reflex first; None if no action runs."""
        running = [e for e in self.tickets.values() if e.state == "RUNNING"]
        return next((e for e in running if e.priority == "HIGH"), running[0] if running else None)
