"""Swaps: subtrees of missions that a run replaces at given times."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from contextlib import ExitStack

import msgspec

from ..agent import Agent
from ..base.errors import Fault, InputError, RecordingError, unknown
from ..base.files import same_file
from ..catalog import TREES, Catalog, Entry, ScenarioSpec, content_hash
from ..event import Event, RunControlled
from ..plan import TreePlan, mission_faults
from ..record import SubtreeSwap
from ..record.file.header import SWAP_FORM
from ..trees.error import TreeError
from ..trees.nodes import Node
from .build_agents import worldless_agents
from .run_options import Build

_SAME = 1e-9  # [s]


class SwapSchedule:
    """Replaces subtrees of the missions of a run when their times have come.

    Raises:
        InputError: A mission does not load.
    """

    def __init__(self, swaps: Sequence[SubtreeSwap], agents: Sequence[Agent], catalog: Catalog) -> None:
        self._agents = agents
        self._catalog = catalog
        self._coming: deque[tuple[SubtreeSwap, Agent, str, Node]] = deque(self._loaded(swap) for swap in swaps)

    def add(self, swap: SubtreeSwap) -> tuple[SubtreeSwap, str]:
        """Add a swap during the run, which the next `step` at its time makes.

        Returns:
            The swap with the node as `AGENT:NODE` and a mission of the catalog by its name; hash of the mission.

        Raises:
            InputError: The node or the mission does not exist, or the mission does not load or does not fit.
        """
        (agent, node), entry = _place(swap.node, self._agents), _entry(swap, self._catalog)
        if faults := _plan(agent).place_faults(node, entry.path, swap.tree):
            raise InputError(*faults)
        swap = _named(swap, agent, node, entry, self._catalog)
        self._coming = deque(sorted([*self._coming, self._loaded(swap)], key=lambda each: each[0].at))
        return swap, content_hash([entry])

    def _loaded(self, swap: SubtreeSwap) -> tuple[SubtreeSwap, Agent, str, Node]:
        name, node = swap.node.split(":", 1)
        agent = next(each for each in self._agents if each.name == name)
        return swap, agent, node, _plan(agent).load(_entry(swap, self._catalog).path, swap.tree)

    def step(self, t: float) -> None:
        """Make the swaps that are due at time t [s]; while the plan is in a turn, its swap waits for the next call."""
        while self._coming and self._coming[0][0].at <= t + _SAME:
            _, agent, node, root = self._coming[0]
            if not agent.swap(node, root):
                return
            self._coming.popleft()


def rehearse_swaps(
    swaps: Sequence[SubtreeSwap],
    scenario: ScenarioSpec,
    catalog: Catalog,
    *,
    seed: int,
    duration: float,
    missions: Mapping[str, Build] | None = None,
) -> tuple[SubtreeSwap, ...]:
    """Make swaps on agents without a world, so that all faults of the swaps are found before the run.

    Args:
        swaps: The swaps.
        scenario: The scenario.
        catalog: Source of the content.
        seed: Seed of the run.
        duration: Maximum duration of the run [s].
        missions: Mission functions that replace the scenario's, by agent.

    Returns:
        The swaps, ordered by time, with nodes in the form `AGENT:NODE`, and missions of the catalog by their names.

    Raises:
        InputError: A time is outside of the run, a node or a mission does not exist, or a mission does not load or does
            not fit.
    """
    if not swaps:
        return ()
    for swap in swaps:
        if not 0.0 <= swap.at < duration:
            message = f"the swap '{swap}' is not within the run, which is from 0 s to {duration:g} s."
            raise InputError(Fault(message, hint=SWAP_FORM))
    with ExitStack() as stack:
        agents = worldless_agents(scenario, catalog, seed=seed, missions=missions)
        for agent in agents:
            stack.callback(agent.close)
            stack.callback(agent.stop, "the end of the rehearsal")
        return tuple(_rehearsed(swap, agents, catalog) for swap in sorted(swaps, key=lambda swap: swap.at))


def swapped_content(swaps: Sequence[SubtreeSwap], scenario: ScenarioSpec, catalog: Catalog) -> tuple[Entry, ...]:
    """Catalog entries of the missions of swaps from `rehearse_swaps`, for the hash of the run's content."""
    found: list[Entry] = []
    for swap in swaps:
        spec = next(a for a in scenario.agents if a.name == swap.node.partition(":")[0])
        entry = _entry(swap, catalog)
        found += [entry, *catalog.python_of(entry, dialect=spec.nodes)]
    return tuple(dict.fromkeys(found))


def _rehearsed(swap: SubtreeSwap, agents: Sequence[Agent], catalog: Catalog) -> SubtreeSwap:
    agent, node = _place(swap.node, agents)
    entry, plan = _entry(swap, catalog), _plan(agent)
    before = mission_faults(plan.tree, agent.knowledge)
    if faults := plan.place_faults(node, entry.path, swap.tree):
        raise InputError(*faults)
    plan.swap(node, plan.load(entry.path, swap.tree))
    after = mission_faults(plan.tree, agent.knowledge)
    if faults := [fault for fault in after if not fault.warning and fault not in before]:
        raise InputError(*faults)
    return _named(swap, agent, node, entry, catalog)


def _named(swap: SubtreeSwap, agent: Agent, node: str, entry: Entry, catalog: Catalog) -> SubtreeSwap:
    """Swap with the node as `AGENT:NODE`, and a mission of the catalog by its name."""
    listed = next((e for e in catalog.list("mission") if e.name == entry.name), None)
    named = listed is not None and same_file(listed.path, entry.path)
    mission = entry.name if named else str(entry.path)
    return msgspec.structs.replace(swap, node=f"{agent.name}:{node}", mission=mission)


def controlled_swaps(events: Sequence[Event], catalog: Catalog, *, changed_content: bool) -> list[SubtreeSwap]:
    """Swaps that a person made during a recorded run.

    Raises:
        RecordingError: The content of a mission has changed since.
    """
    found = []
    for event in events:
        if isinstance(event, RunControlled) and event.command == "swap" and not event.refusal:
            swap = SubtreeSwap(event.target, event.source, event.t, event.tree)
            if not changed_content and content_hash([_entry(swap, catalog)]) != event.content:
                raise RecordingError(f"the mission '{swap.mission}' has changed since the swap at {swap.at:g} s.")
            found.append(swap)
    return found


def _entry(swap: SubtreeSwap, catalog: Catalog) -> Entry:
    entry = catalog.find("mission", swap.mission)
    if entry.path.suffix not in TREES:
        hint = "Give the mission of a swap in XML."
        raise InputError(Fault(f"'{swap.mission}' is no mission in XML.", entry.path, hint=hint))
    return entry


def _plan(agent: Agent) -> TreePlan:
    if not isinstance(agent.plan, TreePlan):
        raise InputError(f"the mission of {agent.name} is no behaviour tree, so no subtree of it can be replaced.")
    return agent.plan


def _place(node: str, agents: Sequence[Agent]) -> tuple[Agent, str]:
    """Agent and node that a swap names, as `NODE` or `AGENT:NODE`."""
    name, _, rest = node.partition(":")
    if rest and name in {agent.name for agent in agents}:
        agents, node = [agent for agent in agents if agent.name == name], rest
    trees = [agent for agent in agents if isinstance(agent.plan, TreePlan)] or [*agents]
    found, faults = [], list[Fault]()
    for agent in trees:
        try:
            _plan(agent).find(node)
        except TreeError as error:
            faults += error.faults
        else:
            found.append(agent)
    if len(found) == 1:
        return found[0], node
    if found:
        names = ", ".join(agent.name for agent in found)
        raise InputError(Fault(f"the missions of {names} have a node '{node}'.", hint=f"Write {found[0].name}:{node}."))
    if len(trees) == 1:
        raise TreeError(*faults)
    known = {each.name for agent in trees for each in _plan(agent).tree.nodes}
    raise InputError(unknown("node", node, known, "The run"))
