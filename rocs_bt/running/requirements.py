"""Check of requirements over a run, from events only: a run and its recording give equal findings."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..base.errors import Fault, InputError
from ..base.files import read_text
from ..catalog import ScenarioSpec
from ..declare import location_of
from ..event import AgentStopped, BodyMoved, Event, EventSink, NullSink, RequirementViolated, SignalsWritten
from ..expression import Environment, Expression, Requirement, parse_requirement, reading
from ..record import AgentInfo, Finding, Recording, RequirementInfo, RunHeader, environment_of
from ..record.fold.samples import SAMPLE_TOPICS, Newest
from ..record.fold.tracks import Tracks

_SLACK = 1e-9  # [s]


class _Check:
    """Incremental check of one requirement of one agent."""

    def __init__(self, info: RequirementInfo, requirement: Requirement) -> None:
        self.info = info
        self.violated: float | None = None
        self.margin = math.nan
        self._worst: float | None = None
        self._x: NDArray[np.float64] | None = None  # sample of the violation, else of the minimum margin
        self._requirement = requirement
        self._expression = Expression(requirement.node, margins=True)
        self._samples = self._unknown = 0
        self._start: float | None = None
        self._last: tuple[float, float | bool | None] = (0.0, None)

    def update(self, t: float, x: NDArray[np.float64]) -> bool:
        """Process a sample of the signals; returns True if it is the first to violate an `always` requirement."""
        if self._start is None:
            self._start = t
        value, about = self._expression(x, t), t - self._requirement.delay
        if about < self._start - _SLACK:
            return False
        self._last = about, value
        if not self._requirement.always:
            self.margin, self._worst, self._x = self._expression.margin, about, x
            self._samples, self._unknown = 1, int(value is None)
            return False
        self._samples += 1
        self._unknown += value is None
        margin = self._expression.margin
        if not math.isnan(margin) and not margin >= self.margin:
            self.margin, self._worst = margin, about
            self._x = self._x if self.violated is not None else x
        if value is None or value or self.violated is not None:
            return False
        self.violated, self._x = about, x
        return True

    def signals(self, agents: Mapping[str, AgentInfo]) -> set[str]:
        """Signals of the agent that the requirement reads."""
        environment = environment_of(agents[self.info.agent], truth=True)
        starts = {node.start for node in self._requirement.node.walk() if node.op == "read"}
        signals = agents[self.info.agent].signals
        return {s.name for s in signals if any(0 <= start - environment.offsets[s.name] < s.size for start in starts)}

    def end(self) -> bool:
        """Finish after the last sample; returns True if a requirement on the end of the run is violated."""
        about, value = self._last
        if self._requirement.always or value is not False:
            return False
        self.violated = about
        return True

    @property
    def reading(self) -> str:
        """Values at the violation, else at the minimum margin; empty if they are those of several samples."""
        requirement, x = self._requirement, self._x
        return "" if x is None or requirement.delay else reading(requirement.node, x.tolist())

    def finding(self) -> Finding:
        known = self._samples > 0 and not self._unknown
        verdict = "violated" if self.violated is not None else "satisfied" if known else "unknown"
        return Finding(
            name=self.info.name,
            require=self.info.text,
            verdict=verdict,
            margin=self.margin if math.isfinite(self.margin) else None,
            unit=_unit(self._requirement),
            worst=None if math.isnan(self.margin) else self._worst,
            violated=self.violated,
            samples=self._samples,
            unknown=self._unknown,
            reading=self.reading,
        )


@dataclass
class _Agent:
    """Requirements of one agent.

    Attributes:
        newest: Newest sample of its signals.
        checks: Checks of its requirements.
        t: Time of the present control period [s]; None before the first.
        stopped: Whether the agent was stopped.
    """

    newest: Newest
    checks: list[_Check]
    t: float | None = None
    stopped: bool = False


class RequirementWatch:
    """Event sink that checks requirements.

    Args:
        requirements: Requirements of the agents.
        agents: Agents with their signals.
        sink: Sink for RequirementViolated events; it must not forward these events to this object.

    Raises:
        InputError: A requirement does not fit its agent.
    """

    def __init__(
        self, requirements: Iterable[RequirementInfo], agents: Iterable[AgentInfo], sink: EventSink | None = None
    ) -> None:
        self._sink = sink or NullSink()
        wanted, known = list(requirements), {agent.name: agent for agent in agents}
        checks: dict[str, list[_Check]] = {}
        for info in (r for r in wanted if r.agent in known):
            environment = environment_of(known[info.agent], truth=True)
            checks.setdefault(info.agent, []).append(_Check(info, _parsed(info.text, environment)))
        names = {name for own in checks.values() for check in own for name in check.signals(known)}
        # Topics without their truth are cheap; a requirement on truth alone follows no signals.
        header = RunHeader(scenario="", seed=0, agents=tuple(known.values()))
        self._tracks = Tracks(header, SAMPLE_TOPICS if names else ("pose", "truth", "stopped"), names)
        self._agents = {name: _Agent(Newest(self._tracks, known[name], names), own) for name, own in checks.items()}

    def emit(self, event: Event) -> None:
        """Process one event."""
        agent = self._agents.get(event.agent)
        if agent is None or agent.stopped:
            return
        if isinstance(event, (SignalsWritten, BodyMoved)) and not (agent.t is not None and event.t <= agent.t):
            self._update(event.t, agent)
            agent.t = event.t
        self._tracks.emit(event)
        if isinstance(event, AgentStopped):
            self._end(event.t, agent)

    def close(self) -> None:
        """Finish the checks after the last event; needed for a truncated recording, which lacks the agents' stops."""
        for agent in self._agents.values():
            if agent.t is not None and not agent.stopped:
                self._end(agent.t, agent)

    def of(self, agent: str) -> list[Finding]:
        """Findings for an agent's requirements, in the order of the requirements."""
        return [check.finding() for check in self._agents[agent].checks] if agent in self._agents else []

    def _update(self, t: float, agent: _Agent) -> None:
        """Check the sample of the period that is over."""
        if agent.t is not None:
            x = agent.newest.at(agent.t)
            for check in agent.checks:
                if check.update(agent.t, x):
                    self._report(t, check)

    def _end(self, t: float, agent: _Agent) -> None:
        self._update(t, agent)
        agent.stopped = True
        for check in agent.checks:
            if check.end():
                self._report(t, check)

    def _report(self, t: float, check: _Check) -> None:
        margin = check.margin if math.isfinite(check.margin) else None
        about = check.violated if check.violated is not None else t
        info = check.info
        self._sink.emit(
            RequirementViolated(
                t=t, agent=info.agent, requirement=info.name, about=about, margin=margin, reading=check.reading
            )
        )


def requirements_of(scenario: ScenarioSpec) -> tuple[RequirementInfo, ...]:
    """Requirements of a scenario, one entry per requirement and agent."""
    return tuple(
        RequirementInfo(name=r.name, agent=agent, text=r.require, doc=r.doc)
        for r in scenario.requirements
        for agent in (agent.name for agent in scenario.agents)
        if r.applies_to(agent)
    )


def check_recorded(
    recording: Recording, requirements: Sequence[RequirementInfo] | None = None
) -> Mapping[str, list[Finding]]:
    """Check requirements on a recording.

    Args:
        recording: Recording of a run.
        requirements: Requirements to check; by default those of the scenario at the time of the recording.

    Returns:
        Findings by agent.

    Raises:
        InputError: A requirement does not fit its agent.
        RecordingError: The recording cannot be read, or lacks an agent's signals.
    """
    header = recording.header
    watch = RequirementWatch(header.requirements if requirements is None else requirements, header.agents)
    for event in recording.events():
        watch.emit(event)
    watch.close()
    return {agent.name: watch.of(agent.name) for agent in header.agents}


def requirement_faults(scenario: ScenarioSpec, agent: str, environment: Environment) -> list[Fault]:
    """Faults in a scenario's requirements of one agent.

    Args:
        scenario: The scenario.
        agent: Name of the agent.
        environment: Signals of the agent and ground-truth signals.
    """
    faults: list[Fault] = []
    for spec in scenario.requirements:
        if not spec.applies_to(agent):
            continue
        try:
            parse_requirement(spec.require, environment)
        except InputError as error:
            _, line, column = location_of(spec, "require")
            start = _column(scenario.file, line, column, spec.require)
            for fault in error.faults:
                at = start + max(fault.column, 1) - 1 if start else column
                faults.append(Fault(fault.message, scenario.file, line, at, fault.hint))
    return faults


def _parsed(text: str, environment: Environment) -> Requirement:
    """Parse a requirement that has no file; its faults name its text and the column in it."""
    try:
        return parse_requirement(text, environment)
    except InputError as error:
        faults = (replace(f, message=f"in '{text}', column {max(f.column, 1)}: {f.message}") for f in error.faults)
        raise InputError(*faults) from error


def _column(file: Path, line: int, column: int, text: str) -> int:
    """Column of the text of a requirement in its line, 1-based; 0 if the line does not contain the text literally."""
    lines = read_text(file).splitlines()
    if not 0 < line <= len(lines):
        return 0
    found = [at for quote in "\"'" if (at := lines[line - 1].find(f"{quote}{text}{quote}", column - 1)) >= 0]
    return min(found) + 2 if found else 0


def _unit(requirement: Requirement) -> str:
    units = {str(n.args[0].kind.dimension) for n in requirement.node.walk() if n.op == "compare"}
    return units.pop() if len(units) == 1 else ""
