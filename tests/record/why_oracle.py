"""A second, independent reading of a recording: what the first sentence of `--why` must say at each time.

It knows nothing of `rocs_bt.record.why`: it reads the events itself.
"""

from __future__ import annotations

import math
import re
from bisect import bisect_right

from rocs_bt.event import (
    ActuatorCommanded,
    AgentStopped,
    MotionHeld,
    MotionReleased,
    NodeTicked,
    RobotPushed,
    RuleChanged,
    SignalsWritten,
    TicketChanged,
)

PHRASES = {  # what the agent did, by words of which the sentence contains exactly one
    "reflex": r"the rule \S+ (fired|resumed|runs)",
    "action": r" runs \w+\(",
    "waits": "its mission waits in '",
    "ended": r"its mission had ended with (SUCCESS|FAILURE)",
    "stopped": "it was stopped",
    "nothing": "no action was active",
}


class Oracle:
    """Events of one agent, by time."""

    def __init__(self, recording, agent):
        self.info = next(a for a in recording.header.agents if a.name == agent)
        self.agent = agent
        mine = [e for e in recording.events() if e.agent == agent or isinstance(e, RobotPushed)]
        self.kinds = {}
        for e in sorted(mine, key=lambda e: e.t):
            self.kinds.setdefault(type(e), []).append(e)
        self.times = {kind: [e.t for e in events] for kind, events in self.kinds.items()}

    def until(self, kind, t):
        return self.kinds.get(kind, [])[: bisect_right(self.times.get(kind, []), t + 5e-4)]

    def running(self, t):
        """Running ticket at a time, that of a reflex first."""
        states = {e.ticket: e for e in self.until(TicketChanged, t)}
        going = [e for e in states.values() if e.state == "RUNNING"]
        return min(going, key=lambda e: e.priority, default=None)  # "HIGH" < "NORMAL"

    def statuses(self, t):
        return {e.node: e for e in self.until(NodeTicked, t)}

    def kind(self, t):
        """What the agent did: a key of `PHRASES`."""
        root = self.statuses(t).get(self.info.nodes[0].path)
        ended = root is not None and root.status in ("SUCCESS", "FAILURE")
        if self.until(AgentStopped, t):
            return "ended" if ended else "stopped"
        if (ticket := self.running(t)) is not None:
            return "reflex" if ticket.priority == "HIGH" else "action"
        return "ended" if ended else "nothing" if root is None else "waits"

    def signal(self, name, t):
        for e in reversed(self.until(SignalsWritten, t)):
            if name in e.signals:
                return e.values[name][0]
        return math.nan

    def motion(self, t):
        """Words of which one begins the sentence's motion."""
        along = {
            "ahead": self.signal("speed", t),
            "left": self.signal("lateral_speed", t),
            "climbed": self.signal("climb", t),
        }
        axis = max((a for a in along if math.isfinite(along[a])), key=lambda a: abs(along[a]), default="")
        if axis and abs(along[axis]) > 0.02:
            back = {"ahead": "moved back", "left": "moved right", "climbed": "descended"}
            ahead = {"ahead": "moved ahead", "left": "moved left", "climbed": "climbed"}
            return (back if along[axis] < 0.0 else ahead)[axis]
        return "turned" if abs(self.signal("turn_rate", t)) > 0.1 else "was stationary"

    def check(self, t, period, text):
        """Faults of the first sentence at a time, as text."""
        kind = self.kind(t)
        said = [name for name, words in PHRASES.items() if re.search(words, text)]
        if said != [kind]:
            yield f"says {said}, is {kind}"
        yield from getattr(self, f"_{kind}", lambda t, text: [])(t, text)
        yield from self._motion(t, period, text)
        held = {e.actuator for e in self.until(MotionHeld, t)} and self._held(t)
        if held and f"holds '{held}' in neutral" not in text:
            yield f"does not say that '{held}' is held"
        pushed = any(e.body == self.agent and e.t <= t <= e.t + e.duration for e in self.until(RobotPushed, t))
        if pushed and "was pushed by" not in text and "tilt" not in text:
            yield "does not say that the robot is pushed"

    def _held(self, t):
        holds = [*self.until(MotionHeld, t), *self.until(MotionReleased, t)]
        last = max(holds, key=lambda e: e.t)
        return last.actuator if isinstance(last, MotionHeld) else ""

    def _reflex(self, t, text):
        ticket = self.running(t)
        own = [e for e in self.until(RuleChanged, t) if e.rule == ticket.by]
        name = ticket.by.rpartition("/")[2]
        at = max(i for i, e in enumerate(own) if e.phase.startswith("fired"))
        fired, latched = own[at], [e for e in own[:at] if e.phase == "latched"][-1]
        if f"the rule {name} " not in text:
            yield f"does not name {name}"
        if latched.reading not in text:
            yield f"lacks the values that latched it: {latched.reading}"
        if fired.t > latched.t + 1e-3 and fired.reading != latched.reading and f": {fired.reading}" in text:
            yield f"gives values that did not latch it: {fired.reading}"
        if fired.t > latched.t + 1e-3 and not ("resumed" in text or "again" in text):
            yield "does not say that it waited or fired again"

    def _action(self, t, text):
        ticket = self.running(t)
        if f"'{ticket.by}'" not in text or f"runs {ticket.action}(" not in text:
            yield f"does not name '{ticket.by}' with {ticket.action}"

    def _waits(self, t, text):
        children = {node.path: node.children for node in self.info.nodes}
        states = self.statuses(t)
        leaves = [p for p, e in states.items() if e.status == "RUNNING" and not children.get(p)]
        named = re.findall(r"waits in '([^']*)'", text)
        if leaves and set(leaves) != set(named):
            yield f"waits in {named}, RUNNING leaves are {leaves}"
        for path in named:
            if path not in states or states[path].status == "INVALID":
                yield f"waits in '{path}', which is not ticked"
            elif states[path].feedback not in text:
                yield f"lacks what '{path}' waits for: {states[path].feedback}"

    def _ended(self, t, text):
        status = self.statuses(t)[self.info.nodes[0].path].status
        if f"ended with {status}" not in text:
            yield f"the mission ended with {status}"

    def _motion(self, t, period, text):
        words = self.motion(t)
        if "tilt of" in text:
            return
        if not text.startswith(f"{self.agent} {words}"):
            yield f"the robot {words}"
        now, before = self.running(t), self.running(t - period)
        same = now is not None and before is not None and now.ticket == before.ticket
        if " because " in text and words != "was stationary" and not same and "holds" not in text:
            yield "joins a motion with the command of another action"
        drove = [e for e in self.until(ActuatorCommanded, t - period) if e.t >= t - 3.0 and any(e.values)]
        if "without a command" in text and drove:
            yield "denies the commands before"
