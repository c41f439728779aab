"""A story: what an agent knew at first, and every change since, wherever that was kept."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ...errors import InputError, RecordingError, unknown
from ...event import KnowledgeChanged
from ...knowledge import SCHEMA, Schema
from ...knowledge.history import History, State
from ...knowledge.history.values import plain
from ..recording import Recording


@dataclass(frozen=True)
class Story:
    """What one agent knew over one run.

    Attributes:
        agent: Whose knowledge it is.
        label: What people call the run.
        schema: What gives values their types and units.
        changes: Every change in order; what was known at the beginning comes as changes too.
        begin: When it begins [s].
        end: When it ends [s]: with the run, or where only changes were kept with the newest one.
        missing: Revisions that were left out, from and to.
    """

    agent: str
    label: str
    schema: Schema
    changes: Sequence[KnowledgeChanged]
    begin: float
    end: float
    missing: tuple[tuple[int, int], ...] = ()

    def as_of(self, t: float | None = None) -> State:
        """What was known at a time [s]; at the end where None."""
        state = State(self.agent, self.schema)
        for change in self.changes:
            if t is not None and change.t > t:
                break
            state.apply(change)
        return state


def story_of_recording(recording: Recording, agent: str | None = None, schema: Schema = SCHEMA) -> Story:
    """What an agent of a recorded run knew.

    Args:
        recording: The run.
        agent: Whose; may be left out where there is only one.
        schema: Of the project that it was recorded in.

    Raises:
        InputError: No such agent, or it must be said which; lists who there is.
        RecordingError: The recording is damaged.
    """
    told, end = [], 0.0
    for event in recording.events():
        end = max(end, event.t)
        if isinstance(event, KnowledgeChanged):
            told.append(event)
    names = list(dict.fromkeys((*(a.name for a in recording.header.agents), *(e.agent for e in told))))
    if agent is None and len(names) == 1:
        agent = names[0]
    if agent is None:
        raise InputError(f"'{recording.path}' tells of {', '.join(names)}. Say whose knowledge you want.")
    if agent not in names:
        raise InputError(unknown("agent", agent, names, f"'{recording.path}'"))
    changes = sorted((e for e in told if e.agent == agent), key=lambda e: e.revision)
    if not changes:
        raise RecordingError(f"'{recording.path}' tells of no change of what {agent} knew.")
    return Story(agent, recording.header.label, schema, changes, changes[0].t, end)


def story_of_history(history: History) -> Story:
    """What a journal kept; where changes are missing, what was different after them comes as changes."""
    changes: list[KnowledgeChanged] = []
    for stretch in history.stretches:
        base = history.as_of(revision=stretch.first)
        changes += _as_changes(base, changes, history)
        changes += history.changes(stretch.first, stretch.last)
    first, last = history.first, history.last
    return Story(
        history.agent, history.entry.label, history.schema, changes, first.begin, last.end, tuple(history.gaps)
    )


def story_of_state(state: State, label: str) -> Story:
    """A single state, as of which nothing changed."""
    t = max(state.t, 0.0)
    return Story(state.agent, label, state.schema, list(_told(state, t)), t, t)


def _as_changes(base: State, before: Sequence[KnowledgeChanged], history: History) -> Iterator[KnowledgeChanged]:
    """A base as changes of its moment; what was known before it and is no more is removed first."""
    state = State(history.agent, history.schema)
    for change in before:
        state.apply(change)
    for source, relation, target in state.edges():
        yield _change(base, base.t, "edge removed", source, relation, target)
    for name in state.nodes():
        yield _change(base, base.t, "node removed", name, state.kind(name))
    yield from _told(base, base.t)


def _told(state: State, t: float) -> Iterator[KnowledgeChanged]:
    for name in state.nodes():
        yield _change(state, t, "node added", name, state.kind(name))
        for attribute in state.written(name):
            yield _change(state, t, "attribute", name, attribute, state.get(name, attribute))
    for source, relation, target in state.edges():
        known = state.edge(source, relation, target) or {}
        yield _change(state, t, "edge added", source, relation, target, known)


def _change(
    state: State, t: float, what: str, subject: str, name: str, value: Any = None, attributes: Mapping[str, Any] = {}
) -> KnowledgeChanged:
    held = {attribute: plain(given) for attribute, given in attributes.items()}
    return KnowledgeChanged(
        t=t, agent=state.agent, what=what, subject=subject, name=name, value=plain(value), revision=state.revision,
        attributes=held,
    )  # fmt: skip
