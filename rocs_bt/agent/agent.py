"""Agent: autonomic manager of one robot (paper, 4.1; docs/architecture.md).

An agent has exactly one Knowledge, Plan, Execute and Pipeline, and no global state, so several agents can run in one
process. Class Agent holds the blocks and defines their order of execution in lockstep mode; threaded mode runs the same
blocks.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from functools import partial

import numpy as np

from ..base.errors import ActuatorError, BlockError, InputError, interrupts
from ..base.raised import describe, raised_at
from ..event import AgentStopped, BlockFailed, SensorFailed, SwapRefused
from ..interfaces.service import Service
from ..knowledge import Knowledge
from ..plan import TreePlan
from ..trees.nodes import Node
from .exceptions import ContentExceptions
from .parts import AgentRuntime, Blocks, Rates, RobotDevices
from .reloadable_rules import ReloadableRules

PLAN_CLOSE_PERIODS = 3
"""Number of plan periods for which a stopping agent waits for the plan's last turn, before it skips closing it."""


class Agent:
    """MAPE-K loop of one robot, built by `build_agent`.

    Args:
        name: Name of the agent and of its robot's node in Knowledge.
        knowledge: Knowledge of the agent (K of MAPE-K).
        devices: Devices of the robot.
        blocks: Blocks of the agent.
        rates: Rates of the blocks.
        runtime: Clock and event sink of the run.
        reloadable_rules: Active rule files.
        sharing: Knowledge sharing with other agents; None without sharing.

    Attributes:
        monitors, analyzes, plan, execute, arc, pipeline: Blocks of the agent, as in `Blocks`.
        prompt: Analysers that run before the reflexes in lockstep mode.
        optional: Names of the monitors that have optional sensors only.
        reloadable_rules: Active rule files, which can be reloaded.
        failure: First block failure; None if no block failed.
        stopped: Whether the agent was stopped; a stopped agent cannot be restarted.
        reacted: Time of the last evaluation of the reflexes [s].
    """

    def __init__(
        self,
        name: str,
        knowledge: Knowledge,
        devices: RobotDevices,
        blocks: Blocks,
        rates: Rates,
        runtime: AgentRuntime,
        *,
        reloadable_rules: Sequence[ReloadableRules] = (),
        sharing: Service | None = None,
    ) -> None:
        self.name = name
        self.knowledge = knowledge
        self.sensors = devices.sensors
        self.actuators = devices.actuators
        self.monitors = tuple(blocks.monitors)
        self.analyzes = tuple(blocks.analyzes)
        self.optional = frozenset(
            monitor.name for monitor in self.monitors if all(m.optional for m in monitor.monitored)
        )
        self._monitors = [(f"monitor {m.name}", m) for m in self.monitors]
        self.prompt = tuple(a for a in self.analyzes if a.before_reflexes and not a.from_knowledge)
        self._prompt = [(f"analyze {a.name}", a) for a in self.prompt]
        self._analyzes = [(f"analyze {a.name}", a) for a in self.analyzes if a not in self.prompt]
        self.arc = blocks.arc
        self.pipeline = blocks.pipeline
        self.plan = blocks.plan
        self.execute = blocks.execute
        self.clock = runtime.clock
        self.rates = rates
        self.reloadable_rules = tuple(reloadable_rules)
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
        # Two locks, because a turn of the plan may hang: the failure of another block is reported all the same, by the
        # first thread that has one, while the others and `stop` wait for it.
        self._failing = threading.Lock()
        self._planning = threading.Lock()
        self._plan_closed = False

    @property
    def going(self) -> bool:
        """Whether the agent has neither failed nor been stopped; its blocks run only then."""
        return self.failure is None and not self.stopped

    @property
    def status(self) -> str:
        """Status of the mission: `RUNNING`, `SUCCESS` or `FAILURE`. It stays `RUNNING` if Execute failed."""
        if self.execute.broken:
            return "RUNNING"
        return "FAILURE" if self._exceptions.failure else self.plan.status

    @property
    def running(self) -> str:
        """What the mission is doing and for how long; empty if unknown."""
        return self.plan.running

    @property
    def reflex(self) -> str:
        """Name of the rule of the active reflex; empty if no reflex is active."""
        return self.arc.active or ""

    @property
    def held(self) -> bool:
        """Whether an action of the plan waits for the end of a reflex."""
        return self.pipeline.blocked

    @property
    def waiting(self) -> bool:
        """Whether the active reflex waits for something outside of the robot, such as a person."""
        return self.arc.waiting

    def reading(self, rule: str) -> str:
        """Guard values of a rule when it last fired, such as `min(front) = 0.21 m`; empty before its first firing."""
        return self.arc.reading(rule)

    @property
    def reason(self) -> str:
        """Reason of the failure of a block or of the mission; empty without a failure."""
        return str(self.failure) if self.failure is not None else self._exceptions.failure or self.plan.reason

    def step(self, count: int) -> None:
        """Run one control period in lockstep mode: all blocks, in the order of docs/architecture.md.

        If a block raises an exception, the wheels stop, and later calls do nothing.

        Args:
            count: Number of control periods since the start.
        """
        if not self.going:
            return
        t, block = self.clock.now(), ""
        try:
            if self.sharing is not None and self.sharing.due(t):
                block = "sharing"
                self.sharing.run(t)
            for block, monitor in self._monitors:  # noqa: B007 - `block` names the failed block below
                monitor.run(t, count)
            for block, analyze in self._prompt:  # noqa: B007 - `block` names the failed block below
                analyze.run(t)
            block = "reflexes"
            self.react(t)
            for block, analyze in self._analyzes:  # noqa: B007 - `block` names the failed block below
                analyze.run(t)
            block = "plan"
            if self.rates.plan.due(count) or self.plan.called:
                self.decide(t)
            block = "execute"
            self.execute.run(t)
        except BaseException as error:  # block boundary: any exception must stop the agent
            if interrupts(error):
                raise
            self._broke(block, error)

    def react(self, t: float) -> None:
        """Evaluate the reflexes on a new snapshot at time `t` [s]; may be called from the thread of any monitor."""
        self.arc.run(self.knowledge.signals.snapshot(t, np.empty(self.knowledge.signals.size)), t)
        self.reacted = t

    def decide(self, t: float) -> None:
        """Run one turn of Plan, unless Plan is closed, Execute failed, or content raised too many exceptions.

        If content raises an exception, it is reported and the robot brakes. Another thread may stop the agent during
        the turn.
        """
        with self._planning:
            if not (self._plan_closed or self.execute.broken or self._exceptions.failure):
                begun = self._timer()
                self._blaming(self.plan.run, t)
                self.pipeline.charge(self._timer() - begun)

    def swap(self, node: str, new: Node) -> bool:
        """Replace a subtree of the mission between two turns of Plan; see `TreePlan.swap`. Thread-safe.

        Args:
            node: Path or name of the subtree's root.
            new: Root of the new subtree, from `TreePlan.load`.

        Returns:
            False if Plan is in a turn and the subtree was not replaced. Else True, also if the agent has stopped or the
            subtree cannot be replaced, for which there is an event `SwapRefused`.
        """
        if not self._planning.acquire(blocking=False):
            return False
        try:
            if self.going and not self._plan_closed and isinstance(self.plan, TreePlan):
                self._blaming(self.plan.swap, node, new)
        except InputError as error:
            self._sink.emit(SwapRefused(t=self.clock.now(), agent=self.name, node=node, detail=str(error)))
        finally:
            self._planning.release()
        return True

    def _blaming(self, turn: Callable[..., None], *args: object) -> None:
        """Call a method of Plan and handle the exceptions of users' leaves, actions and planners; others propagate."""
        try:
            turn(*args)
        except BaseException as error:  # block boundary: any exception must stop the agent
            if interrupts(error):
                raise
            if (raised := self.plan.blame(error)) is None:
                raise
            self._exceptions.take(raised)

    def guarded(self, block: str, turn: Callable[..., None], *args: object) -> None:
        """Run a block once. If it raises an exception, also SystemExit, the wheels stop and the failure is recorded.

        Args:
            block: Name of the block, for the failure.
            turn: Function that runs the block.
            args: Arguments of the function.
        """
        if self.going:
            self._attempt(block, turn, *args)

    def _attempt(self, block: str, turn: Callable[..., None], *args: object) -> None:
        try:
            turn(*args)
        except BaseException as error:  # block boundary: any exception must stop the agent
            if interrupts(error):
                raise
            self._broke(block, error)

    def _broke(self, block: str, error: BaseException) -> None:
        if isinstance(error, SystemExit):
            self.fail(block, "ended", f"it raised SystemExit({error.code})", error)
        else:
            place = raised_at(error)
            self.fail(block, "raised", describe(error) + (f" ({place})" if place is not None else ""), error)

    def fail(
        self, block: str, kind: str, detail: str, cause: BaseException | None = None, *, owner: str = "engine"
    ) -> None:
        """Stop the wheels permanently, then report the failure. Thread-safe; only the first failure counts.

        Args:
            block: Name of the block or actuator.
            kind: Kind of the failure: `raised`, `ended` or `hung`.
            detail: Reason of the failure.
            cause: Exception that caused the failure, or None.
            owner: Owner of the failed code: `content` for an actuator, `engine` for a block; see `BlockFailed`.
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
        """Send all actuators to neutral permanently; thread-safe. Blocks keep running but cannot command anything."""
        self._attempt("execute", self.execute.close)
        self._shut()

    def hold(self, reason: str, source: str) -> None:
        """Hold all actuators in neutral until `resume` of the same source; thread-safe."""
        for actuator in self.actuators.values():
            with suppress(ActuatorError):  # it has stopped the agent
                actuator.hold(reason, source)

    def report_missing(self, block: str, reason: str) -> None:
        """Report that the optional sensors of a monitor give nothing; `block` is `monitor` and its name."""
        monitored = next(monitor.monitored for name, monitor in self._monitors if name == block)
        for each in monitored:
            name = each.sensor.name
            self._sink.emit(SensorFailed(t=self.clock.now(), agent=self.name, sensor=name, detail=reason))

    def resume(self, source: str, by: str) -> None:
        """Let the actuators move again after `hold`, unless another source holds them; thread-safe."""
        for actuator in self.actuators.values():
            actuator.release(by, source)

    def stop(self, by: str = "the end of the run") -> None:
        """Stop the wheels, then halt the plan and cancel all actions. The agent cannot be used afterwards.

        This also works after a failure. A second call does nothing.

        Args:
            by: Reason of the stop, for events.
        """
        with self._failing:  # wait until another thread has reported its failure
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
        """Close all devices, actuators first, then the knowledge sharing; each is closed even if another raises."""
        with ExitStack() as stack:
            if self.sharing is not None:
                stack.callback(self.sharing.close)
            for sensor in self.sensors.values():
                stack.callback(sensor.close)
            for actuator in self.actuators.values():
                stack.callback(actuator.close)

    def _close_plan(self) -> None:
        """Close the plan between two of its turns; a plan that hangs in a turn is not closed."""
        if not self._planning.acquire(timeout=PLAN_CLOSE_PERIODS * self.rates.plan.every * self.rates.control.period):
            return
        try:
            self._plan_closed = True
            self._blaming(self.plan.close)
        finally:
            self._planning.release()

    def _shut(self) -> str:
        """Send all actuators to neutral permanently; returns a text about those that raised an exception."""
        problems = ""
        for actuator in self.actuators.values():
            try:
                actuator.shut()
            except Exception as error:  # noqa: BLE001 - a faulty driver must not keep the next actuator from stopping
                problems += f"; and actuator '{actuator.name}' did not stop: {type(error).__name__}: {error}"
        return problems
