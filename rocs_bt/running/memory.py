"""Memory: knowledge that agents keep from run to run, in a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from msgspec import UNSET, UnsetType

from ..agent import Agent
from ..base.errors import InputError, RecordingError
from ..base.files import check_writable, is_file, write_whole
from ..knowledge.history import GraphState, LoadResult, load_into, persistent_part, read_knowledge, to_json_text
from ..record import KnowledgeFile, Remembered


class Memory:
    """File of knowledge that agents keep from run to run: loaded before the run, and written at its end.

    Args:
        path: Path of the file, which is created if it does not exist. None loads and writes nothing.
        agents: Agents of this run; each loads the knowledge of an agent of its name in the file.

    Attributes:
        recalled: Loaded knowledge as JSON; empty without any.

    Raises:
        InputError: The file is not a file of knowledge, or has faults.
        RecordingError: The file cannot be written.
    """

    def __init__(self, path: Path | None, agents: Sequence[Agent]) -> None:
        self._path = path
        self._agents = agents
        self._begun = False
        known = self._read()
        if path is not None and path.parent.is_dir():
            try:
                check_writable(path)  # now, and not after an hour
            except OSError as error:
                raise RecordingError(f"the knowledge '{path}' cannot be written: {error.strerror}.") from error
        lasting = {agent.name: persistent_part(known[agent.name]) for agent in agents if agent.name in known}
        self.recalled = to_json_text(*lasting.values()) if lasting else ""
        self._loaded = recall(lasting, agents)

    def start(self) -> None:
        """The robots start: from now on the run has knowledge to keep."""
        self._begun = True

    def write(self) -> None:
        """Replace the file as a whole, once; agents that have no part in this run keep their knowledge in it.

        Raises:
            RecordingError: The file is no file of knowledge any more.
            OSError: The file cannot be written; the old one stays.
        """
        if self._path is None or not self._begun:
            return
        self._begun = False
        try:
            states = self._read()  # again, because a run of other agents may have written it meanwhile
        except InputError as error:
            raise RecordingError(f"the knowledge '{self._path}' is not written: {error}") from error
        states |= {agent.name: GraphState.of(agent.knowledge.graph) for agent in self._agents}
        self._path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(self._path, to_json_text(*states.values()))

    def summary(self) -> KnowledgeFile | UnsetType:
        """Summary of the loaded knowledge; UNSET without a file."""
        if self._path is None:
            return UNSET
        remembered = {
            name: Remembered(nodes=loaded.nodes, edges=loaded.edges, refused=loaded.refused)
            for name, loaded in self._loaded.items()
        }
        return KnowledgeFile(file=str(self._path), remembered=remembered)

    def _read(self) -> dict[str, GraphState]:
        if self._path is None or not is_file(self._path):
            return {}
        return read_knowledge(self._path, self._agents[0].knowledge.graph.schema)


def recall(known: Mapping[str, GraphState], agents: Sequence[Agent]) -> dict[str, LoadResult]:
    """Load knowledge of earlier runs into the agents; returns the result by agent, without those that have none."""
    return {agent.name: load_into(agent.knowledge.graph, known[agent.name]) for agent in agents if agent.name in known}
