"""One call: a scenario to its outcome, its recording and its report (docs/architecture.md)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path

from ..catalog import Catalog, ScenarioSpec
from ..errors import InputError
from ..event import EventSink
from ..record.live import LivePage
from .header import run_command, with_scenery
from .memory import Memory
from .minds import Build
from .pace import Pace
from .ready_run import set_up
from .run_end import RunEnd, RunResult
from .run_record import RunRecord
from .stage import Stage
from .stop_signals import StopSignals

MODES = ("lockstep", "threaded")


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
    end = RunEnd(out, report, signals)
    with end.guarded() as stack:  # what is pushed on it is closed before the report is written
        end.listen()
        ready = set_up(spec, catalog, seed, mode, missions, prepare, watch_rules)
        for agent in ready.agents:
            stack.callback(agent.close)
        memory = Memory(knowledge, ready.agents)
        stack.callback(end.files.attempt, "the knowledge", memory.close)
        # Whatever may still refuse this run does so before an earlier one in the same folder is replaced.
        watch = _watchers(stack, ready.stage, progress, view, video, live)
        if live is not None or out is not None:
            again = command or run_command(spec.name, seed, mode, duration)
            header = with_scenery(ready.header, spec, ready.stage, command=again, recalled=memory.recalled)
            if live is not None:
                live.begin(header)
            end.files.begin(header, ready.agents if btlog else ())
            stack.callback(end.files.abandon)
        heard = [*([] if live is None else [live]), *sinks]
        record = RunRecord(ready.header, end.files.recorder, heard, batched=ready.clock is None)
        stack.callback(record.flush)
        memory.keep(f"{spec.name}-{seed}", patient=ready.clock is None)
        episode = ready.episode(duration, record.before(watch), lambda: end.signals.reason)
        end.attempt(lambda: ready.play(episode, record.sink))
        end.attempt(record.check)
        end.files.attempt("the knowledge", memory.close)
        end.summarise(ready.summary(record, episode, memory))
    return end.result()


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
