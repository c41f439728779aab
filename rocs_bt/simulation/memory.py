"""What agents remember of earlier runs, and where this run's knowledge is kept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from msgspec import UNSET, UnsetType

from ..agent import Agent
from ..knowledge.history import (
    History,
    Journal,
    JournalPast,
    LoadResult,
    from_json_text,
    load_into,
    persistent_part,
    to_json_text,
)
from ..record import KnowledgeFile, Remembered


class Memory:
    """A file of knowledge between runs: loaded into the agents before the first period, and written as they go.

    Args:
        path: The file; made where there is none. None remembers nothing, and keeps nothing.
        agents: The agents of this run; each finds what the newest run of its name left.

    Attributes:
        recalled: What each agent found, as JSON; those that found nothing are not in it.

    Raises:
        RecordingError: The file is none of ours, or damaged.
    """

    def __init__(self, path: Path | None, agents: Sequence[Agent]) -> None:
        self._path = path
        self._agents = agents
        self._journal: Journal | None = None
        self._pasts: list[JournalPast] = []
        self.recalled: dict[str, str] = {}
        self._refused: dict[str, list[str]] = {}
        if path is not None and path.exists():
            known = {entry.agent for entry in History.runs(path)}
            for agent in agents:
                if agent.name in known:
                    self._recall(path, agent)
        self._loaded = recall(self.recalled, agents)

    def keep(self, label: str, patient: bool) -> None:
        """Begin to write this run to the file.

        Args:
            label: What people call the run.
            patient: Whether agents may wait for the disk: in lockstep, where nobody looks at a wall clock.
        """
        if self._path is None:
            return
        self._path.parent.mkdir(parents=True, exist_ok=True)
        self._journal = Journal(self._path, label, blocking=patient)
        for agent in self._agents:
            self._journal.attach(agent.knowledge.graph)
            past = agent.knowledge.past = JournalPast(self._journal, agent.knowledge.graph)
            self._pasts.append(past)

    def close(self) -> None:
        """Write what is left.

        Raises:
            RecordingError: Something could not be written.
        """
        for past in self._pasts:
            past.close()
        if self._journal is not None:
            self._journal.close()

    def summary(self) -> KnowledgeFile | UnsetType:
        """Summary of the knowledge between runs; UNSET without a file."""
        if self._path is None:
            return UNSET
        remembered = {
            name: Remembered(nodes=loaded.nodes, edges=loaded.edges, refused=(*self._refused[name], *loaded.refused))
            for name, loaded in self._loaded.items()
        }
        lost = 0 if self._journal is None else self._journal.lost
        return KnowledgeFile(file=str(self._path), remembered=remembered, lost=lost)

    def _recall(self, path: Path, agent: Agent) -> None:
        schema = agent.knowledge.graph.schema
        with History(path, agent.name, schema=schema) as history:
            state, faults = persistent_part(history.as_of(), schema, path)
        self.recalled[agent.name] = to_json_text(state)
        self._refused[agent.name] = [fault.message for fault in faults]


def recall(recalled: Mapping[str, str], agents: Sequence[Agent]) -> dict[str, LoadResult]:
    """Load what each agent remembers, as JSON, into its knowledge: what it took in, by its name."""
    loaded = {}
    for agent in agents:
        text = recalled.get(agent.name)
        if text is not None:
            graph = agent.knowledge.graph
            loaded[agent.name] = load_into(graph, from_json_text(text, Path("the recording"), graph.schema))
    return loaded
