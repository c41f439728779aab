"""State of an agent at a time of a run, looked up in its tracks."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import Any

from ...base.errors import Fault, InputError, unknown
from ...event import TicketChanged, TreeNode
from ..file.header import AgentInfo
from ..fold.states import RuleState
from ..fold.tracks import Tracks

SLACK = 5e-4
"""Tolerance of times given by people, which are rounded [s]."""


class MissionState:
    """Statuses of the nodes of a mission's tree at a time.

    Attributes:
        nodes: Nodes by path, parents before children.
        root: Path of the root; empty if it has not been ticked.
    """

    def __init__(self, tracks: Tracks, agent: str, t: float) -> None:
        self._tracks, self._agent, self._t = tracks, agent, t
        tree = tracks.steps(agent, "tree").at(t) or ()
        self.nodes: dict[str, TreeNode] = {node.path: node for node in tree}
        root = next(iter(self.nodes), "")
        self.root = root if self.status(root) else ""

    def status(self, path: str) -> str:
        """Status of a node; empty if it has not been ticked."""
        return self._tracks.steps(self._agent, "node", path).at(self._t) or ""

    def note(self, path: str) -> str:
        """Message of a node."""
        return self._tracks.steps(self._agent, "note", path).at(self._t) or ""

    def since(self, path: str) -> float:
        """Time from which a node has its status [s]."""
        return self._tracks.steps(self._agent, "node", path).since(self._t)

    def changed(self, path: str) -> float:
        """Time of the last change of the status or message of a node [s]."""
        return max(self.since(path), self._tracks.steps(self._agent, "note", path).since(self._t))

    def waiting(self) -> list[str]:
        """Nodes in which a RUNNING tree waits.

        These are the RUNNING leaves, and below a RUNNING node without RUNNING children the node that was ticked last.
        """
        return list(self._front(self.root)) if self.root and self.status(self.root) == "RUNNING" else []

    def above(self, path: str) -> list[str]:
        """Messages of the nodes above a node that are RUNNING or failed as the root; nearest first.

        These are deadlines such as that of a Timeout, and attempts such as that of a RetryUntilSuccessful.
        """
        parents = {child: node.path for node in self.nodes.values() for child in node.children}
        found, wanted = [], self.status(self.root)
        while self.status(path := parents.get(path, "")):
            if self.status(path) == wanted and self.note(path):
                found.append(self.note(path))
        return found

    def failed(self) -> str:
        """Leaf that made the root fail; empty if the root has not failed."""
        return self._last(self.root) if self.root and self.status(self.root) == "FAILURE" else ""

    def _children(self, path: str) -> list[str]:
        """Children that have been ticked."""
        return [child for child in self.nodes[path].children if self.status(child)] if path in self.nodes else []

    def _front(self, path: str) -> Iterator[str]:
        running = [child for child in self._children(path) if self.status(child) == "RUNNING"]
        for child in running:
            yield from self._front(child)
        if not running:
            yield self._last(path)

    def _last(self, path: str) -> str:
        """Node below a path that was ticked last and gave its outcome; the path itself if there is none."""
        while ended := [child for child in self._children(path) if self.status(child) != "INVALID"]:
            same = [child for child in ended if self.status(child) == self.status(path)] or ended
            path = max(enumerate(same), key=lambda item: (self.changed(item[1]), item[0]))[1]
        return path


class Moment:
    """State of an agent at a time of a run.

    Args:
        tracks: All tracks of the run, which may go on.
        t: Time [s].
        agent: Name of the agent; the first agent by default.

    Attributes:
        tracks: Tracks of the run.
        agent: Name of the agent.
        now: Time until which the run counts [s].
        mission: Statuses of the nodes of the mission's tree.

    Raises:
        InputError: Unknown agent, or a time outside the run.
    """

    def __init__(self, tracks: Tracks, t: float, agent: str | None = None) -> None:
        names = [a.name for a in tracks.header.agents]
        self.agent = agent if agent is not None else names[0] if names else ""
        if self.agent not in names:
            raise InputError(unknown("agent", self.agent, names, "The run"))
        start, end = tracks.header.start, tracks.end
        if not start <= t <= end + SLACK:
            covered = f"from {start:g} s to {end:g} s"
            raise InputError(Fault(f"the time {t:g} s is outside the run.", hint=f"The run is {covered}."))
        self.tracks, self.t, self.now = tracks, t, t + SLACK
        self.mission = MissionState(tracks, self.agent, self.now)

    @property
    def info(self) -> AgentInfo:
        """Description of the agent."""
        return next(a for a in self.tracks.header.agents if a.name == self.agent)

    @cached_property
    def rules(self) -> dict[str, RuleState]:
        """Active and latched rules, in the order of their last change."""
        states = self.tracks.state(self.now, self.agent, "rule")
        found = [name for name, state in states.items() if state.active or state.latched]
        found.sort(key=lambda name: (self.since("rule", name), not states[name].active))
        return {name: states[name] for name in found}

    @cached_property
    def fired(self) -> str:
        """The rule that fired last so far; empty if none did."""
        states = self.tracks.state(self.now, self.agent, "rule")
        times = {name: state.firing[0] for name, state in states.items() if state.firing}
        return max(times, key=lambda name: times[name], default="")

    @cached_property
    def tickets(self) -> dict[str, TicketChanged]:
        """Open tickets by number."""
        tickets = self.tracks.state(self.now, self.agent, "ticket")
        return {name: event for name, event in tickets.items() if event.state in ("QUEUED", "RUNNING")}

    @property
    def running(self) -> TicketChanged | None:
        """Ticket of the running action, of a reflex first; None if no action runs."""
        running = [event for event in self.tickets.values() if event.state == "RUNNING"]
        return min(running, key=lambda event: event.priority, default=None)  # "HIGH" < "NORMAL"

    def value(self, topic: str, name: str = "") -> Any:
        """Value of a track of the agent; None if there is none."""
        track = self.tracks.get(self.agent, topic, name)
        return None if track is None else track.at(self.now)

    def since(self, topic: str, name: str = "") -> float:
        """Time from which a track of the agent has its value [s]."""
        return self.tracks.steps(self.agent, topic, name).since(self.now)
