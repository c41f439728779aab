"""Open-loop evaluation of rule files on recordings: firing times of rules, and firing counts by threshold.

Open loop means that the rules are evaluated on the recorded signals, and that their reflexes have no effect on these.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..actions import ACTIONS
from ..agent.build import thresholds
from ..base.errors import Fault, InputError, UnknownName, unknown
from ..base.units import Dimension
from ..base.words import listed
from ..catalog import Catalog
from ..event import RuleChanged
from ..expression import Node, Values, reading
from ..reactive import Override, Rule, RuleSet, Steps, choose_backend, load_rules, lower_rules
from ..record import AgentInfo, Recording, environment_of, samples
from ..record.figures.rules import Compared, RuleTrace, spans
from ..record.fold.samples import modes, stopped
from ..record.fold.tracks import Tracks

Series = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ReflexInput:
    """Recorded input of one agent's reflexes.

    Attributes:
        run: Short name of the run, such as `exp1-1`.
        agent: Description of the agent in the recording.
        t: Times [s], shape (n,).
        x: Snapshots of the signals, shape (n, size).
        modes: Mode of the agent at each time, n values.
        latched: Times at which each rule latched in the run itself [s], by rule.
    """

    run: str
    agent: AgentInfo
    t: Series
    x: Series
    modes: tuple[str, ...]
    latched: Mapping[str, tuple[float, ...]]


@dataclass(frozen=True)
class Firing:
    """Interval in which a rule is latched when it is evaluated on a recording.

    Attributes:
        rule: Name of the rule.
        begin: Start of the interval [s].
        end: End of the interval [s].
        won: Time within the interval in which the rule wins over all others [s].
        reading: Guard values at the start of the interval.
    """

    rule: str
    begin: float
    end: float
    won: float
    reading: str


@dataclass(frozen=True, eq=False)
class RuleReplay:
    """Result of evaluating a rule file on a recording."""

    rules: RuleSet
    inputs: ReflexInput
    steps: Steps
    firings: tuple[Firing, ...]

    def traces(self) -> list[RuleTrace]:
        """Traces of all rules, for figures."""
        return [
            RuleTrace(rule.name, self.steps.mask[:, i], self.steps.winner == i, _panels(rule, self.inputs))
            for i, rule in enumerate(self.rules.rules)
        ]


def reflex_input(recording: Recording, agent: AgentInfo) -> ReflexInput:
    """Input of an agent's reflexes in a recorded run.

    Raises:
        RecordingError: The recording cannot be read, or lacks the agent's signals.
    """
    tracks, name = Tracks.of_recording(recording, ("pose", "signal", "stopped", "fact", "event")), agent.name
    environment_of(agent)
    t, x = samples(tracks, agent)
    felt = bisect_left(t, stopped(tracks, name))
    latched: dict[str, tuple[float, ...]] = {}
    for event in tracks.events:
        if isinstance(event, RuleChanged) and event.agent == name and event.phase == "latched":
            latched[event.rule] = (*latched.get(event.rule, ()), event.t)
    return ReflexInput(
        run=recording.header.label,
        agent=agent,
        t=np.array(t[:felt]),
        x=x[:felt],
        modes=tuple(modes(tracks, name, t[:felt])),
        latched=latched,
    )


def rules_for(file: Path, agent: AgentInfo, catalog: Catalog, own: Mapping[str, Override] | None = None) -> RuleSet:
    """Load a rule file for an agent of a recording, with the thresholds of its robot if the catalog has the robot.

    The thresholds `own` take precedence over those of the robot.

    Raises:
        InputError: The file is invalid, or does not fit the agent.
    """
    try:
        robot = catalog.load_robot(agent.robot)
    except UnknownName:  # the robot belongs to another project
        return load_rules(file, environment_of(agent), ACTIONS, overrides=own)
    environment = replace(environment_of(agent), robot=robot.constants)
    return load_rules(file, environment, ACTIONS, overrides={**thresholds(robot, file), **(own or {})})


def replay_rules(rules: RuleSet, inputs: ReflexInput) -> RuleReplay:
    """Evaluate rules on recorded input."""
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
    """Count the firings of a rule for different values of a threshold.

    Returns:
        Number of firings, shape (values, runs).

    Raises:
        InputError: Unknown rule, or a value with which the file does not load.
    """
    counts = np.zeros((len(values), len(inputs)))
    for i, value in enumerate(values):
        own = {threshold: Override(f"{value!r} {dimension}")}
        for k, each in enumerate(inputs):
            rules = rules_for(file, each.agent, catalog, own)
            index = rule_index(rule, rules)
            counts[i, k] = len(spans(each.t, _run(rules, each).mask[:, index]))
    return counts


def rule_index(rule: str, rules: RuleSet) -> int:
    """Index of a rule in its set, by its name with or without the file's name.

    Raises:
        UnknownName: There is no such rule, or it is inactive.
    """
    names = [r.name.rpartition("/")[2] for r in rules.rules]
    short = rule.rpartition("/")[2]
    for inactive in rules.inactive:
        if inactive.name.rpartition("/")[2] == short:
            lacks = f"the recorded robot has no signal {listed(inactive.missing)}"
            raise UnknownName(Fault(f"rule {short} is inactive: {lacks}."))
    if short not in names:
        raise UnknownName(unknown("rule", rule, names, f"The rule file '{rules.name}'"))
    return names.index(short)


def threshold_dimension(threshold: str, rules: RuleSet) -> Dimension:
    """Dimension of a threshold of a rule set.

    Raises:
        InputError: There is no such threshold.
    """
    if threshold in rules.dimensions:
        return rules.dimensions[threshold]
    fault = unknown("threshold", threshold, rules.thresholds, f"The rule file '{rules.name}'", _DECLARED)
    raise InputError(fault.at(rules.files[-1] if rules.files else None))


_DECLARED = "Thresholds are declared under [threshold]."


def _run(rules: RuleSet, inputs: ReflexInput) -> Steps:
    """Evaluate the rules on all samples, in batches of constant mode."""
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
    """Values of one side of a comparison over time.

    Returns:
        Values, shape (n,), or (n, k) for a signal group of k values; None for other expressions of groups.
    """
    if node.op == "read":
        return inputs.x[:, node.start : node.stop] if node.kind.size else inputs.x[:, node.start]
    if node.kind.size:
        return None
    return Values([node])(inputs.x, inputs.t)[0]
