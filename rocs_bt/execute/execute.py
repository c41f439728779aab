"""Execute: the engine that serves the pipeline, one control period at a time (paper, 4.2 and 5.2)."""

from __future__ import annotations

import threading
from collections.abc import Callable

from ..action import Action, ActionFailed, AtomicAction, Failure, MacroAction, Progress, Reason
from ..errors import DeviceError, InputError, PipelineError, interrupts
from ..event import AtomicStarted
from ..pipeline import Pipeline, Priority, Ticket
from ..raised import Raised, from_actuator, owners_of
from .body import RobotBody
from .decomposer import ActionDecomposer

BehaviorPipeline = Pipeline
"""The paper's name for the module of Execute that keeps the submitted actions."""

MAX_TRANSITIONS = 16
"""How often one ticket may go on to a next action within one period without commanding anything."""

_ROUTES = {Priority.HIGH: "reactive", Priority.NORMAL: "deliberative"}


class AtomicActionExecutor:
    """Acts atomic actions on a body, and notes where each begins.

    Args:
        body: The robot.
    """

    def __init__(self, body: RobotBody) -> None:
        self._body = body
        self._begun: AtomicAction | None = None

    def act(self, action: AtomicAction, ticket: int) -> Progress | Failure:
        """One control period's worth of it; an ActionFailed that it raises is its failure, and so is an InputError.

        Args:
            action: The action.
            ticket: The number of the ticket that it belongs to.

        Raises:
            PipelineError: It returned something else than Progress or a Failure.
        """
        if action is not self._begun:
            self._begun = action
            self._body.note(
                AtomicStarted,
                ticket=ticket,
                action=action.name,
                route=self._body.turn.route,
                parameters=action.parameters,
            )
        turn = self._body.turn
        turn.commanded, turn.action = False, action.name
        try:
            result = action.act(self._body)
        except ActionFailed as error:
            return error.failure
        except InputError as error:
            return Failure.cannot(error)
        finally:
            turn.action = ""
        if not isinstance(result, (Progress, Failure)):
            raise PipelineError(f"{action.name}.act must return a Progress or a Failure, it returned {result!r}.")
        return result


class Execute:
    """Takes the action on top, decomposes it lazily, acts the atomic one once, commands the actuators.

    In each period one action commands. An action that ends without having commanded makes way for the next one in the
    same period, so that no period is lost between two; what ended with a command keeps it until the period is over.

    Nothing keeps its last command: an actuator that nobody commanded in a period goes to neutral at its end. That is
    said (and recorded as a command of zeros) once, not again in every idle period.

    Args:
        pipeline: Where actions are submitted.
        body: The robot.

    Attributes:
        broken: Whether Execute itself failed; true before its ticket fails, so that no decision is made on that.
        on_exception: Takes the exceptions of actions; None to raise them instead.
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

    @property
    def route(self) -> str:
        """Who acts in this period: `reactive`, `deliberative`, or `idle` when nobody does."""
        return self._body.turn.route

    @property
    def running(self) -> Ticket | None:
        """The ticket that is being served."""
        return self._ticket

    def run(self, t: float) -> None:
        """One control period. Safe with submissions and cancellations from other threads.

        An ActionFailed, an InputError (CANNOT) or a DeviceError (REFUSED) fails the action that raises it. At any other
        exception the actuators go to neutral first, then the ticket fails (RAISED), and `on_exception` is called. What
        no action raised goes on to the agent.
        """
        with self._lock:
            turn = self._body.turn
            turn.route, turn.open, self._steps = "idle", True, 0
            if self._closed:  # asked after the gate was opened: whoever closes it meanwhile shuts it again
                turn.open = False
                return
            try:
                self._taking(self.pipeline.settle)
                self._serve()
            except BaseException as error:  # the wheels stop first, whatever it is
                self._body.neutral()
                if not self._taken(error, self._ticket):
                    self.broken = True
                    self._end(Failure(Reason.OTHER, f"it raised {type(error).__name__}: {error}"))
                    raise
            finally:
                self._body.settle()

    def close(self) -> None:
        """Let all actuators go to neutral, once, and command nothing any more; may be called from any thread."""
        if not self._closed:
            self._closed = True
            self._body.turn.open = False
            self._body.neutral()

    def stop(self, by: str) -> None:
        """Let all actuators go to neutral and cancel every ticket; may be called from any thread.

        Commands of an action that is in mid-act on another thread are dropped; its `stop` is then called by the next
        `run`, and here otherwise.

        Args:
            by: Who stops.
        """
        self._body.turn.open = False
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
        self._body.turn.route = "idle"

    def _serve(self) -> None:
        while self._switch():
            if self._steps == MAX_TRANSITIONS:
                evidence = f"{MAX_TRANSITIONS} actions in one period, and none commanded"
                self._end(Failure(Reason.RUNAWAY, evidence))
                continue
            self._steps += 1
            try:
                over = self._advance()
            except ActionFailed as error:
                self._end(error.failure)
            except InputError as error:  # from a `decompose` that is no generator
                self._end(Failure.cannot(error))
            except DeviceError as error:
                self._body.neutral()
                self._end(Failure(Reason.REFUSED, str(error)))
                return
            else:
                if over:
                    return

    def _switch(self) -> bool:
        """Make the ticket on top the one that is served; False when there is nothing to serve.

        A ticket that was cancelled is stopped here, before anything else may command.
        """
        while True:
            if self._ticket is not None and self._ticket.state.done:
                self._drop()
            top = self.pipeline.top()
            if top is None:
                self._body.turn.route = "idle"
                return False
            if top is not self._ticket and self.pipeline.start(top):
                self._ticket, self._decomposer, self._acting, self._steps = top, None, None, 0
            if top is self._ticket:
                self._body.turn.route = _ROUTES[top.priority]
                return True

    def _advance(self) -> bool:
        """Act the atomic action once; True if this period is over with that."""
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
        if ticket.state.done:  # cancelled in mid-act: it is stopped before anything else acts
            return self._body.turn.commanded
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
        return self._body.turn.commanded

    def _end(self, failure: Failure | None) -> None:
        """The ticket succeeded or failed; if it was cancelled in the meantime its actions are stopped instead."""
        ticket, decomposer = self._ticket, self._decomposer
        if ticket is None:
            return
        ended = self.pipeline.succeed(ticket) if failure is None else self.pipeline.fail(ticket, failure)
        if not ended:
            self._drop()
            return
        self._ticket = self._decomposer = None
        if decomposer is not None:
            self._taking(decomposer.close, ticket)

    def _drop(self) -> None:
        """Stop a cancelled ticket's actions, once. One that raises does not keep the next ticket from being served."""
        ticket, decomposer = self._ticket, self._decomposer
        self._ticket = self._decomposer = None
        if decomposer is not None:
            self._taking(decomposer.cancel, ticket)

    def _taking(self, step: Callable[[], None], ticket: Ticket | None = None) -> None:
        """Run a step in which an action of a ticket that is not served may raise."""
        try:
            step()
        except BaseException as error:  # an action may raise anything
            if interrupts(error):
                raise
            if not self._taken(error, ticket):
                raise

    def _taken(self, error: BaseException, ticket: Ticket | None) -> bool:
        """Report the exception of an action and fail its ticket; False if no action raised it."""
        if self.on_exception is None or from_actuator(error) or interrupts(error):
            return False
        action = next((each for each in owners_of(error) if isinstance(each, Action)), None)
        if action is None and ticket is not None:  # the engine refuses what the action returned or yielded
            action = self._acting or ticket.action
        if action is None:
            return False
        reflex = ticket is not None and ticket.priority is Priority.HIGH
        # An action of the engine has no line of content; the macro-action of content that yielded it has.
        lines = self._decomposer.lines() if self._decomposer is not None else ()
        kind = "reflex action" if reflex else "action"
        raised = Raised.of(kind, action.name, error, _step_of(action), action, *lines)
        if ticket is not None:
            self._end(Failure(Reason.RAISED, str(raised)))
        self.on_exception(raised)
        return True


def _step_of(action: Action) -> object:
    """The method that does an action's work."""
    if isinstance(action, MacroAction):
        return action.decompose
    return action.act if isinstance(action, AtomicAction) else action
