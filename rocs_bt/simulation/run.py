"""One call: a scenario to its outcome, its recording and its report (docs/architecture.md)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..catalog import Catalog, ScenarioSpec
from ..errors import InputError
from ..event import EventSink
from ..record.live import LivePage
from ..words import counted
from .header import run_command, with_scenery
from .memory import Memory
from .minds import Build
from .pace import Pace
from .ready_run import set_up
from .run_files import RunFiles
from .run_record import RunRecord
from .stage import Stage
from .stop_signals import EndedAtOnce, StopSignals

MODES = ("lockstep", "threaded")


@dataclass(frozen=True)
class RunResult:
    """What a run left behind.

    Attributes:
        summary: What summary.json holds (docs/architecture.md).
        recording: run.mcap; None where nothing was recorded.
        report: report.html; None where none was written.
        missing: What could not be written, as on a full disk, and why; a sentence each.
    """

    summary: Mapping[str, Any]
    recording: Path | None = None
    report: Path | None = None
    missing: tuple[str, ...] = ()

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
        return "\n".join([*lines, *self.missing])


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
    signals: StopSignals | None = None,
) -> RunResult:
    """Run a scenario.

    SIGINT, SIGTERM and SIGHUP end the run in order: wheels to neutral, outcome `interrupted`, all files written. Then
    the signal has its usual effect, such as a KeyboardInterrupt. A second signal ends it at once, without summary and
    report. If the engine fails on the way, or a disk is full, the files hold what there is.

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
        signals: The signals that end the run, of a caller who looks at them afterwards: `run` then returns.

    Raises:
        InputError: Something in the content is wrong; nothing was written.
        RocsError: The engine failed.
        KeyboardInterrupt: A signal ended the run.
    """
    catalog = catalog or Catalog.here()
    spec = catalog.load_scenario(scenario) if isinstance(scenario, str) else scenario
    if mode not in MODES:
        raise InputError(f"no mode is named '{mode}'. There are: {', '.join(MODES)}.")
    ready = set_up(spec, catalog, seed, mode, missions, prepare, watch_rules)
    files, stopping = RunFiles(None if out is None else Path(out)), StopSignals() if signals is None else signals
    summary: dict[str, Any] = {}
    failure: Exception | None = None
    with _telling(files), ExitStack() as last:
        try:
            with ExitStack() as stack:
                for agent in ready.agents:
                    stack.callback(agent.close)
                memory = Memory(knowledge, ready.agents)
                stack.callback(files.attempt, "the knowledge", memory.close)
                # Whatever may still refuse this run does so before an earlier one in the same folder is replaced.
                watch = _watchers(stack, ready.stage, progress, view, video, live)
                last.enter_context(stopping)
                if live is not None or out is not None:
                    again = command or run_command(spec.name, seed, mode, duration)
                    header = with_scenery(ready.header, spec, ready.stage, command=again, recalled=memory.recalled)
                    if live is not None:
                        live.begin(header)
                    files.begin(header, ready.agents if btlog else ())
                    stack.callback(files.abandon)
                heard = [*([] if live is None else [live]), *sinks]
                record = RunRecord(ready.header, files.recorder, heard, batched=ready.clock is None)
                stack.callback(record.flush)
                memory.keep(f"{spec.name}-{seed}", patient=ready.clock is None)
                episode = ready.episode(duration, record.before(watch), lambda: stopping.reason)
                try:
                    ready.play(episode, record.sink)
                except Exception as error:  # noqa: BLE001 - raised again when all files are written
                    failure = error
                files.attempt("the knowledge", memory.close)
                summary = ready.summary(record, episode, memory)
                files.end(summary)
        except Exception as error:
            if not summary:
                raise
            failure = failure or error  # such as a device that does not let go: the report comes all the same
        page = None
        try:
            page = files.report(summary) if report else None
        except Exception as error:  # noqa: BLE001 - a defect of the report must not lose the outcome
            failure = failure or error
    result = RunResult(summary, files.recording, page, tuple(files.missing))
    if failure is not None:
        failure.add_note(f"{result}" + ("" if page is None else f"\nReport: {page}"))
        raise failure
    if signals is None:
        stopping.deliver()
    return result


@contextmanager
def _telling(files: RunFiles) -> Iterator[None]:
    """Tell with the exception of a second signal which files it costs."""
    try:
        yield
    except EndedAtOnce as error:
        error.add_note(files.unfinished)
        raise


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
