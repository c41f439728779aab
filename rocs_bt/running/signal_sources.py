"""Origins of an agent's signals: the monitors of their sensors, and the rules that read them."""

from __future__ import annotations

from collections.abc import Iterable

from ..agent import Agent
from ..catalog import RobotSpec
from ..expression import Node
from ..knowledge import Knowledge


def signal_monitors(agent: Agent, robot: RobotSpec) -> dict[str, list[str]]:
    """Names of the monitors from which each signal comes, directly or through an analyser."""
    sources = {signal.name: [monitor.name] for monitor in agent.monitors for signal in monitor.signals()}
    heard = {spec.name: spec.monitors for spec in robot.analyzers}
    for analyze in agent.analyzes:
        for signal in analyze.signals():
            sources[signal.name] = list(heard.get(analyze.name, ()))
    return sources


def signals_read(nodes: Iterable[Node], knowledge: Knowledge) -> set[str]:
    """Names of the signals that expressions read."""
    table = knowledge.signals
    indices = {i for node in nodes for i in node.reads()}
    slices = {name: table.slice_of(name) for name in table.names}
    return {name for name, part in slices.items() if not indices.isdisjoint(range(part.start, part.stop))}
