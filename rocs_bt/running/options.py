"""Options of a run."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol, TypedDict

import msgspec

from ..errors import InputError
from ..event import EventSink
from ..record import RunHeader, SubtreeSwap
from ..simulation.simulated_world import SimulatedWorld
from .command import Control
from .preflight import PreflightReport
from .stop_signals import StopSignals

MODES = ("lockstep", "threaded")

Build = Callable[..., Any]
"""Mission function: returns the tree or the Plan of a mission."""


class LiveView(EventSink, Protocol):
    """Live view of a run, such as `rocs_bt.studio.live.LivePage`."""

    def begin(self, header: RunHeader) -> None:
        """Show the start of a run."""
        ...


class RunOptions(msgspec.Struct, frozen=True, kw_only=True):
    """Options of a run, in simulation with `run` or on hardware with `drive`.

    `drive` does not accept `prepare`, `swaps`, `view` and `video`, which need a simulation. Its mode is always
    `threaded`.
    `wait`, `dry_run`, `confirm`, `go`, `preflight` and `notice` are for `drive` only.

    Attributes:
        seed: Seed of the episode.
        mode: `lockstep`: blocks and physics run by turns, repeatably. `threaded`: they run in threads, in real time.
        duration: Maximum duration [s]; that of the scenario if None.
        out: Folder for summary.json, run.mcap and report.html; None writes nothing.
        report: Whether to write report.html.
        btlog: Whether to write AGENT.btlog, which Groot2 replays, for each agent with a tree as its mission.
        missions: Mission functions that replace the scenario's, by agent.
        prepare: Function called with the simulated world before the agents are built; it may replace devices, for
            example to inject faults.
        sinks: Sinks for all events.
        progress: Function called once per control period with the time [s].
        watch_rules: Whether to reload rule files that change during the run; the run may then not be repeatable.
        knowledge: File that keeps knowledge from run to run: read before the run, and written during the run.
        swaps: Subtrees of missions that are replaced at given times.
        view: Whether to show MuJoCo's viewer.
        video: File for a video of the run.
        follow: Robot that the camera of the video follows; the whole world if empty.
        live: Live page of the run, with its context entered; the run then keeps pace with the wall clock.
        command: Command line that repeats this run, for the report; `rocs-bt run ...` or `rocs-bt drive ...` if empty.
        signals: Object that stores stop signals such as SIGTERM, for a caller that handles them after the run. If None,
            a signal has its usual effect, such as a KeyboardInterrupt, once the run has been ended properly.
        wait: Time for which `drive` waits for a missing sensor before it gives up [s].
        dry_run: Whether `drive` opens no actuator, so that no device gets any command, not even neutral.
        confirm: Whether the robots of `drive` start only when a person says go: `go`, or a driver by `Host.go`.
        go: Function that `drive` calls once per control period; returns whether a person said go since the last call.
        preflight: Observer of the preflight check of `drive`, called at each check.
        control: Source of the commands of a person during the run: pause, step, continue, swap, reload.
        full_control: Whether `drive` accepts commands other than a pause.
        notice: Function that `drive` calls with each notice, such as that a simulator's time stopped, or that a goal of
            an action may go on after the run.
    """

    seed: int = 1
    mode: str = "lockstep"
    duration: float | None = None
    out: Path | str | None = None
    report: bool = True
    btlog: bool = False
    missions: Mapping[str, Build] | None = None
    prepare: Callable[[SimulatedWorld], None] | None = None
    sinks: Sequence[EventSink] = ()
    progress: Callable[[float], None] | None = None
    watch_rules: bool = False
    knowledge: Path | None = None
    swaps: Sequence[SubtreeSwap] = ()
    view: bool = False
    video: Path | None = None
    follow: str = ""
    live: LiveView | None = None
    command: str = ""
    signals: StopSignals | None = None
    wait: float = 10.0
    dry_run: bool = False
    confirm: bool = False
    go: Callable[[], bool] | None = None
    preflight: Callable[[PreflightReport], None] | None = None
    notice: Callable[[str], None] | None = None
    control: Control | None = None
    full_control: bool = False

    def __post_init__(self) -> None:
        if self.mode not in MODES:
            raise InputError(f"unknown mode '{self.mode}'. Modes: {', '.join(MODES)}.")
        if self.follow and self.video is None:
            raise InputError(f"a camera that follows '{self.follow}' needs a video: name its file with --video FILE.")
        if not 0.0 <= self.wait < math.inf:
            raise InputError(f"the time to wait for sensors must be 0 s or more and finite, found {self.wait:g} s.")

    def refuse_simulation(self) -> None:
        """Refuse the options that need a simulated world.

        Raises:
            InputError: One of them is given.
        """
        given = {
            "prepare": self.prepare is not None,
            "swaps": bool(self.swaps),
            "view": self.view,
            "video": self.video is not None,
        }
        if names := [name for name, is_given in given.items() if is_given]:
            raise InputError(f"on hardware nothing is simulated: remove the option {' and '.join(names)}.")

    def refuse_hardware(self) -> None:
        """Refuse the options that need hardware.

        Raises:
            InputError: One of them is given.
        """
        given = {"dry_run": self.dry_run, "confirm": self.confirm, "go": self.go is not None}
        if names := [name for name, is_given in given.items() if is_given]:
            raise InputError(f"these options are for `drive` only: remove {' and '.join(names)}.")


class RunChanges(TypedDict, total=False):
    """Types of the keyword arguments that set the attributes of `RunOptions`."""

    seed: int
    mode: str
    duration: float | None
    out: Path | str | None
    report: bool
    btlog: bool
    missions: Mapping[str, Build] | None
    prepare: Callable[[SimulatedWorld], None] | None
    sinks: Sequence[EventSink]
    progress: Callable[[float], None] | None
    watch_rules: bool
    knowledge: Path | None
    swaps: Sequence[SubtreeSwap]
    view: bool
    video: Path | None
    follow: str
    live: LiveView | None
    command: str
    signals: StopSignals | None
    wait: float
    dry_run: bool
    confirm: bool
    go: Callable[[], bool] | None
    preflight: Callable[[PreflightReport], None] | None
    notice: Callable[[str], None] | None
    control: Control | None
    full_control: bool
