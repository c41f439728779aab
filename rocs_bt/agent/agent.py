"""Agent: the autonomic manager of one robot (paper, 4.1; docs/architecture.md).

Exactly one Knowledge, Plan, Execute and Pipeline by construction, and no global state, so several agents live in one
process. It holds the blocks and knows the order of effects; `lockstep` and `threaded` run the same blocks.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import partial

import numpy as np

from ..errors import ActuatorError, BlockError, interrupts
from ..event import AgentStopped, BlockFailed
from ..knowledge import Knowledge
from ..knowledge.share import Sharing
from ..raised import describe, raised_at
from .exceptions import ContentExceptions
from .parts import Blocks, Rates, RobotDevices, Runtime
from .rule_files import RuleFile

HALT = 3
"""Periods of the plan that its last turn may take before the agent stops without it."""


class Agent:
    """One robot's MAPE-K loop, built by `build_agent`.

    Args:
        name: The agent, and its robot's node in Knowledge.
        knowledge: K.
        devices: The devices of its robot.
        blocks: Its blocks.
        rates: Rates of the blocks.
        runtime: Clock and sink of the run.
        rule_files: The rule files in force.
        sharing: Keeps Knowledge the same as that of other agents; None where it is its own.

    Attributes:
        name: The agent, and its robot's node in Knowledge.
        knowledge: K.
        monitors: M, in the order of robot.toml.
        analyzes: A, in the order of robot.toml.
        plan: P.
        execute: E.
        arc: The reflex arc over all ReactiveModels.
        pipeline: The queue between them.
        rule_files: The rule files in force, which can be read anew.
        sharing: Keeps Knowledge the same as that of other agents; None where it is its own.
        failure: The block that failed, and why; None while all is well.
        stopped: Whether it was stopped; nothing comes after that.
        reacted: When the reflexes were last evaluated [s].
    """

    def __init__(
        self,
        name: str,
        knowledge: Knowledge,
        devices: RobotDevices,
        blocks: Blocks,
        rates: Rates,
        runtime: Runtime,
        *,
        rule_files: Sequence[RuleFile] = (),
        sharing: Sharing | None = None,
    ) -> None:
        self.name = name
        self.knowledge = knowledge
        self.sensors = devices.sensors
        self.actuators = devices.actuators
        self.monitors = tuple(blocks.monitors)
        self.analyzes = tuple(blocks.analyzes)
        self._monitors = [(f"monitor {m.name}", m) for m in self.monitors]
        self._analyzes = [(f"analyze {a.name}", a) for a in self.analyzes]
        self.arc = blocks.arc
        self.pipeline = blocks.pipeline
        self.plan = blocks.plan
        self.execute = blocks.execute
        self.clock = runtime.clock
        self.rates = rates
        self.rule_files = tuple(rule_files)
        self.sharing = sharing
        self.failure: BlockError | None = None
        self.stopped = False
        self.reacted = -math.inf
        self._sink = runtime.sink
        self._exceptions = ContentExceptions(name, self.pipeline, self.plan, self.clock, self._sink)
        for actuator in self.actuators.values():
            actuator.on_failure = partial(self._actuator_failed, actuator.name)
        self.plan.on_exception = self.execute.on_exception = self.arc.on_exception = self._exceptions.take
        self._timer = runtime.planning_timer
        self._failing = threading.Lock()
        self._planning = threading.Lock()
        self._plan_closed = False

    @property
    def going(self) -> bool:
        """Whether it has neither failed nor been stopped: only then do its blocks run."""
        return self.failure is None and not self.stopped

    @property
    def status(self) -> str:
        """The mission's: `RUNNING`, `SUCCESS` or `FAILURE`. What it makes of a broken Execute does not count."""
        if self.execute.broken:
            return "RUNNING"
        return "FAILURE" if self._exceptions.failure else self.plan.status

    @property
    def reflex(self) -> str:
        """Rule of the active reflex; empty while none is active."""
        return self.arc.active or ""

    @property
    def held(self) -> bool:
        """Whether an action of the plan waits for the end of a reflex."""
        return self.pipeline.blocked

    def reading(self, rule: str) -> str:
        """Guard of a rule with the values of its last firing, such as `min(front) = 0.21 m`; empty before the first."""
        return self.arc.reading(rule)

    @property
    def reason(self) -> str:
        """Why the mission, or a block, failed; empty while nothing did."""
        return str(self.failure) if self.failure is not None else self._exceptions.failure or self.plan.reason

    def step(self, count: int) -> None:
        """One control period in lockstep: the order of effects of docs/architecture.md.

        A block that raises stops the wheels; from then on nothing happens.

        Args:
            count: Control periods since the start; the clock says the same.
        """
        if not self.going:
            return
        t, block = self.clock.now(), ""
        try:
            if self.sharing is not None and self.sharing.due(t):
                block = "sharing"
                self.sharing.run(t)
            for block, monitor in self._monitors:  # noqa: B007 - told where it breaks
                monitor.run(t, count)
            block = "reflexes"
            self.react(t)
            for block, analyze in self._analyzes:  # noqa: B007 - told where it breaks
                analyze.run(t)
            block = "plan"
            if self.rates.plan.due(count) or self.plan.called:
                self.decide(t)
            block = "execute"
            self.execute.run(t)
        except BaseException as error:  # the boundary of a block: whatever it raises must stop it
            if interrupts(error):
                raise
            self._broke(block, error)

    def react(self, t: float) -> None:
        """Evaluate the reflexes on a fresh snapshot; may be called from any monitor's thread."""
        self.arc.run(self.knowledge.signals.snapshot(t, np.empty(self.knowledge.signals.size)), t)
        self.reacted = t

    def decide(self, t: float) -> None:
        """One turn of Plan; none once it is closed, Execute broke, or content raised beyond its limit.

        An exception of content is reported, and the robot brakes. Safe while another thread stops the agent.
        """
        with self._planning:
            if not (self._plan_closed or self.execute.broken or self._exceptions.failure):
                begun = self._timer()
                self._blaming(self.plan.run, t)
                self.pipeline.charge(self._timer() - begun)

    def _blaming(self, turn: Callable[..., None], *args: object) -> None:
        """Run a part of Plan; an exception that content raised goes no further."""
        try:
            turn(*args)
        except BaseException as error:  # the boundary of a block: whatever it raises must stop it
            if interrupts(error):
                raise
            if (raised := self.plan.blame(error)) is None:
                raise
            self._exceptions.take(raised)

    def guarded(self, block: str, turn: Callable[..., None], *args: object) -> None:
        """Run one turn of a block; if it raises or ends, stop the wheels first and keep the reason."""
        if self.going:
            self._attempt(block, turn, *args)

    def _attempt(self, block: str, turn: Callable[..., None], *args: object) -> None:
        try:
            turn(*args)
        except BaseException as error:  # the boundary of a block: whatever it raises must stop it
            if interrupts(error):
                raise
            self._broke(block, error)

    def _broke(self, block: str, error: BaseException) -> None:
        if isinstance(error, SystemExit):
            self.fail(block, "ended", f"it called for an exit ({error.code})", error)
        else:
            place = raised_at(error)
            self.fail(block, "raised", describe(error) + (f" ({place})" if place is not None else ""), error)

    def fail(
        self, block: str, kind: str, detail: str, cause: BaseException | None = None, *, owner: str = "engine"
    ) -> None:
        """Stop the wheels for good, then report the failure. Safe under threads; the first failure counts.

        Args:
            block: Name of the block or of the actuator.
            kind: `raised`, `ended` or `hung`.
            detail: Reason.
            cause: The exception.
            owner: `content` for an actuator, `engine` for a block; see `BlockFailed`.
        """
        detail += self._shut()
        with self._failing:
            if not self.going:
                return
            self.failure = BlockError(f"{self.name}/{block}", kind, detail, owner)
            self.failure.__cause__ = cause
            failed = BlockFailed(
                t=self.clock.now(), agent=self.name, block=block, kind=kind, detail=detail, owner=owner
            )
            self._sink.emit(failed)
            self.pipeline.clear(f"the failure of {failed.what}")

    def _actuator_failed(self, name: str, error: ActuatorError) -> None:
        self.fail(name, error.kind, str(error), error, owner="content")

    def brake(self) -> None:
        """Send all actuators to neutral for good, at once; from any thread. The blocks go on, and move nothing."""
        self._attempt("execute", self.execute.close)
        self._shut()

    def stop(self, by: str = "the end of the run") -> None:
        """Go to neutral, halt the plan and cancel everything, once; the agent may not be used after it.

        The wheels stop first, whatever the plan does. After a failure too: what runs is halted and stopped, so that
        every ticket and every node comes to its end.
        """
        with self._failing:  # a failure that another thread tells of is told to its end first
            if self.stopped:
                return
        self.brake()
        self._sink.emit(AgentStopped(t=self.clock.now(), agent=self.name, by=by))
        self._exceptions.close()
        self._attempt("plan", self._close_plan)
        self._attempt("execute", self.execute.stop, by)
        with self._failing:
            self.stopped = True
        if self.sharing is not None:
            self._attempt("sharing", self.sharing.halt, self.clock.now())

    def close(self) -> None:
        """Let go of all devices, actuators first, and of the peers that it shares with, whatever raises on the way."""
        with ExitStack() as stack:
            if self.sharing is not None:
                stack.callback(self.sharing.close)
            for sensor in self.sensors.values():
                stack.callback(sensor.close)
            for actuator in self.actuators.values():
                stack.callback(actuator.close)

    def _close_plan(self) -> None:
        """Close the plan between two of its turns; one that hangs is left alone."""
        if not self._planning.acquire(timeout=HALT * self.rates.plan.every * self.rates.control.period):
            return
        try:
            self._plan_closed = True
            self._blaming(self.plan.close)
        finally:
            self._planning.release()

    def _shut(self) -> str:
        """Send all actuators to neutral for good; tells of those that did not obey."""
        problems = ""
        for actuator in self.actuators.values():
            try:
                actuator.shut()
            except Exception as error:  # noqa: BLE001 - one that breaks its contract must not keep the next from stopping
                problems += f"; and actuator '{actuator.name}' did not stop: {type(error).__name__}: {error}"
        return problems
