"""One call: a scenario to its outcome, its recording and its report (docs/architecture.md)."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from ..agent import Agent, RuleWatch, ThreadedRunner
from ..catalog import Catalog, ScenarioSpec
from ..clock import WallClock
from ..errors import InputError
from ..event import Event, EventSink, Fanout
from ..plan import TreePlan
from ..plan.watch import BtLog
from ..record import AgentInfo, Recorder, Recording, environment_of, write_report
from ..record.live import LivePage
from ..words import counted
from .episode import Episode, Result
from .gathering import Gathering
from .header import agent_info, make_header, run_command, versions
from .memory import Memory
from .metrics import Metrics
from .minds import Build, build_minds
from .news import news_of
from .pace import Pace
from .requirements import RequirementWatch, requirement_faults, requirements_of
from .sink_thread import SinkThread
from .stage import Stage, set_stage

MODES = ("lockstep", "threaded")
RECORDING, SUMMARY, REPORT = "run.mcap", "summary.json", "report.html"


@dataclass(frozen=True)
class RunResult:
    """What a run left behind.

    Attributes:
        summary: What summary.json holds (docs/architecture.md).
        recording: run.mcap; None where nothing was recorded.
        report: report.html; None where none was written.
    """

    summary: Mapping[str, Any]
    recording: Path | None = None
    report: Path | None = None

    @property
    def success(self) -> bool:
        """Whether every agent succeeded."""
        return all(outcome == "success" for outcome in self.outcomes.values())

    @property
    def outcomes(self) -> dict[str, str]:
        """Each agent's outcome, by its name."""
        return {name: agent["outcome"] for name, agent in self.summary["agents"].items()}

    def __str__(self) -> str:
        lines = [f"{self.summary['scenario']}, seed {self.summary['seed']}, {self.summary['sim_time']:.1f} s simulated"]
        for name, agent in self.summary["agents"].items():
            reason = f": {agent['reason']}" if agent["reason"] else ""
            lines.append(
                f"{name} {agent['outcome']}{reason}; {agent['path_length']:.2f} m, "
                f"{counted(agent['collisions'], 'collision')}, {counted(agent['reflex_activations'], 'reflex', 'es')}, "
                f"{counted(agent['replans'], 're-plan')}"
            )
            lines += [f"  fault at {fault}" for fault in agent["faults"]]
        return "\n".join(lines)


class Relay:
    """A sink whose target is known only after those that emit into it have been built; it keeps what came before."""

    def __init__(self) -> None:
        self._early: list[Event] = []
        self.emit: Callable[[Event], None] = self._early.append

    def open(self, target: EventSink) -> None:
        """Hand over what came so far, and from now on everything at once."""
        for event in self._early:
            target.emit(event)
        self.emit = target.emit


def run(
    scenario: ScenarioSpec | str,
    catalog: Catalog | None = None,
    *,
    seed: int = 1,
    mode: str = "lockstep",
    out: Path | str | None = None,
    duration: float | None = None,
    report: bool = True,
    btlog: bool = False,
    view: bool = False,
    video: Path | None = None,
    live: LivePage | None = None,
    progress: Callable[[float], None] | None = None,
    missions: Mapping[str, Build] | None = None,
    prepare: Callable[[Stage], None] | None = None,
    sinks: Sequence[EventSink] = (),
    watch_rules: bool = False,
    knowledge: Path | None = None,
    command: str = "",
) -> RunResult:
    """Run a scenario.

    Args:
        scenario: A scenario, or its name or file.
        catalog: Where content is found; the project around the current folder by default.
        seed: The episode's seed.
        mode: `lockstep` or `threaded`.
        out: The folder for summary.json, run.mcap and report.html; None writes nothing.
        duration: The longest it may take [s]; the scenario's own by default.
        report: Whether to write report.html.
        btlog: Whether to write AGENT.btlog for each agent whose mission is a tree, which Groot2 replays.
        view: Show MuJoCo's viewer.
        video: Render a video to this file.
        live: Show the run in browsers, at the pace of the wall clock; it was entered.
        progress: Called once a control period with the time [s].
        missions: By agent, a mission's `build` to play instead of the scenario's.
        prepare: Called with the stage before the minds are built; it may replace devices, to break them in a test.
        sinks: More sinks for all events.
        watch_rules: Whether rule files that change meanwhile are read anew; such a run need not repeat.
        knowledge: A file of knowledge between runs: read before, and written as the agents go.
        command: What a person types to make this run again, for the report; `rocs-bt run ...` by default.

    Raises:
        InputError: Something in the content is wrong; nothing was written.
        RocsError: The engine failed.
    """
    catalog = catalog or Catalog.here()
    spec = catalog.load_scenario(scenario) if isinstance(scenario, str) else scenario
    if mode not in MODES:
        raise InputError(f"no mode is named '{mode}'. There are: {', '.join(MODES)}.")
    relay, metrics = Relay(), Metrics(a.name for a in spec.agents)
    clock = WallClock(running=False) if mode == "threaded" else None
    stage = set_stage(spec, catalog, seed, relay, clock=clock)
    if prepare is not None:
        prepare(stage)
    agents = stage_minds(spec, stage, catalog, relay, missions, seed)
    infos = _fitting(spec, agents)
    files = RuleWatch([(a.name, file) for a in agents for file in a.rule_files if watch_rules], stage.clock, relay)
    digest = catalog.digest(spec)
    with ExitStack() as stack:
        for agent in agents:
            stack.callback(agent.close)
        memory = Memory(knowledge, agents)
        stack.callback(memory.close)
        # Whoever may still refuse this run does so before an earlier one in the same folder is replaced.
        watch = _watchers(stack, stage, progress, view, video, live)
        if clock is None:  # in threaded mode nobody's control waits for a file
            watch = files.before(watch)
        again, recalled = command or run_command(spec.name, seed, mode, duration), memory.recalled
        header = partial(
            make_header, spec, stage, agents, seed=seed, mode=mode, command=again, digest=digest, recalled=recalled
        )
        if live is not None:
            live.begin(header())
        recorder = None
        if out is not None:
            recorder = Recorder(_emptied(Path(out)) / RECORDING, header())
            stack.callback(recorder.close)
            _log_trees(stack, agents if btlog else (), Path(out))
        gathering = Gathering(*([recorder] if recorder else []), metrics)  # in threaded mode events have a thread
        stack.callback(gathering.hand_on)
        told = Fanout(*([gathering] if clock is None else gathering.sinks), *([live] if live else []), *sinks)
        requirements = RequirementWatch(requirements_of(spec), infos, told)
        episode = Episode(
            stage.world,
            agents,
            stage.judges,
            movers=[*stage.movers, *news_of(spec, agents, stage)],
            wheels=stage.wheels,
            goals=stage.goals,
            control=spec.rate.control_rate,
            duration=spec.duration if duration is None else duration,
            sink=relay,
            watch=gathering.before(watch),
        )
        memory.keep(f"{spec.name}-{seed}", patient=clock is None)
        everybody = Fanout(*told.sinks, requirements) if spec.requirements else told
        result = _play(episode, agents, clock, relay, everybody, files)
        requirements.close()
        gathering.hand_on()
        memory.close()
        shared = {a.name: None if a.sharing is None else a.sharing.told() for a in agents}
        summary = {**_summary(spec, seed, mode, digest, result, metrics, requirements, shared), **memory.summary()}
        if recorder is not None:
            recorder.close(summary)
    return _keep(summary, None if out is None else Path(out), report)


def stage_minds(
    spec: ScenarioSpec,
    stage: Stage,
    catalog: Catalog,
    sink: EventSink,
    missions: Mapping[str, Build] | None = None,
    seed: int = 0,
) -> list[Agent]:
    """The minds of those on a stage."""
    return build_minds(
        spec,
        catalog,
        stage.robots,
        stage.sensors,
        stage.actuators,
        stage.sensor_rates,
        clock=stage.clock,
        sink=sink,
        seed=seed,
        timer=time.perf_counter,
        missions=missions,
    )


def _play(
    episode: Episode,
    agents: Sequence[Agent],
    clock: WallClock | None,
    relay: Relay,
    sink: EventSink,
    files: RuleWatch,
) -> Result:
    if clock is None:
        relay.open(sink)
        return episode.run()
    with SinkThread(sink) as thread, files:
        relay.open(thread)
        return episode.run_threaded(clock, [ThreadedRunner(agent, clock) for agent in agents])


def _log_trees(stack: ExitStack, agents: Sequence[Agent], folder: Path) -> None:
    for agent in agents:
        if isinstance(agent.plan, TreePlan):
            stack.callback(BtLog(folder / f"{agent.name}.btlog", agent.plan).close)


def _watchers(
    stack: ExitStack,
    stage: Stage,
    progress: Callable[[float], None] | None,
    view: bool,
    video: Path | None,
    live: LivePage | None,
) -> Callable[[float], bool]:
    """Everybody who looks at the run once a control period, as one; False when the viewer's window was closed."""
    watchers: list[Callable[[float], bool]] = []
    if view:
        from .viewer import Viewer

        watchers.append(stack.enter_context(Viewer(stage.world)))
    if video is not None:
        from .video import Video

        watchers.append(stack.enter_context(Video(stage.world, video)))
    if live is not None:
        watchers.append(Pace())

    def watch(t: float) -> bool:
        if progress is not None:
            progress(t)
        going = [watcher(t) for watcher in watchers]  # each of them looks, whatever the others say
        return all(going)

    return watch


def _fitting(spec: ScenarioSpec, agents: Sequence[Agent]) -> list[AgentInfo]:
    """What a recording says of the agents, whom the scenario's requirements fit.

    Raises:
        InputError: One does not, with every fault.
    """
    infos = [agent_info(spec, agent) for agent in agents]
    faults = [f for info in infos for f in requirement_faults(spec, info.name, environment_of(info, truth=True))]
    if faults:
        raise InputError(*dict.fromkeys(faults))
    return infos


def _summary(
    spec: ScenarioSpec,
    seed: int,
    mode: str,
    digest: str,
    result: Result,
    metrics: Metrics,
    requirements: RequirementWatch,
    shared: Mapping[str, Mapping[str, float] | None],
) -> dict[str, Any]:
    return {
        "scenario": spec.name,
        "seed": seed,
        "mode": mode,
        "versions": versions(),
        "content_hash": digest,
        "sim_time": result.sim_time,
        "wall_time": result.wall_time,
        "real_time_factor": result.real_time_factor,
        "trajectory_hash": result.trajectory_hash,
        "agents": {
            agent.name: {
                "robot": agent.robot,
                "mission": agent.mission,
                "rules": list(agent.rules),
                **metrics.of(agent.name),
                "sharing": shared[agent.name],
                "requirements": [finding.as_dict() for finding in requirements.of(agent.name)],
            }
            for agent in spec.agents
        },
    }


def _emptied(folder: Path) -> Path:
    """The folder, without what an earlier run left: a killed run must not lie beside a stranger's summary."""
    folder.mkdir(parents=True, exist_ok=True)
    for old in (folder / SUMMARY, folder / REPORT, *folder.glob("*.btlog")):
        old.unlink(missing_ok=True)
    return folder


def _keep(summary: Mapping[str, Any], out: Path | None, report: bool) -> RunResult:
    if out is None:
        return RunResult(summary)
    (out / SUMMARY).write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")
    recording, page = out / RECORDING, out / REPORT
    if not report:
        return RunResult(summary, recording)
    write_report(Recording.open(recording), summary, page)
    return RunResult(summary, recording, page)
