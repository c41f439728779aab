"""Why an agent did what it did at a time: what caused the motion of its robot.

The page gives the same answer (studio/web/why.js).
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence

from ...base.words import counted
from ...event import RobotPushed, TicketChanged
from ..file.recording import Recording
from ..fold.states import Drive
from ..fold.track import Steps
from ..fold.tracks import Tracks
from .evidence import evidence, since, values_text
from .moment import SLACK, Moment

_PUSHED = 1.0  # [s] time after a push in which it explains a motion
_COASTING = 3.0  # [s] time after a command in which it explains a motion
_ENDS = ("SUCCESS", "FAILURE")


class Why(Moment):
    """State of an agent at a time of a run, and its explanation in words."""

    @property
    def answer(self) -> str:
        """Sentence with the motion of the robot, and what caused it: a rule, a leaf of the mission, a wait, an end."""
        turns = self.value("alternation")
        return f"{self._answer()}; {turns.text}." if turns is not None and turns.lasts(self.t) else f"{self._answer()}."

    def _answer(self) -> str:
        motion, cause = self.value("motion") or "acted", self._cause()
        if tilt := self.value("motion", "true tilt") or self.value("motion", "tilt"):
            return f"{self.agent} {tilt}, while {cause}"
        push = self.value("push")
        if isinstance(push, RobotPushed) and push.t - SLACK <= self.t <= push.t + push.duration + _PUSHED:
            return f"{self.agent} {motion} and was {push.sentence}{since(push.t, self.t)}, while {cause}"
        if held := self._held():
            link = "because" if motion in ("was stationary", "acted") else "although"
            return f"{self.agent} {motion} {link} {held}, while {cause}"
        return f"{self.agent} {self._linked(motion, cause)}"

    def text(self, *, everything: bool = False) -> str:
        """The answer and its evidence, a few lines or all of it."""
        hint = "" if everything else " (--all prints everything known)"
        lines = evidence(self, everything=everything)
        return "\n".join([self.answer, f"Evidence at t = {self.t:.3f} s{hint}:", *lines])

    def __str__(self) -> str:
        return self.text()

    def _held(self) -> str:
        held = self.tracks.state(self.now, self.agent, "hold")
        names = sorted((name for name, reason in held.items() if reason), key=lambda name: self.since("hold", name))
        holds = (f"a safety gate holds '{name}' in neutral{self._ago('hold', name)} ({held[name]})" for name in names)
        return next(holds, "")

    def _ago(self, topic: str, name: str = "") -> str:
        return since(self.since(topic, name), self.t)

    def _linked(self, motion: str, cause: str) -> str:
        """Join motion and cause. The motion is measured, so its cause is the command of the period before."""
        running, drives = self.running, self.tracks.steps(self.agent, "drive")
        before, now = drives.at(self.t - SLACK), drives.at(self.now)
        if motion == "acted":  # the robot does not measure its speed
            return f"{motion} because {cause}"
        if motion == "was stationary":
            commanded = now is not None and not now.neutral and self.value("stopped") is None
            return f"{motion} while {cause}" if commanded and running is not None else f"{motion} because {cause}"
        if before is not None and before.ticket and running is not None and before.ticket == running.ticket:
            return f"{motion} because {cause}"
        t, last = self._drove(drives)
        if last is None:
            return f"{motion} without a command, while {cause}"
        return f"{motion} by the last command of {last.action}{since(t, self.t)}; now {cause}"

    def _drove(self, drives: Steps) -> tuple[float, Drive | None]:
        """Time [s] and cause of the last command before this time that moved the robot, if it still explains it."""
        for i in range(bisect_left(drives.t, self.t - SLACK) - 1, -1, -1):
            if self.t - drives.t[i] > _COASTING:
                break
            if drives.v[i].ticket and not drives.v[i].neutral:
                return drives.t[i], drives.v[i]
        return self.t, None

    def _cause(self) -> str:
        """What the agent does: its end, its reflex, the leaf with the running action, or where its mission waits."""
        if failed := self.value("failed"):
            what, detail = failed.split("\n", 1)
            return f"{what}{self._ago('failed')}: {detail}"
        running = self.running
        if (by := self.value("stopped")) is not None:
            return self._ended() or f"it was stopped{self._ago('stopped')} by {by}"
        if running is not None and running.priority == "HIGH":
            return self._reflex(running)
        if running is not None:
            leaf = f"the leaf '{running.by}' of its mission" if self.mission.status(running.by) else f"'{running.by}'"
            text = f"{leaf} runs {running.action}({values_text(running.parameters)})"
            return _with(text, self.mission.above(running.by))
        failing = next((name for name, state in self.rules.items() if state.active), "")
        if (ended := self._ended()) or (not self.mission.root and not failing):
            return ended or "no action was active"
        if failing:
            return f"the rule {failing.rpartition('/')[2]} is active{self._failures(failing)}"
        return self._waits()

    def _ended(self) -> str:
        """End of the mission; empty while it runs."""
        mission, root = self.mission, self.mission.root
        if mission.status(root) not in _ENDS:
            return ""
        leaf = mission.failed()
        about = _with(f": '{leaf}' failed", [mission.note(leaf), *mission.above(leaf)]) if leaf else ""
        return f"its mission had ended with {mission.status(root)}{since(mission.changed(root), self.t)}{about}"

    def _reflex(self, ticket: TicketChanged) -> str:
        """Rule of the active reflex, with the guard values that latched it; a rule that waited fires with others."""
        rule, state = ticket.by.rpartition("/")[2], self.value("rule", ticket.by)
        action = "" if ticket.action == rule else f" {ticket.action}"
        if state is None or state.firing is None:
            return f"the rule {rule} runs{action or f' {ticket.action}'}"
        (t, phase, reading), cause = state.firing, state.cause
        ago, clue = since(t, self.t), self._clue(ticket.by, t)
        if phase == "stopped":
            text = f"the rule {rule} fired, and {ticket.action} replaced its action, which raised{ago}: {reading}{clue}"
        elif cause is None or t - cause[0] < SLACK:
            text = f"the rule {rule} fired{action}{ago}: {reading}{clue}"
        else:
            held = f"it is latched since t = {cause[0]:.2f} s, when {cause[1]}{self._clue(ticket.by, cause[0])}"
            if phase == "fired again":
                first = f"the rule {rule} fired{action} again ({counted(state.again, 're-firing')})"
                text = f"{first}{ago}: its action had ended, and {held}"
            else:
                other = (state.behind or "another rule").rpartition("/")[2]
                text = f"the rule {rule} resumed{action}{ago}, after it waited for {other}: {held}"
        if state.phase == "released":
            text += f"; its guard is clear since t = {self.since('rule', ticket.by):.2f} s, and its action goes on"
        return text + self._failures(ticket.by)

    def _failures(self, rule: str) -> str:
        failures = self.value("failures", rule)
        return "" if failures is None else f", and {failures.text}"

    def _clue(self, rule: str, t: float) -> str:
        """Clues to the values of a guard at a time, in brackets: a silent sensor, a limit, the nearest object."""
        track = self.tracks.get(self.agent, "clue", rule)
        text = "" if track is None else track.at(t)
        return f" ({text})" if text else ""

    def _waits(self) -> str:
        """Leaves in which the mission waits, each with the values and deadlines for which it waits."""
        texts = []
        for path in self.mission.waiting():
            what = [text for text in (self.mission.note(path), *self.mission.above(path)) if text]
            took = self.t - self.mission.since(path)
            lasts = f" for {took:.2f} s" if took > SLACK else ""
            texts.append(f"waits in '{path}'{lasts}" + (f": {'; '.join(what)}" if what else ""))
        return "its mission " + ", and ".join(texts)


def _with(text: str, notes: Sequence[str]) -> str:
    """A text with notes in brackets."""
    said = "; ".join(filter(None, notes))
    return f"{text} ({said})" if said else text


def explain(recording: Recording, t: float, agent: str | None = None) -> Why:
    """Explain the state of an agent at a time.

    Args:
        recording: Recording of the run.
        t: Time [s].
        agent: Name of the agent; the first agent by default.

    Raises:
        InputError: Unknown agent, or a time outside the run.
    """
    return Why(Tracks.of_recording(recording), t, agent)
