"""Memory: knowledge that agents keep from run to run, in a file."""

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
    """File of knowledge that agents keep from run to run: loaded before the run, and written during the run.

    Args:
        path: Path of the file, which is created if it does not exist. None loads and writes nothing.
        agents: Agents of this run; each loads the knowledge of the newest run in the file with an agent of its name.

    Raises:
        RecordingError: The file is not a knowledge journal, or is damaged.
    """

    def __init__(self, path: Path | None, agents: Sequence[Agent]) -> None:
        self._path = path
        self._agents = agents
        self._journal: Journal | None = None
        self._pasts: list[JournalPast] = []
        self.recalled: dict[str, str] = {}  # JSON, by agent; agents without earlier knowledge are missing
        self._refused: dict[str, list[str]] = {}
        if path is not None and path.exists():
            known = {entry.agent for entry in History.runs(path)}
            for agent in agents:
                if agent.name in known:
                    self._recall(path, agent)
        self._loaded = recall(self.recalled, agents)

    def start(self, label: str, patient: bool) -> None:
        """Begin to write this run to the file.

        If `patient`, agents may wait for the disk: only in lockstep, which does not depend on wall time.
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
        """Write the remaining changes and close the file.

        Raises:
            RecordingError: Writing failed.
        """
        for past in self._pasts:
            past.close()
        if self._journal is not None:
            self._journal.close()

    def summary(self) -> KnowledgeFile | UnsetType:
        """Summary of the loaded and written knowledge; UNSET without a file."""
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
    """Load knowledge of earlier runs into the agents; returns the result by agent, without those that have none."""
    loaded = {}
    for agent in agents:
        text = recalled.get(agent.name)
        if text is not None:
            graph = agent.knowledge.graph
            loaded[agent.name] = load_into(graph, from_json_text(text, Path("the recording"), graph.schema))
    return loaded
