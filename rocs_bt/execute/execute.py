"""Execute: block of MAPE-K that runs the actions in the pipeline, period by period (paper, 4.2 and 5.2)."""

from __future__ import annotations

import threading
from collections.abc import Callable

from ..base.errors import DeviceError, InputError, PipelineError, interrupts
from ..base.raised import Raised, from_actuator, owners_of
from ..event import AtomicStarted
from ..interfaces.action import Action, ActionFailed, AtomicAction, Failure, MacroAction, Progress, Reason
from ..interfaces.pipeline import Pipeline, Priority, Ticket
from .body import RobotBody
from .decomposer import ActionDecomposer

BehaviorPipeline = Pipeline
"""The paper's name of Pipeline, which is a module of Execute there."""

MAX_TRANSITIONS = 16
"""Maximum number of actions of one ticket that may end in one period without a command."""

_ROUTES = {Priority.HIGH: "reactive", Priority.NORMAL: "deliberative"}


class AtomicActionExecutor:
    """Runs atomic actions on the robot's body, and emits an event when an action starts."""

    def __init__(self, body: RobotBody) -> None:
        self._body = body
        self._begun: AtomicAction | None = None

    def act(self, action: AtomicAction, ticket: int) -> Progress | Failure:
        """Run an action for one control period.

        Args:
            action: Atomic action.
            ticket: Number of the ticket to which the action belongs.

        Returns:
            Result of the action. If the action raises ActionFailed or InputError, this is returned as a Failure.

        Raises:
            PipelineError: The action returned neither a Progress nor a Failure.
        """
        if action is not self._begun:
            self._begun = action
            self._body.note(
                AtomicStarted,
                ticket=ticket,
                action=action.name,
                route=self._body.control_period.route,
                parameters=action.parameters,
            )
        period = self._body.control_period
        period.commanded, period.action = False, action.name
        try:
            result = action.act(self._body)
        except ActionFailed as error:
            return error.failure
        except InputError as error:
            return Failure.cannot(error)
        finally:
            period.action = ""
        if not isinstance(result, (Progress, Failure)):
            raise PipelineError(f"{action.name}.act must return a Progress or a Failure, it returned {result!r}.")
        return result


class Execute:
    """Execute block: runs the actions in the pipeline, one control period at a time.

    Each submitted action has a ticket, which holds its priority and state. Every period, Execute takes the ticket with
    the highest priority and runs one atomic action of it. A macro action is decomposed step by step: its next action is
    created when the previous one has succeeded.

    One action commands the actuators per period. If an action ends without a command, the next one runs in the same
    period, so that no period is lost. If it ends with a command, that command lasts until the end of the period.

    A command lasts one period: an actuator without a command in a period goes to neutral at its end. Neutral is sent
    (and recorded as a command of zeros) once, not in every idle period.

    Args:
        pipeline: Pipeline of the submitted actions.
        body: Body of the robot.

    Attributes:
        broken: Whether Execute itself failed. It is set before the ticket fails, so that the plan does not react to
            that failure.
        on_exception: Handler of exceptions that actions raise; None to raise them.
    """

    def __init__(self, pipeline: Pipeline, body: RobotBody) -> None:
        self.pipeline = pipeline
        self.broken = False
        self.on_exception: Callable[[Raised], None] | None = None
        self._body = body
        self._executor = AtomicActionExecutor(body)
        self._ticket: Ticket | None = None
        self._decomposer: ActionDecomposer | None = None
        self._acting: AtomicAction | None = None
        self._steps = 0
        self._lock = threading.Lock()
        self._closed = False

    def prepare(self) -> None:
        """Build what the first motion needs; on wall time no control period may wait for it."""
        self._body.follower.prepare()

    @property
    def route(self) -> str:
        """Source of the action in this period: `reactive`, `deliberative`, or `idle` without an action."""
        return self._body.control_period.route

    @property
    def running(self) -> Ticket | None:
        """Ticket of the running action; None if idle."""
        return self._ticket

    def run(self, t: float) -> None:
        """Run one control period. Other threads may submit and cancel actions meanwhile.

        An ActionFailed, an InputError (CANNOT) or a DeviceError (REFUSED) fails the action that raised it. At any other
        exception of an action the actuators go to neutral, then the ticket fails (RAISED), and `on_exception` is
        called. Exceptions outside of actions propagate to the agent.

        Args:
            t: Present time [s].
        """
        with self._lock:
            period = self._body.control_period
            period.route, period.open, self._steps = "idle", True, 0
            if self._closed:  # checked after `open` was set, since another thread may call `close` in between
                period.open = False
                return
            self._body.trail.add(self._body.knowledge.robot.pose(t))
            try:
                self._handling(self.pipeline.settle)
                self._serve()
            except BaseException as error:  # stop the wheels first
                self._body.neutral()
                if not self._handle(error, self._ticket):
                    self.broken = True
                    self._end(Failure(Reason.OTHER, f"it raised {type(error).__name__}: {error}"))
                    raise
            finally:
                self._body.settle()

    def close(self) -> None:
        """Send all actuators to neutral, once, and block all later commands; thread-safe."""
        if not self._closed:
            self._closed = True
            self._body.control_period.open = False
            self._body.neutral()

    def stop(self, by: str) -> None:
        """Send all actuators to neutral and cancel every ticket; thread-safe.

        If an action is running in another thread, its commands are dropped, and the next `run` calls its `stop`.
        Otherwise this method calls it.

        Args:
            by: Cause of the cancellation.
        """
        self._body.control_period.open = False
        try:
            if not self._closed:
                self._body.neutral()
        finally:
            self.pipeline.clear(by)
            if self._lock.acquire(blocking=False):
                try:
                    self._drop()
                finally:
                    self._lock.release()
        self._body.control_period.route = "idle"

    def _serve(self) -> None:
        while self._switch():
            if self._steps == MAX_TRANSITIONS:
                evidence = f"{MAX_TRANSITIONS} actions in one period without a command"
                self._end(Failure(Reason.RUNAWAY, evidence))
                continue
            self._steps += 1
            try:
                over = self._advance()
            except ActionFailed as error:
                self._end(error.failure)
            except InputError as error:  # raised by a `decompose` that is no generator
                self._end(Failure.cannot(error))
            except DeviceError as error:
                self._body.neutral()
                self._end(Failure(Reason.REFUSED, str(error)))
                return
            else:
                if over:
                    return

    def _switch(self) -> bool:
        """Switch to the ticket with the highest priority; False if the pipeline is empty.

        The action of a cancelled ticket is stopped first, before another action sends commands.
        """
        while True:
            if self._ticket is not None and self._ticket.state.done:
                self._drop()
            top = self.pipeline.top()
            if top is None:
                self._body.control_period.route = "idle"
                return False
            if top is not self._ticket and self.pipeline.start(top):
                self._ticket, self._decomposer, self._acting, self._steps = top, None, None, 0
            if top is self._ticket:
                self._body.control_period.route = _ROUTES[top.priority]
                return True

    def _advance(self) -> bool:
        """Run the atomic action once; returns whether Execute has finished this period."""
        ticket = self._ticket
        if ticket is None:
            return True
        if self._decomposer is None:
            self._decomposer = ActionDecomposer(ticket.action, self._body)
        atomic = self._acting = self._decomposer.next()
        if atomic is None:
            self._end(None)
            return False
        result = self._executor.act(atomic, ticket.number)
        if ticket.state.done:  # cancelled during `act`: it is stopped before another action runs
            return self._body.control_period.commanded
        if isinstance(result, Failure):
            self._body.withdraw()
            self._decomposer.failed(result)
            return False
        if result is result.RUNNING:
            return True
        if self._decomposer.nested:
            self._decomposer.succeeded()
        else:
            self._end(None)
        return self._body.control_period.commanded

    def _end(self, failure: Failure | None) -> None:
        """End the ticket, with success if `failure` is None; if the ticket was cancelled, stop its actions instead."""
        ticket, decomposer = self._ticket, self._decomposer
        if ticket is None:
            return
        ended = self.pipeline.succeed(ticket) if failure is None else self.pipeline.fail(ticket, failure)
        if not ended:
            self._drop()
            return
        self._ticket = self._decomposer = None
        if decomposer is not None:
            self._handling(decomposer.close, ticket)

    def _drop(self) -> None:
        """Stop the actions of a cancelled ticket, once; an exception does not block the next ticket."""
        ticket, decomposer = self._ticket, self._decomposer
        self._ticket = self._decomposer = None
        if decomposer is not None:
            self._handling(decomposer.cancel, ticket)

    def _handling(self, step: Callable[[], None], ticket: Ticket | None = None) -> None:
        """Call a function that runs code of an action, and handle an exception of the action."""
        try:
            step()
        except BaseException as error:  # an action may raise anything
            if interrupts(error):
                raise
            if not self._handle(error, ticket):
                raise

    def _handle(self, error: BaseException, ticket: Ticket | None) -> bool:
        """Report the exception of an action and fail its ticket; False if no action raised it."""
        if self.on_exception is None or from_actuator(error) or interrupts(error):
            return False
        action = next((each for each in owners_of(error) if isinstance(each, Action)), None)
        if action is None and ticket is not None:  # the engine refused a returned or yielded value
            action = self._acting or ticket.action
        if action is None:
            return False
        reflex = ticket is not None and ticket.priority is Priority.HIGH
        # An engine action has no line of content, but the macro-action of content that yielded it has.
        lines = self._decomposer.lines() if self._decomposer is not None else ()
        kind = "reflex action" if reflex else "action"
        raised = Raised.of(kind, action.name, error, _step_of(action), action, *lines)
        if ticket is not None:
            self._end(Failure(Reason.RAISED, str(raised)))
        self.on_exception(raised)
        return True


def _step_of(action: Action) -> object:
    """Method that implements an action: `decompose` or `act`."""
    if isinstance(action, MacroAction):
        return action.decompose
    return action.act if isinstance(action, AtomicAction) else action
