"""Rule files on recordings: when each rule would have fired, and how often for which threshold.

Open loop: the rules see what the run's robot saw, whatever they would have done about it.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..actions import ACTIONS
from ..agent.build import thresholds
from ..catalog import Catalog
from ..errors import Fault, InputError, UnknownName, unknown
from ..event import RuleChanged
from ..expression import Node, compile_node, reading
from ..reactive import Override, Rule, RuleSet, Steps, choose_backend, load_rules, lower_rules
from ..record import AgentInfo, Recording, environment_of, samples_of
from ..record.figures.rules import Compared, RuleTrace, spans
from ..units import Dimension, parse_quantity

Series = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ReflexInput:
    """What one agent's reflexes saw in a run.

    Attributes:
        run: The run's short name, such as `exp1-1`.
        agent: What the recording says of the agent.
        t: Times [s], (n,).
        x: Snapshots, (n, size).
        modes: The agent's mode at each.
        latched: When each rule latched in the run itself [s], by name.
    """

    run: str
    agent: AgentInfo
    t: Series
    x: Series
    modes: tuple[str, ...]
    latched: Mapping[str, tuple[float, ...]]


@dataclass(frozen=True)
class Firing:
    """A rule that would have latched: its name, from when until when [s], how much of it as winner [s], its reading."""

    rule: str
    begin: float
    end: float
    won: float
    reading: str


@dataclass(frozen=True, eq=False)
class RuleReplay:
    """What a rule file would have done.

    Attributes:
        rules: The rules.
        inputs: What they saw.
        steps: What they gave at each sample.
        firings: Each latching, in the order of time.
    """

    rules: RuleSet
    inputs: ReflexInput
    steps: Steps
    firings: tuple[Firing, ...]

    def traces(self) -> list[RuleTrace]:
        """Each rule over time, to be drawn."""
        return [
            RuleTrace(rule.name, self.steps.mask[:, i], self.steps.winner == i, _panels(rule, self.inputs))
            for i, rule in enumerate(self.rules.rules)
        ]


def reflex_input(recording: Recording, agent: AgentInfo) -> ReflexInput:
    """What an agent's reflexes saw in a run.

    Raises:
        RecordingError: The recording cannot be read, or says nothing of the agent's signals.
    """
    samples = [sample for sample in samples_of(recording, agent) if sample.felt]
    size = environment_of(agent).size
    latched: dict[str, tuple[float, ...]] = {}
    for event in recording.events():
        if isinstance(event, RuleChanged) and event.agent == agent.name and event.phase == "latched":
            latched[event.rule] = (*latched.get(event.rule, ()), event.t)
    return ReflexInput(
        run=recording.header.label,
        agent=agent,
        t=np.array([sample.t for sample in samples]),
        x=np.array([sample.x[:size] for sample in samples]).reshape(len(samples), size),
        modes=tuple(sample.mode for sample in samples),
        latched=latched,
    )


def rules_for(file: Path, agent: AgentInfo, catalog: Catalog, own: Mapping[str, Override] | None = None) -> RuleSet:
    """A rule file as an agent of a recording has it, with the thresholds of its robot where the catalog knows it.

    Args:
        file: The rule file.
        agent: What the recording says of the agent.
        catalog: Where its robot is found.
        own: Thresholds that stand above those.

    Raises:
        InputError: Something in the file is wrong, or does not fit the agent.
    """
    try:
        robot = catalog.load_robot(agent.robot)
    except UnknownName:  # a recording of somebody else's robot
        overrides = {}
    else:
        overrides = thresholds(robot, file)
    return load_rules(file, environment_of(agent), ACTIONS, overrides={**overrides, **(own or {})})


def replay_rules(rules: RuleSet, inputs: ReflexInput) -> RuleReplay:
    """When each rule would have fired on what was inputs."""
    steps = _run(rules, inputs)
    firings = []
    for i, rule in enumerate(rules.rules):
        won = steps.winner == i
        for begin, end in spans(inputs.t, steps.mask[:, i]):
            inside = (inputs.t >= begin) & (inputs.t < end)
            lasts = np.diff(inputs.t, append=inputs.t[-1])
            at = inputs.x[int(np.searchsorted(inputs.t, begin))]
            saw = reading(rule.when.node, at.tolist())
            firings.append(Firing(rule.name, begin, end, float(lasts[inside & won].sum()), saw))
    return RuleReplay(rules, inputs, steps, tuple(sorted(firings, key=lambda f: (f.begin, f.rule))))


def sweep_threshold(
    file: Path,
    inputs: Sequence[ReflexInput],
    catalog: Catalog,
    *,
    rule: str,
    threshold: str,
    values: Sequence[float],
    dimension: Dimension,
) -> Series:
    """How often a rule would have fired for each value of a threshold, (values, runs).

    Args:
        file: The rule file.
        inputs: Runs.
        catalog: Where robots are found.
        rule: The rule, with or without the file's name.
        threshold: The threshold's name.
        values: Its values, SI units.
        dimension: Its dimension.

    Raises:
        InputError: There is no such rule, or a value is none that the file can be loaded with.
    """
    counts = np.zeros((len(values), len(inputs)))
    for i, value in enumerate(values):
        own = {threshold: Override(f"{value!r} {dimension}")}
        for k, each in enumerate(inputs):
            rules = rules_for(file, each.agent, catalog, own)
            place = rule_index(rule, rules)
            counts[i, k] = len(spans(each.t, _run(rules, each).mask[:, place]))
    return counts


def rule_index(rule: str, rules: RuleSet) -> int:
    """Where a rule stands in its set, by its name with or without the file's.

    Raises:
        UnknownName: There is none.
    """
    names = [r.name.rpartition("/")[2] for r in rules.rules]
    short = rule.rpartition("/")[2]
    if short not in names:
        raise UnknownName(unknown("rule", rule, names, f"The rule file '{rules.name}'"))
    return names.index(short)


def threshold_dimension(threshold: str, rules: RuleSet) -> Dimension:
    """The dimension of a threshold of a rule set.

    Raises:
        InputError: There is none of this name.
    """
    for file in reversed(rules.files):
        written = tomllib.loads(file.read_text(encoding="utf-8")).get("threshold", {}).get(threshold)
        if written is not None:
            return parse_quantity(str(written)).dimension
    fault = unknown("threshold", threshold, rules.thresholds, f"The rule file '{rules.name}'")
    hint = f"{fault.hint} A number gets a name under [threshold].".strip()
    raise InputError(Fault(fault.message, rules.files[-1] if rules.files else None, hint=hint))


def _run(rules: RuleSet, inputs: ReflexInput) -> Steps:
    """The rules over all samples; a stretch of one mode in one go."""
    backend, table = choose_backend(), lower_rules(rules.rules)
    values, found = table.start(), []
    edges = [0, *(i for i in range(1, len(inputs.t)) if inputs.modes[i] != inputs.modes[i - 1]), len(inputs.t)]
    for a, b in pairwise(edges):
        if a == b:
            continue
        values[table.part("enabled")] = [not rule.modes or inputs.modes[a] in rule.modes for rule in rules.rules]
        found.append(backend.batch_time(table, np.ascontiguousarray(inputs.x[a:b]), inputs.t[a:b].copy(), values))
    count = len(rules.rules)
    return Steps(
        winner=np.concatenate([np.empty(0, np.int32), *(steps.winner for steps in found)]),
        mask=np.concatenate([np.empty((0, count), bool), *(steps.mask for steps in found)]),
        margin=np.empty((len(inputs.t), 0)),
    )


def _panels(rule: Rule, inputs: ReflexInput) -> dict[str, list[Compared]]:
    panels: dict[str, list[Compared]] = {}
    for guard in [rule.when, *([] if rule.until is None else [rule.until])]:
        for node in guard.node.walk():
            if node.op != "compare" or node.args[0].kind.dimension is None:
                continue
            for left, right in pairwise(node.args):
                if left.constant and not right.constant:
                    left, right = right, left
                sides = [_series(side, inputs) for side in (left, right)]
                if sides[0] is not None and sides[1] is not None:
                    compared = Compared(left.text, right.text, sides[0], sides[1], releases=guard is rule.until)
                    panels.setdefault(str(left.kind.dimension), []).append(compared)
    return panels


def _series(node: Node, inputs: ReflexInput) -> Series | None:
    """A side of a comparison over time, (n,), or (n, k) of a group that is read as it is; None of another group."""
    if node.op == "read":
        return inputs.x[:, node.start : node.stop] if node.kind.size else inputs.x[:, node.start]
    if node.kind.size:
        return None
    side = compile_node(node)
    values = [side(x, t) for x, t in zip(inputs.x, inputs.t.tolist(), strict=True)]
    return np.array([np.nan if value is None else float(value) for value in values])
