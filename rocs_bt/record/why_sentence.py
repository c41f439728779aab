"""First sentence of an explanation: the motion of a robot, and what caused it."""

from __future__ import annotations

import math

from ..event import Event, RuleChanged, TicketChanged
from ..words import counted
from .why_state import Drive, WhyState

_SLOW = 0.02  # speed above which the robot counts as moving [m/s]
_TURNING = 0.1  # turn rate above which the robot counts as turning [rad/s]
_WORDS = {  # motion of each axis in words, by its signal: for positive and negative values
    "speed": ("moved ahead", "moved back"),
    "lateral_speed": ("moved left", "moved right"),
    "climb": ("climbed", "descended"),
}
_TILTED = math.radians(35.0)  # tilt above which a robot counts as tilted
_FALLEN = math.radians(60.0)  # tilt above which a robot is down (docs/architecture.md, outcomes)
_PUSHED = 1.0  # [s] time after a push in which it explains a motion
_COASTING = 3.0  # [s] time after a command in which it explains a motion
_SLACK = 5e-4  # [s] tolerance of times
_LONG = 24  # maximum number of printed values; of longer lists only the minimum is printed


def sentence(why: WhyState) -> str:
    """Sentence with the motion of the robot, and what caused it: a rule, a leaf of the mission, a wait, an end."""
    motion, cause = _motion(why), _cause(why)
    if (tilt := _tilt(why)) > _TILTED:
        state = "had fallen" if tilt > _FALLEN else "was tilted"
        return f"{why.agent} {state}, with a tilt of {math.degrees(tilt):.0f} deg, while {cause}."
    push = why.pushed
    if push is not None and push.t - _SLACK <= why.t <= push.t + push.duration + _PUSHED:
        return f"{why.agent} {motion} and was {push.sentence}{since(push, why.t)}, while {cause}."
    if why.held:
        held = next(iter(why.held.values()))
        gate = f"a safety gate holds '{held.actuator}' in neutral{since(held, why.t)} ({held.reason})"
        return f"{why.agent} {motion} because {gate}, while {cause}."
    return f"{why.agent} {_linked(why, motion, cause)}."


def _linked(why: WhyState, motion: str, cause: str) -> str:
    """Join motion and cause. The motion is measured, so its cause is the command of the period before."""
    running, before = why.running, next((d for d in reversed(why.drives) if d.t < why.t - _SLACK), None)
    now = next((d for d in reversed(why.drives) if d.t >= why.t - _SLACK), before)
    if motion == "acted":  # the robot does not measure its speed
        return f"{motion} because {cause}"
    if motion == "was stationary":
        commanded = now is not None and not now.neutral and not why.stopped
        return f"{motion} while {cause}" if commanded and running is not None else f"{motion} because {cause}"
    then = before.ticket if before is not None else None
    if then is not None and running is not None and then.ticket == running.ticket:
        return f"{motion} because {cause}"
    last = next((d for d in reversed(why.drives) if d.t < why.t - _SLACK and _drove(d)), None)
    if last is None or last.ticket is None or why.t - last.t > _COASTING:
        return f"{motion} without a command, while {cause}"
    return f"{motion} by the last command of {last.ticket.action}{since_time(last.t, why.t)}; now {cause}"


def _drove(drive: Drive) -> bool:
    return drive.ticket is not None and not drive.neutral


def _motion(why: WhyState) -> str:
    """Motion of the robot in words: along its fastest axis, and its turn."""
    values = {name: why.signals[name][1][0] for name in (*_WORDS, "turn_rate") if name in why.signals}
    turn, along = values.pop("turn_rate", math.nan), {n: v for n, v in values.items() if math.isfinite(v)}
    side = " left" if turn > 0.0 else " right"
    fastest = max(along, key=lambda name: abs(along[name]), default="")
    if fastest and abs(along[fastest]) > _SLOW:
        return _WORDS[fastest][along[fastest] < 0.0] + (f" turning{side}" if abs(turn) > _TURNING else "")
    if abs(turn) > _TURNING:
        return f"turned{side}"
    return "was stationary" if "speed" in along else "acted"


def _tilt(why: WhyState) -> float:
    """Tilt of the robot [rad]: its true one if it is recorded, else the measured one; 0 if neither is known."""
    body, signal = why.bodies.get(why.agent), why.signals.get("tilt")
    tilt = body.tilt if body is not None else math.nan
    if math.isnan(tilt) and signal is not None:
        tilt = signal[1][0]
    return 0.0 if math.isnan(tilt) else tilt


def _cause(why: WhyState) -> str:
    """What the agent does: its end, its reflex, the leaf with the running action, or where its mission waits."""
    if why.failed is not None:
        return f"{why.failed.what} failed{since(why.failed, why.t)}: {why.failed.detail}"
    running = why.running
    if why.stopped is not None:
        return _ended(why) or f"it was stopped{since(why.stopped, why.t)} by {why.stopped.by}"
    if running is not None and running.priority == "HIGH":
        return _reflex(why, running)
    if running is not None:
        leaf = f"the leaf '{running.by}' of its mission" if running.by in why.tree.events else f"'{running.by}'"
        return f"{leaf} runs {running.action}({values_text(running.parameters)})"
    if (ended := _ended(why)) or why.tree.root is None:
        return ended or "no action was active"
    return _waits(why)


def _ended(why: WhyState) -> str:
    """End of the mission; empty while it runs."""
    root = why.tree.root
    if root is None or root.status not in ("SUCCESS", "FAILURE"):
        return ""
    leaf = why.tree.failed()
    about = "" if leaf is None else f": '{leaf.node}' failed" + (f" ({leaf.feedback})" if leaf.feedback else "")
    return f"its mission had ended with {root.status}{since(root, why.t)}{about}"


def _reflex(why: WhyState, ticket: TicketChanged) -> str:
    """Rule of the active reflex, with the guard values that latched it: a rule that waited fires with other values."""
    rule = ticket.by.rpartition("/")[2]
    action = "" if ticket.action == rule else f" {ticket.action}"
    fired = next((e for e in reversed(why.fired) if e.rule == ticket.by), None)
    if fired is None:
        return f"the rule {rule} runs{action or f' {ticket.action}'}"
    latched, text = why.causes.get(fired.rule), f"{since(fired, why.t)}: {fired.reading}"
    if fired.phase == "stopped":
        text = f"the rule {rule} fired, and {ticket.action} replaced its action, which raised{text}"
    elif latched is None or fired.t - latched.t < _SLACK:
        text = f"the rule {rule} fired{action}{text}"
    else:
        held = f"it is latched since t = {latched.t:.2f} s, when {latched.reading}"
        if fired.phase == "fired again":
            first = f"the rule {rule} fired{action} again ({counted(fired.refirings, 're-firing')})"
            text = f"{first}{since(fired, why.t)}: its action had ended, and {held}"
        else:
            other = why.waited.get(fired.rule, "another rule").rpartition("/")[2]
            text = f"the rule {rule} resumed{action}{since(fired, why.t)}, after it waited for {other}: {held}"
    return text + _released(why.rules.get(fired.rule), why.t)


def _released(state: RuleChanged | None, t: float) -> str:
    if state is None or state.phase != "released":
        return ""
    return f"; its guard is clear since t = {state.t:.2f} s, and its action goes on"


def _waits(why: WhyState) -> str:
    """Leaves in which the mission waits, each with the values and deadlines for which it waits."""
    texts = []
    for event, began in why.tree.waiting():
        what = [text for text in (event.feedback, *why.tree.deadlines(event.node)) if text]
        took = f" for {why.t - began:.2f} s" if why.t - began > _SLACK else ""
        texts.append(f"waits in '{event.node}'{took}" + (f": {'; '.join(what)}" if what else ""))
    return "its mission " + ", and ".join(texts)


def since(event: Event, t: float) -> str:
    """Age of an event in words, such as `, 0.10 s ago`; empty for an event of this moment."""
    return since_time(event.t, t)


def since_time(then: float, t: float) -> str:
    """Age of a time in words; empty for this moment."""
    age = t - then
    return "" if age < _SLACK else f", {age:.2f} s ago"


def values_text(values: object) -> str:
    """Text of values by name, with three digits."""
    if not isinstance(values, dict):
        return str(values)
    return ", ".join(k if v is True else f"{k}={numbers_text(v)}" for k, v in values.items())


def numbers_text(value: object) -> str:
    """Text of a value with three digits; of a long list, its minimum only."""
    if isinstance(value, float):
        return f"{value:.3g}"
    if isinstance(value, list) and len(value) > _LONG and all(isinstance(v, float) for v in value):
        heard = [v for v in value if math.isfinite(v)]
        least = f", minimum {min(heard):.3g} at [{value.index(min(heard))}]" if heard else ""
        return f"{len(value)} values, {len(heard)} finite{least}"
    if isinstance(value, list):
        shown = ", ".join(numbers_text(v) for v in value)
        return shown if len(value) == 1 else f"[{shown}]"
    return str(value)
